//! `scandent batch MANIFEST.jsonl`: items planned by the thousand, each a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Sender, channel};

use anyhow::{Context, Result, anyhow, bail};

use super::bench::{sentence, shard};
use crate::argument;
use crate::batch::index::{self, items};
use crate::batch::{self, Extras, done};
use crate::bench::{Ended, Row};
use crate::cli::Global;
use crate::interrupt;
use crate::output;
use crate::robot_files::Robots;
use crate::status::Status;
use crate::told::Told;

/// Flags of `batch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The items, a line of JSON each: the flags of `plan` by name, such as {"item": "a", "scene":
    /// "stairs.toml", "robot": "builtin:hrp2", "goal": [2, 0], "set": {"planner.nodes_max": 900}, "seed": 1},
    /// or a drawn world, {"item": "b", "family": "stairs-up", "world_seed": 4, "robot": "builtin:hrp2"},
    /// or the flags of `simulate` with a plan, {"item": "c", "plan": "DIR/items/a/plan.json", "perturb": "all"}
    #[arg(value_name = "MANIFEST.jsonl")]
    manifest: PathBuf,
    /// Folder of the results: items/NAME/ and index.csv
    #[arg(short, long, value_name = "DIR", value_parser = argument::folder)]
    output: PathBuf,
    /// Only every n-th item, from the i-th on: i/n
    #[arg(long, value_name = "I/N", value_parser = shard, default_value = "1/1")]
    shard: (usize, usize),
    /// Write every verified motion as arrays, too
    #[arg(long, value_enum)]
    export: Option<Arrays>,
    /// Write the page of every item, too
    #[arg(long)]
    view: bool,
}

/// Forms of arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Arrays {
    /// motion.npz, for numpy
    Npz,
}

/// Plans every item that is not done yet, as many at a time as there are threads, and writes the index.
///
/// # Errors
/// A manifest that cannot be read or names an item twice, settings beside the items' own, a folder that
/// cannot be written. What goes wrong with an item is its result; with one the command ends as failed.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let own = !global.set.is_empty() || global.config.is_some();
    if own || global.seed.is_some() || global.improve.is_some() {
        bail!(
            "settings of a batch are those of its items: \"set\", \"config\", \"seed\", \"improve\""
        );
    }
    output::check(&args.output.join(index::NAME))?;
    let made = std::fs::create_dir_all(&args.output);
    made.with_context(|| format!("{}: cannot be written", args.output.display()))?;
    let (first, of) = args.shard;
    let mut names = BTreeSet::new();
    for item in items(&args.manifest)? {
        let name = item?.name;
        if names.contains(&name) {
            bail!("{}: item {name:?} is there twice", args.manifest.display());
        }
        names.insert(name);
    }
    let total = names.len().saturating_sub(first - 1).div_ceil(of);
    drop(names);

    let available = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let workers = global.threads.map_or_else(available, NonZeroUsize::get);
    let waiting = Mutex::new(items(&args.manifest)?.skip(first - 1).step_by(of));
    let cancel = interrupt::listen();
    let extras = Extras {
        npz: args.export.is_some(),
        view: args.view,
    };
    let robots = Robots::default();
    let next = || {
        anyhow::Ok(
            waiting
                .lock()
                .map_err(|_| anyhow!("a worker broke"))?
                .next(),
        )
    };
    let work = |rows: Sender<Row>| -> Result<()> {
        while !cancel.load(Ordering::Relaxed) {
            let Some(item) = next()?.transpose()? else {
                break;
            };
            let before = done(&args.output, &item).map(|record| record.row);
            let row = match before {
                Some(row) => Some(row),
                None => batch::run(&item, &args.output, extras, &robots, cancel)?,
            };
            // The receiver is there until all workers have ended.
            if let Some(row) = row {
                let _ = rows.send(row);
            }
        }
        Ok(())
    };
    let mut counts = BTreeMap::<&str, usize>::new();
    std::thread::scope(|scope| {
        let (rows, ended) = channel();
        let workers: Vec<_> = (0..workers)
            .map(|_| (rows.clone(), &work))
            .map(|(rows, work)| scope.spawn(move || work(rows)))
            .collect();
        drop(rows);
        for (number, row) in ended.iter().enumerate() {
            writeln!(told, "{}/{total} {}", number + 1, sentence(&row))?;
            told.flush()?;
            *counts.entry(row.ended.name()).or_default() += 1;
        }
        let ended = workers.into_iter().map(|worker| worker.join());
        let ended: Vec<_> = ended.collect();
        ended
            .into_iter()
            .try_for_each(|ended| ended.unwrap_or_else(|_| bail!("a worker broke")))
    })?;
    index::write(&args.manifest, &args.output)?;
    if cancel.load(Ordering::Relaxed) {
        bail!("interrupted: the same command goes on with what is not done");
    }
    let words: Vec<String> = counts
        .iter()
        .map(|(ended, n)| format!("{n} {ended}"))
        .collect();
    writeln!(told, "{total} items: {}", words.join(", "))?;
    told.fact("items", &counts)?;
    told.written(&args.output.join(index::NAME))?;
    let flawed = [Ended::Refused, Ended::Error];
    Ok(
        match flawed.iter().any(|ended| counts.contains_key(ended.name())) {
            true => Status::Failed,
            false => Status::Done,
        },
    )
}
