//! `scandent bench`: worlds drawn from seeds, in families, and given scenes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use anyhow::{Context, Result, bail};
use scenes::worlds::families::{FAMILIES, Family};

use crate::argument;
use crate::bench::{self, Ended, Item, Row, table, world};
use crate::cli::Global;
use crate::config::Config;
use crate::interrupt;
use crate::output;
use crate::provenance::Inputs;
use crate::robot_files::{BesideUrdf, RobotFiles, Robots};
use crate::status::Status;
use crate::told::Told;

/// Robots of the drawn worlds where none is named.
const ROBOTS: [&str; 3] = ["builtin:hrp2", "builtin:quadruped", "builtin:hexapod"];

/// Flags of `bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenes to plan (scene.toml, or those that ship) in the place of drawn worlds
    scenes: Vec<String>,
    /// Draw worlds of this family only (repeatable): stairs-up, stairs-down, tilted-blocks, stones,
    /// gaps, ribs, clutter, wall, door, bridge, turn, ramp, bridge-turn, and, not known to be feasible,
    /// bar, low-door, hand-step, hand-corridor
    #[arg(long, value_name = "NAME", conflicts_with = "scenes")]
    family: Vec<String>,
    /// Worlds of each family
    #[arg(long, value_name = "N", default_value_t = 20)]
    count: u64,
    /// Seed of the first world; the others follow
    #[arg(long, value_name = "N", default_value_t = 1)]
    first: u64,
    /// A robot: builtin:NAME or a URDF file (repeatable; default: hrp2, quadruped, hexapod)
    #[arg(long, value_name = "URDF", conflicts_with = "scenes")]
    robot: Vec<String>,
    /// Named postures and pairs of links that may touch, of the one robot
    #[arg(long, value_name = "FILE.srdf", requires = "robot")]
    srdf: Option<PathBuf>,
    /// Contact patches of the one robot
    #[arg(long, value_name = "FILE.toml", requires = "robot")]
    contacts: Option<PathBuf>,
    /// Only every n-th world, from the i-th on: i/n
    #[arg(long, value_name = "I/N", value_parser = shard, default_value = "1/1")]
    shard: (usize, usize),
    /// Folder of the worlds and of results.jsonl
    #[arg(short, long, value_name = "FOLDER", value_parser = argument::folder, default_value = "out/bench")]
    output: PathBuf,
}

/// Plans in every world and writes `results.jsonl`, a line for each, and the worlds that were drawn.
///
/// # Errors
/// A family, robot or shard that makes no sense, a file that cannot be written. Worlds that cannot
/// be planned in are results.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let results = args.output.join("results.jsonl");
    output::check(&results)?;
    let items = if args.scenes.is_empty() {
        args.drawn(global)?
    } else {
        args.scenes.iter().map(|scene| given(scene)).collect()
    };
    let (first, of) = args.shard;
    let items: Vec<Item> = items.into_iter().skip(first - 1).step_by(of).collect();
    let robots = Robots::default();
    let mut rows: Vec<Row> = Vec::new();
    let mut lines = Vec::new();
    for (number, item) in items.iter().enumerate() {
        let row = bench::run(item, global, &robots);
        if interrupt::listen().load(Ordering::Relaxed) {
            bail!("interrupted at {}; no results are written", item.name);
        }
        told.done(&format!(
            "{}/{} {}",
            number + 1,
            items.len(),
            sentence(&row)
        ))?;
        serde_json::to_writer(&mut lines, &row)?;
        lines.push(b'\n');
        rows.push(row);
    }
    output::write(&results, &lines)?;
    writeln!(told)?;
    table::print(&rows, told)?;
    told.fact("worlds", &rows)?;
    told.written(&results)?;
    let flawed = |row: &Row| matches!(row.ended, Ended::Refused | Ended::Error);
    Ok(if rows.iter().any(flawed) {
        Status::Failed
    } else {
        Status::Done
    })
}

pub(super) fn sentence(row: &Row) -> String {
    let ended = match row.ended {
        Ended::Solved => format!("solved, {} stances", row.stances),
        Ended::Refused => "found, and refused by the verifier".to_owned(),
        Ended::NoPlan => "no plan".to_owned(),
        Ended::Exhausted => "given up, all was tried".to_owned(),
        Ended::BudgetSpent => "given up, the budget is spent".to_owned(),
        Ended::Executed => "executed".to_owned(),
        Ended::NotExecuted => "not executed".to_owned(),
        Ended::Error => "error".to_owned(),
    };
    let reason = row
        .reason
        .as_ref()
        .map_or_else(String::new, |r| format!(": {r}"));
    format!(
        "{}: {ended}, {} nodes, {:.0} ms{reason}",
        row.world, row.nodes, row.planning_ms
    )
}

/// A scene that is given.
fn given(scene: &str) -> Item {
    let name = Path::new(scene).file_stem();
    let name = name.map_or_else(
        || scene.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    );
    Item {
        family: name.clone(),
        name,
        robot: "the scene's".to_owned(),
        seed: None,
        likely: None,
        scene: scene.to_owned(),
    }
}

impl Args {
    /// The worlds of every robot and family, written into the folder.
    fn drawn(&self, global: &Global) -> Result<Vec<Item>> {
        let families: Vec<&Family> = match self.family.as_slice() {
            [] => FAMILIES.iter().collect(),
            names => names
                .iter()
                .map(|name| world::family(name))
                .collect::<Result<_>>()?,
        };
        let config = Config::layered(None, global)?;
        let folder = self.output.join("worlds");
        let mut items = Vec::new();
        for files in self.robots()? {
            let robot = files.load(&config.robot_model, &mut Inputs::default())?;
            let build =
                world::build(&robot, &config.posture).with_context(|| robot.name.clone())?;
            for family in families.iter().filter(|f| f.hands <= build.hands) {
                for seed in self.first..self.first.saturating_add(self.count) {
                    let name = format!("{}-{}-{seed}", family.name, robot.name);
                    world::write(&folder, &name, &family.draw(&build, seed), &files, &robot)?;
                    items.push(Item {
                        scene: folder.join(format!("{name}.toml")).display().to_string(),
                        name,
                        family: family.name.to_owned(),
                        robot: robot.name.clone(),
                        seed: Some(seed),
                        likely: Some(family.likely),
                    });
                }
            }
        }
        Ok(items)
    }

    fn robots(&self) -> Result<Vec<RobotFiles>> {
        let own_files = self.srdf.is_some() || self.contacts.is_some();
        if own_files && self.robot.len() > 1 {
            bail!("--srdf and --contacts go with one --robot");
        }
        let names: Vec<&str> = match self.robot.as_slice() {
            [] => ROBOTS.to_vec(),
            named => named.iter().map(String::as_str).collect(),
        };
        let files = names.into_iter().map(|urdf| RobotFiles {
            urdf: urdf.to_owned(),
            beside: BesideUrdf {
                srdf: self.srdf.clone(),
                contacts: self.contacts.clone(),
                packages: Vec::new(),
            },
        });
        Ok(files.collect())
    }
}

/// `i/n` with 1 ≤ i ≤ n.
pub(super) fn shard(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parts {
        Some((i, n)) if 1 <= i && i <= n => Ok((i, n)),
        _ => Err("not i/n with 1 ≤ i ≤ n".to_owned()),
    }
}
