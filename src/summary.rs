//! What a user reads on the terminal after a search.

use std::io::Write;

use anyhow::Result;
use plan::Plan;
use planner::Status;
use surfaces::Face;

use crate::pipeline::PlanOutcome;
use crate::told::Told;

/// How many faces that serve no patch are printed where there is no plan.
const REASONS: usize = 6;

/// Prints what was found: surfaces, stances, sizes and times; where there is no plan, why.
pub fn print(planned: &PlanOutcome, told: &mut Told) -> Result<()> {
    for note in &planned.notes {
        told.note(note)?;
    }
    let required = &planned.plan.required;
    let (report, search) = (&planned.report, &planned.plan.search);
    told.fact("report", report)?;
    told.fact("unusable", &planned.unusable)?;
    let out: &mut dyn Write = told;
    faces(&planned.plan.faces, required.edge_sigmas, out)?;
    stances(&planned.plan, out)?;
    if planned.status != Status::Found {
        if let Some(unsolved) = &search.unsolved {
            list("what blocks the way:", &unsolved.reasons, out)?;
            list("what to try:", &unsolved.to_try, out)?;
        }
        unusable(&planned.unusable, out)?;
    }
    writeln!(
        out,
        "search: {} nodes, {} expanded, {} posture problems, {} threads",
        report.nodes_generated, report.nodes_expanded, search.candidates_solved, report.threads
    )?;
    if planned.status == Status::Found && planned.config.planner.improve > 0 {
        let changes = search.path_stances.saturating_sub(1);
        let (least, gap) = (
            search.changes_min,
            changes.saturating_sub(search.changes_min),
        );
        writeln!(
            out,
            "contact changes: {changes}, at least {least} (gap {gap})"
        )?;
    }
    if let Some(motion) = &planned.plan.motion {
        let (duration, samples) = (motion.duration_s, motion.samples);
        writeln!(out, "motion: {duration:.1} s in {samples} samples")?;
    }
    let stages = report.stages_ms.iter();
    let stages: Vec<String> = stages
        .map(|(stage, ms)| format!("{stage} {ms:.1}"))
        .collect();
    writeln!(out, "stages (ms): {}", stages.join(", "))?;
    if let Some(peak) = report.peak_memory_mb {
        writeln!(out, "peak memory: {peak:.0} MB")?;
    }
    Ok(())
}

/// Of a mesh of thousands of faces so many are told of by name, the largest.
const FACES_MAX: usize = 60;

/// Prints one line a face; insets are those of so many standard deviations.
pub fn faces(faces: &[Face], edge_sigmas: f64, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "{} faces:", faces.len())?;
    writeln!(
        out,
        "  {:<12} {:>7} {:>7} {:>7}  {:>6} {:>7} {:>7} {:>7}",
        "id", "x m", "y m", "z m", "tilt °", "area m²", "inset m", "rms mm"
    )?;
    let mut areas_m2: Vec<f64> = faces.iter().map(|face| face.region.area()).collect();
    areas_m2.sort_unstable_by(|a, b| b.total_cmp(a));
    let least_m2 = areas_m2.get(FACES_MAX).copied().unwrap_or(0.0);
    let told = faces.iter().filter(|face| face.region.area() >= least_m2);
    for face in told.take(FACES_MAX) {
        let p = face.X_WF.translation.vector;
        let tilt = face.normal_W().z.clamp(-1.0, 1.0).acos().to_degrees();
        let insets_m = face.edge_insets_m(edge_sigmas).concat();
        writeln!(
            out,
            "  {:<12} {:>7.3} {:>7.3} {:>7.3}  {:>6.1} {:>7.3} {:>7.3} {:>7.2}",
            face.id.as_str(),
            p.x,
            p.y,
            p.z,
            tilt,
            face.region.area(),
            insets_m.into_iter().fold(0.0, f64::max),
            1e3 * face.fit.map_or(0.0, |fit| fit.rms_m)
        )?;
    }
    match faces.len().saturating_sub(FACES_MAX) {
        0 => Ok(()),
        smaller => writeln!(out, "  and {smaller} smaller ones"),
    }
}

fn stances(plan: &Plan, out: &mut dyn Write) -> std::io::Result<()> {
    match &plan.search.unsolved {
        Some(unsolved) if unsolved.status != "refused" => {
            writeln!(out, "{}; the nearest that it came:", unsolved.sentence)?;
        }
        _ => writeln!(out, "a plan of {} stances:", plan.stances.len())?,
    }
    for stance in &plan.stances {
        let m = &stance.margins;
        let base: Vec<String> = stance.q.iter().take(3).map(|x| metres(*x)).collect();
        writeln!(
            out,
            "  {:>2} {:<30} base {}  torque {:>3.0} %  friction {:>3.0} %  clearance {}",
            stance.index,
            stance.change.to_string(),
            base.join(" "),
            100.0 * m.torque_use,
            100.0 * m.friction_use,
            m.clearance_m
                .map_or_else(|| "far".to_owned(), |d| format!("{:.0} mm", 1e3 * d))
        )?;
    }
    Ok(())
}

/// Lines under a title.
fn list(title: &str, lines: &[String], out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "{title}")?;
    lines.iter().try_for_each(|line| writeln!(out, "  {line}"))
}

/// Which faces serve which patches not, and why.
fn unusable(reasons: &[String], out: &mut dyn Write) -> std::io::Result<()> {
    for reason in reasons.iter().take(REASONS) {
        writeln!(out, "  {reason}")?;
    }
    match reasons.len().saturating_sub(REASONS) {
        0 => Ok(()),
        more => writeln!(out, "  and {more} more faces and patches that do not fit"),
    }
}

/// Metres to the centimetre, without the sign of a zero.
fn metres(x: f64) -> String {
    format!("{:.2}", (100.0 * x).round() / 100.0 + 0.0)
}
