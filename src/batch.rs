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
use serde::{Deserialize, Serialize};

use crate::bench::{self, Row};
use crate::config::Config;
use crate::export::{self, Format};
use crate::output::{self, Folder};
use crate::pipeline::{self, PlanOutcome, RunOptions};
use crate::provenance::sha256;
use crate::results;

use item::{Asked, Item};

/// The folder of the items in the folder of a batch.
pub const ITEMS: &str = "items";
/// What came of an item, in its folder.
pub const RECORD: &str = "item.json";
/// The motion as arrays, in its folder.
const ARRAYS: &str = "motion.npz";
/// What an item's folder may hold: the results of a run, and these.
const NAMES: &[&str] = &[
    "surfaces.json",
    "plan.json",
    pipeline::MOTION_FILE,
    "contacts.yaml",
    "plan.csv",
    "partial_plan.json",
    "rejected_plan.json",
    "certificate.json",
    "view.html",
    "report.json",
    RECORD,
    ARRAYS,
    item::SCENE,
    item::MESH,
];

/// What is written of an item beside its results.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras {
    /// The motion as arrays.
    pub npz: bool,
    /// The page to look at.
    pub view: bool,
}

/// What came of an item, as its folder holds it.
#[derive(Debug, Serialize, Deserialize)]
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

/// Plans an item on one thread and writes its folder; nothing where `cancel` was raised before it ended.
///
/// # Errors
/// A folder that cannot be written. What goes wrong with the item is in the row.
pub fn run(item: &Item, folder: &Path, extras: Extras, cancel: &AtomicBool) -> Result<Option<Row>> {
    let begin = std::time::Instant::now();
    let planned = planned(item, cancel);
    if cancel.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let total_ms = begin.elapsed().as_secs_f64() * 1e3;
    let of_item = item.row();
    let (row, planned) = match planned {
        Ok((asked, planned)) => (bench::of_outcome(of_item, &planned), Some((asked, planned))),
        Err(error) => (
            Row {
                reason: Some(format!("{error:#}")),
                ..of_item
            },
            None,
        ),
    };
    let record = Record {
        program: crate::program(),
        line_sha256: sha256(item.line.as_bytes()),
        row: Row { total_ms, ..row },
    };
    let place = Folder::new(&folder.join(ITEMS).join(&item.name), NAMES)?;
    if let Some((asked, planned)) = &planned {
        results::write_all(&place, planned, extras.view)?;
        for (name, bytes) in asked.world.iter().flatten() {
            place.write(name, bytes)?;
        }
        if let (true, true, Some(motion)) = (extras.npz, planned.verified(), &planned.motion) {
            let config = &planned.config.export;
            let (plan, robot) = (&planned.plan, &planned.robot);
            let bytes = export::export(plan, Some(motion), robot, Format::Npz, config)?;
            place.write(ARRAYS, &bytes)?;
        }
    }
    place.write(RECORD, &output::json(&record)?)?;
    place.publish()?;
    Ok(Some(record.row))
}

fn planned(item: &Item, cancel: &AtomicBool) -> Result<(Asked, PlanOutcome)> {
    let mut asked = item.asked()?;
    let (scene, global) = (&asked.scene, &asked.global);
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    let options = RunOptions {
        threads: Some(NonZeroUsize::MIN),
        stage: &|_| {},
        progress: &|_| {},
        cancel,
    };
    let inputs = std::mem::take(&mut asked.inputs);
    let planned = pipeline::plan(scene, &config, &options, inputs)?;
    Ok((asked, planned))
}
