//! The results of a benchmark as a table: a line for each family and robot.

use std::io::Write;

use super::{Ended, Row};
use crate::report::quantile;

/// Prints the table.
pub fn print(rows: &[Row], out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(
        out,
        "| family | robot | worlds | solved | no plan | no idea | budget | refused | error | nodes | per stance | ms | 95 % | worst ms |"
    )?;
    writeln!(
        out,
        "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    )?;
    let mut groups: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        let group = (row.robot.as_str(), row.family.as_str());
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (robot, family) in &groups {
        let of_group = |row: &&Row| row.robot == *robot && row.family == *family;
        let group: Vec<&Row> = rows.iter().filter(of_group).collect();
        let unsure = group.iter().any(|row| row.likely == Some(false));
        let mark = if unsure {
            " (not known to be feasible)"
        } else {
            ""
        };
        line(&format!("{family}{mark}"), robot, &group, out)?;
    }
    let mut robots: Vec<&str> = groups.iter().map(|g| g.0).collect();
    robots.dedup();
    for robot in robots {
        let group: Vec<&Row> = rows.iter().filter(|row| row.robot == robot).collect();
        line("**all**", robot, &group, out)?;
    }
    Ok(())
}

fn line(family: &str, robot: &str, rows: &[&Row], out: &mut dyn Write) -> std::io::Result<()> {
    let ended = |ended: Ended| rows.iter().filter(|row| row.ended == ended).count();
    let solved = || rows.iter().filter(|row| row.ended == Ended::Solved);
    let mut nodes: Vec<f64> = solved().map(|row| row.nodes as f64).collect();
    let each = |row: &&Row| row.nodes as f64 / row.stances.max(1) as f64;
    let mut per_stance: Vec<f64> = solved().map(each).collect();
    let mut ms: Vec<f64> = rows.iter().map(|row| row.planning_ms).collect();
    writeln!(
        out,
        "| {family} | {robot} | {} | {} | {} | {} | {} | {} | {} | {:.0} | {:.1} | {:.0} | {:.0} | {:.0} |",
        rows.len(),
        ended(Ended::Solved),
        ended(Ended::NoPlan),
        ended(Ended::Exhausted),
        ended(Ended::BudgetSpent),
        ended(Ended::Refused),
        ended(Ended::Error),
        quantile(&mut nodes, 0.5),
        quantile(&mut per_stance, 0.5),
        quantile(&mut ms, 0.5),
        quantile(&mut ms, 0.95),
        quantile(&mut ms, 1.0)
    )
}
