//! Items planned by the thousand, for `scandent batch`: each is a line of JSON and becomes a folder.
//!
//! An item's folder appears whole or not at all, so that a batch that was killed goes on where it was; what
//! goes wrong with an item is its result. Neither depends on where or in what order items run.

pub mod index;
pub mod item;

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::bench::{self, Ended, Row};
use crate::cli::Global;
use crate::command::simulate::{self, Simulated};
use crate::config::Config;
use crate::export::{self, Format};
use crate::output::{self, Folder};
use crate::pipeline::{self, PlanOutcome, RunOptions};
use crate::provenance::sha256;
use crate::results;
use crate::robot_files::Robots;
use crate::told::Told;

use item::{Asked, Item};

/// The folder of the items in the folder of a batch.
pub const ITEMS: &str = "items";
/// What came of an item, in its folder.
pub const RECORD: &str = "item.json";
/// The plan with its motion as arrays, in its folder.
const ARRAYS: &str = "motion.npz";
/// What an item's folder may hold beside the results of a run.
const NAMES: &[&str] = &[RECORD, ARRAYS, item::SCENE, item::MESH];

/// What is written of an item beside its results.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras {
    /// The motion as arrays.
    pub npz: bool,
    /// The page to look at.
    pub view: bool,
}

/// What came of an item, as its folder holds it.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "BatchItem")]
pub struct Record {
    /// The program.
    pub program: plan::Program,
    /// SHA-256 of the item's line: another line is another item.
    pub line_sha256: String,
    /// How it ended, with figures.
    pub row: Row,
}

/// The record of an item that was done before by this version of the program.
pub fn done(folder: &Path, item: &Item) -> Option<Record> {
    let bytes = std::fs::read(folder.join(ITEMS).join(&item.name).join(RECORD)).ok()?;
    let record: Record = serde_json::from_slice(&bytes).ok()?;
    let same = record.line_sha256 == sha256(item.line.as_bytes());
    (same && record.program == crate::program()).then_some(record)
}

/// What an item came to, before it is written.
enum Came {
    Plan(Box<PlanOutcome>, Option<item::World>),
    Simulation(Simulated),
}

/// Plans or simulates an item on one thread and writes its folder; nothing where `cancel` was raised before it
/// ended. `robots` are those that items before it read.
///
/// # Errors
/// A folder that cannot be written. What goes wrong with the item is in the row.
pub fn run(
    item: &Item,
    folder: &Path,
    extras: Extras,
    robots: &Robots,
    cancel: &AtomicBool,
) -> Result<Option<Row>> {
    let begin = std::time::Instant::now();
    let came = came(item, robots, cancel);
    if cancel.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let total_ms = begin.elapsed().as_secs_f64() * 1e3;
    let of_item = item.row();
    let row = match &came {
        Ok(Came::Plan(planned, _)) => bench::of_outcome(of_item, planned),
        Ok(Came::Simulation(simulated)) => Row {
            robot: simulated.robot.clone(),
            ended: match simulated.failures.is_empty() {
                true => Ended::Executed,
                false => Ended::NotExecuted,
            },
            reason: simulated.failures.first().cloned(),
            ..of_item
        },
        Err(error) => Row {
            reason: Some(format!("{error:#}")),
            ..of_item
        },
    };
    let record = Record {
        program: crate::program(),
        line_sha256: sha256(item.line.as_bytes()),
        row: Row { total_ms, ..row },
    };
    let names = [results::NAMES, NAMES].concat();
    let place = Folder::new(&folder.join(ITEMS).join(&item.name), names)?;
    match &came {
        Ok(Came::Plan(planned, world)) => {
            results::write_all(&place, planned, extras.view)?;
            for (name, bytes) in world.iter().flatten() {
                place.write(name, bytes)?;
            }
            if let (true, true, Some(motion)) = (extras.npz, planned.verified(), &planned.motion) {
                let config = &planned.config.export;
                let (plan, robot) = (&planned.plan, &planned.robot);
                let bytes = export::export(plan, Some(motion), robot, Format::Npz, config)?;
                place.write(ARRAYS, &bytes)?;
            }
        }
        Ok(Came::Simulation(simulated)) => {
            place.write(results::SIMULATION, &simulated.json)?;
            if let Some(trace) = &simulated.trace {
                place.write(results::TRACE, trace.as_bytes())?;
            }
        }
        Err(_) => {}
    }
    place.write(RECORD, &output::json(&record)?)?;
    place.publish()?;
    Ok(Some(record.row))
}

fn came(item: &Item, robots: &Robots, cancel: &AtomicBool) -> Result<Came> {
    let (scene, global, inputs, world) = match item.asked(robots)? {
        Asked::Plan {
            scene,
            global,
            inputs,
            world,
        } => (scene, global, inputs, world),
        Asked::Simulation(args, global) => {
            let one = Global {
                threads: Some(NonZeroUsize::MIN),
                ..global
            };
            let mut nobody = std::io::sink();
            let told = &mut Told::words(&mut nobody);
            let simulated = simulate::simulate(&args, &one, cancel, robots, told)?;
            return Ok(Came::Simulation(simulated));
        }
    };
    let config = Config::layered(Some((&scene.name, &scene.settings)), &global)?;
    let options = RunOptions {
        threads: Some(NonZeroUsize::MIN),
        stage: &|_| {},
        progress: &|_| {},
        cancel,
        robots,
    };
    let planned = pipeline::plan(&scene, &config, &options, inputs)?;
    Ok(Came::Plan(Box::new(planned), world))
}
