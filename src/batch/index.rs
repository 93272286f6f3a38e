//! The index of a batch: a row of figures an item, in the order of the manifest.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;

use anyhow::{Context, Result};

use super::done;
use super::item::Item;
use crate::bench::Row;
use crate::export::quoted;
use crate::{output, provenance};

/// Its name in the folder of a batch.
pub const NAME: &str = "index.csv";

/// The items of a manifest, one after the other.
///
/// # Errors
/// A manifest that cannot be read.
pub fn items(manifest: &Path) -> Result<impl Iterator<Item = Result<Item>> + use<>> {
    let named = manifest.display().to_string();
    let file: Box<dyn BufRead + Send> = match provenance::is_standard(manifest) {
        true => Box::new(Cursor::new(provenance::read("manifest", manifest)?)),
        false => Box::new(BufReader::new(
            File::open(manifest).with_context(|| format!("{named}: cannot be read"))?,
        )),
    };
    let lines = file.lines().enumerate();
    let lines = lines.filter(|(_, line)| !matches!(line, Ok(line) if line.trim().is_empty()));
    Ok(lines.map(move |(number, line)| {
        let line = line.with_context(|| format!("{named}: line {}", number + 1))?;
        Ok(Item::new(line.trim(), number + 1))
    }))
}

/// Writes the index of all items that are done; of several shards the one that ends last writes it whole.
/// Times are in the items' records: the index is the same wherever and in whatever order they ran.
///
/// # Errors
/// A manifest or folder that cannot be read or written.
pub fn write(manifest: &Path, folder: &Path) -> Result<()> {
    let lock = File::create(folder.join(".index.lock"));
    let lock = lock.with_context(|| format!("{}: cannot be written", folder.display()))?;
    lock.lock().context("the index's lock")?;
    let mut text = String::from(
        "item,ended,family,robot,seed,nodes,problems,stances,motion_s,clearance_m,torque_use,friction_use,reason\n",
    );
    for item in items(manifest)? {
        if let Some(record) = done(folder, &item?) {
            line(&mut text, &record.row);
        }
    }
    output::write(&folder.join(NAME), text.as_bytes())
}

fn line(text: &mut String, row: &Row) {
    let or_nothing = |value: Option<String>| value.unwrap_or_default();
    let fields = [
        row.world.clone(),
        row.ended.name().to_owned(),
        row.family.clone(),
        row.robot.clone(),
        or_nothing(row.seed.map(|seed| seed.to_string())),
        row.nodes.to_string(),
        row.problems.to_string(),
        row.stances.to_string(),
        row.motion_s.to_string(),
        or_nothing(row.clearance_m.map(|m| m.to_string())),
        row.torque_use.to_string(),
        row.friction_use.to_string(),
        or_nothing(row.reason.clone()),
    ];
    text.push_str(&fields.map(|field| quoted(&field)).join(","));
    text.push('\n');
}
