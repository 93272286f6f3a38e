//! `record`: what must not get worse, measured over the command line of a program that was built
//! before, so that the same questions are put to an old and a new one.
//!
//! ```sh
//! cargo build --release --features mujoco
//! cargo run --release -p scandent-record --bin record -- --program target/release/scandent \
//!     [--against OTHER_PROGRAM_OR_RECORD.json] [--quick] -o out/record.json
//! ```
//!
//! writes `record.json` and `record.md`, prints the latter, and ends with 1 where something is worse
//! than in the other program (or in its record) beyond the noise that the tables state. Scans come
//! from the simulator in [`scenes`], the same for both; times are taken in turns.
//!
//! ```text
//! known worlds ─ frames ─▶ program surfaces ─▶ found ─ score ─┐
//! scenes, other noise ───▶ program plan ──────────────────────┼─▶ tables ─▶ side by side, what is worse
//! posture sets, motions ─▶ program posture, simulate ─────────┘
//! ```
//!
//! `record --frames FOLDER` writes the frames with their truth, for other tools to be scored on.

mod executions;
mod faces;
mod found;
mod frames;
mod plans;
mod postures;
mod program;
mod score;
mod table;
mod times;
mod truth_file;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use serde::{Deserialize, Serialize};

use frames::{Frame, frames};
use plans::{CLIMBS, Shot, shots};
use program::{Program, json};
use table::Table;

/// Measures what must not get worse.
#[derive(Parser)]
struct Args {
    /// The program that is measured
    #[arg(long, required_unless_present = "frames")]
    program: Option<PathBuf>,
    /// Another program, measured in the same run, or the JSON file of an earlier record
    #[arg(long)]
    against: Option<PathBuf>,
    /// Only a small part of everything
    #[arg(long)]
    quick: bool,
    /// Folder of the real scans
    #[arg(long, default_value = "../shared/scans")]
    scans: PathBuf,
    /// Where the record goes; the Markdown goes beside it
    #[arg(short, long, default_value = "out/record.json")]
    output: PathBuf,
    /// Only write the simulated frames with their truth into this folder
    #[arg(long)]
    frames: Option<PathBuf>,
}

const FORMAT: &str = "scandent-record/1";

/// The record of a program.
#[derive(Serialize, Deserialize)]
struct Record {
    format: String,
    program: String,
    quick: bool,
    tables: Vec<Table>,
}

/// What every program is asked, made once.
struct Questions {
    frames: Vec<Frame>,
    shots: Vec<Shot>,
    problems: usize,
    runs: usize,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    let frames = frames(if args.quick { 1 } else { 3 })?;
    if let Some(folder) = &args.frames {
        truth_file::write(folder, &frames)?;
        return Ok(ExitCode::SUCCESS);
    }
    let temporary = tempfile::tempdir()?;
    let folder = temporary.path();
    let program = Program::new(args.program.as_deref().context("--program")?)?;
    let questions = Questions {
        frames,
        shots: shots(if args.quick { 1 } else { 8 }, folder)?,
        problems: if args.quick { 20 } else { 60 },
        runs: if args.quick { 3 } else { 7 },
    };
    let mut record = measure(&program, &questions, &args, folder)?;
    let old = match &args.against {
        None => None,
        Some(file) if file.extension().is_some_and(|e| e == "json") => {
            Some(read(file, args.quick)?)
        }
        Some(path) => {
            let other = Program::new(path)?;
            let mut old = measure(&other, &questions, &args, folder)?;
            eprintln!("times, in turns");
            let names = if args.quick { &CLIMBS[..1] } else { &CLIMBS };
            let ratios = times::ratios(&program, &other, names, questions.runs, folder)?;
            old.tables.push(times::as_before(&ratios));
            record.tables.push(ratios);
            Some(old)
        }
    };
    let (text, worse) = markdown(&record, old.as_ref());
    if let Some(parent) = args.output.parent() {
        std::fs::create_dir_all(parent)?;
    }
    std::fs::write(&args.output, serde_json::to_vec(&record)?)?;
    std::fs::write(args.output.with_extension("md"), &text)?;
    println!("{text}");
    Ok(ExitCode::from(u8::from(worse)))
}

fn measure(program: &Program, ask: &Questions, args: &Args, folder: &Path) -> Result<Record> {
    let version = program.run(&["--version"], &[0])?.printed.trim().to_owned();
    let told = |what: &str| eprintln!("{version}: {what}");
    let mut names = program.scenes()?;
    let mut deterministic = vec![CLIMBS[0], CLIMBS[1], CLIMBS[2], "slope-23.8"];
    if args.quick {
        names.truncate(3);
        deterministic.truncate(1);
    }
    let executed = if args.quick { &names[..1] } else { &names[..] };
    told("faces");
    let mut tables = vec![
        faces::simulated(program, &ask.frames, folder)?,
        faces::real(program, &args.scans, folder)?,
    ];
    told("plans");
    tables.push(plans::shipped(program, &names, folder)?);
    tables.push(plans::other_noise(program, &ask.shots, folder)?);
    tables.push(plans::threads(program, &deterministic, folder)?);
    told("postures");
    tables.push(postures::sets(program, ask.problems, folder)?);
    told("executions");
    tables.push(executions::executed(program, executed, folder)?);
    Ok(Record {
        format: FORMAT.into(),
        program: version,
        quick: args.quick,
        tables,
    })
}

fn read(path: &Path, quick: bool) -> Result<Record> {
    let record = Record::deserialize(json(path)?).with_context(|| format!("{}", path.display()))?;
    ensure!(
        record.format == FORMAT && record.quick == quick,
        "{}: a record of another format, or a quick one beside a whole one",
        path.display(),
    );
    Ok(record)
}

/// The page, and whether something is worse.
fn markdown(record: &Record, old: Option<&Record>) -> (String, bool) {
    let mut text = format!("# Record of {}\n\n", record.program);
    let mut worse = Vec::new();
    for table in &record.tables {
        let before = old.and_then(|old| old.tables.iter().find(|t| t.title == table.title));
        let (one, its) = table.markdown(before);
        text += &one;
        worse.extend(its);
    }
    if let Some(old) = old {
        text += &format!("## Against {}\n\n", old.program);
        text += &match worse.is_empty() {
            true => "Nothing is worse beyond the noise.\n".to_owned(),
            false => format!("Worse beyond the noise:\n\n- {}\n", worse.join("\n- ")),
        };
    }
    (text, !worse.is_empty())
}
