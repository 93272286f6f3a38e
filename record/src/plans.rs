//! Plans of the scenes that ship, of their scans with other noise, and on other numbers of threads.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use scenes::Builtin;
use scenes::simulator::DepthNoise;
use scenes::simulator::lidar::pcd;
use serde_json::Value;

use crate::frames::pose;
use crate::program::{Program, argument, json};
use crate::table::Worse::{Less, More};
use crate::table::{Column, Table, column, mean};

/// Scenes whose plans are drawn with many other seeds, and how many.
pub const CLIMBS: [&str; 3] = ["irregular-stairs", "slope-and-hand", "hexapod-obstacles"];

/// What a run of `plan` came to.
pub struct Planned {
    found: bool,
    verified: bool,
    plan: Value,
}

/// Plans a scene into a folder, which is emptied before.
pub fn plan(program: &Program, scene: &str, flags: &[String], folder: &Path) -> Result<Planned> {
    if folder.exists() {
        std::fs::remove_dir_all(folder)?;
    }
    let out = argument(folder);
    let args = [&["plan", scene, "-o", &out].map(str::to_owned), flags].concat();
    // 1 is also a plan that its own verification refused: it counts as none, and why is told.
    let ran = program.run(&args, &[0, 1, 3, 4])?;
    let found = ran.code == 0;
    let certificate = folder.join("certificate.json");
    let file = folder.join("plan.json");
    if !found {
        eprintln!("no plan, exit code {}: {}", ran.code, args.join(" "));
    }
    Ok(Planned {
        found,
        verified: found && json(&certificate)?["pass"] == true,
        // Where the goal cannot be posed there is none.
        plan: match file.exists() {
            true => json(&file)?,
            false => Value::Null,
        },
    })
}

impl Planned {
    /// The smallest (or greatest) of a margin over the stances.
    fn worst(&self, margin: &str, greatest: bool) -> Option<f64> {
        let stances = self.plan["stances"].as_array()?.iter();
        let values = stances.filter_map(|s| s["margins"][margin].as_f64());
        values.reduce(if greatest { f64::max } else { f64::min })
    }

    /// In the order of [`columns`]; nothing but the counts of the search without a plan.
    fn figures(&self) -> Vec<Option<f64>> {
        let number = |at: &str| self.plan.pointer(at)?.as_f64();
        let stances = || Some(self.plan["stances"].as_array()?.len() as f64);
        let mm = |margin: &str| self.worst(margin, false).map(|m| 1e3 * m);
        let mut figures = vec![
            Some(f64::from(self.found)),
            Some(f64::from(self.verified)),
            number("/search/nodes_generated"),
            number("/search/candidates_solved"),
            stances(),
            number("/motion/duration_s"),
            self.worst("torque_use", true),
            self.worst("friction_use", true),
            mm("inclusion_m"),
            mm("clearance_m"),
            mm("self_clearance_m"),
        ];
        if !self.found {
            figures[4..].fill(None);
        }
        figures
    }
}

/// What is told of a plan. Its margins are at least what the settings require, or it is not verified;
/// what they are beyond that may change with every other path.
fn columns() -> Vec<Column> {
    vec![
        column("found", Less, 0.0, 0.0, 2),
        column("verified", Less, 0.0, 0.0, 2),
        column("tree", More, 10.0, 0.35, 0),
        column("problems", More, 20.0, 0.35, 0),
        column("stances", More, 2.0, 0.05, 1),
        column("motion s", More, 3.0, 0.1, 1),
        column("torque use", More, 0.08, 0.0, 3),
        column("friction use", More, 0.15, 0.0, 3),
        column("inclusion mm", Less, 1.0, 0.0, 1),
        column("clearance mm", Less, 5.0, 0.3, 1),
        column("self mm", Less, 2.0, 0.3, 1),
    ]
}

/// Every scene that ships; the plans stay in `folder/SCENE`.
pub fn shipped(program: &Program, names: &[String], folder: &Path) -> Result<Table> {
    let mut table = Table::new("Plans of the scenes that ship", columns());
    for name in names {
        let planned = plan(program, name, &[], &folder.join(name))?;
        table.push(name.clone(), planned.figures());
    }
    table.note(
        "*tree*: contact sets in the tree; *problems*: posture problems solved; the margins are the least of all \
         stances, uses the greatest.",
    );
    Ok(table)
}

/// The scans of the scenes with other noise, one row a scene: parts of the plans found and verified,
/// and means over those found.
pub fn other_noise(program: &Program, shots: &[Shot], folder: &Path) -> Result<Table> {
    let mut table = Table::new("Plans with other noise (means)", columns());
    let mut scenes: Vec<&str> = shots.iter().map(|s| s.row.as_str()).collect();
    scenes.dedup();
    for scene in scenes {
        let mine: Vec<&Shot> = shots.iter().filter(|s| s.row == scene).collect();
        let mut all: Vec<Vec<Option<f64>>> = Vec::new();
        for shot in &mine {
            all.push(plan(program, &shot.scene, &shot.flags, &folder.join("other"))?.figures());
        }
        let of_column = |k: usize| {
            let values: Vec<f64> = all.iter().filter_map(|figures| figures[k]).collect();
            mean(&values)
        };
        let row = format!("{scene} ×{}", mine.len());
        table.push(row, (0..table.columns.len()).map(of_column).collect());
    }
    Ok(table)
}

/// A scan of a scene with other noise.
pub struct Shot {
    row: String,
    scene: String,
    flags: Vec<String>,
}

/// Scans of the climbs with `seeds` other seeds, and of the slopes with a quarter as many, in `folder`.
pub fn shots(seeds: u64, folder: &Path) -> Result<Vec<Shot>> {
    let mut shots = Vec::new();
    for name in scenes::names() {
        let climb = CLIMBS.contains(&name);
        for seed in 1..=if climb { seeds } else { seeds.div_ceil(4) } {
            let scene = scenes::builtin(name).context("a scene that ships")?;
            // Far from the seeds of the scans that ship.
            let flags = shoot(scene, 1000 + seed, folder)?;
            shots.push(Shot {
                row: if climb { name } else { "slopes" }.to_owned(),
                scene: name.to_owned(),
                flags,
            });
        }
    }
    Ok(shots)
}

/// Takes a scene's scan again and returns the flags that read it.
fn shoot(scene: &Builtin, seed: u64, folder: &Path) -> Result<Vec<String>> {
    let source = scene.source().context("a scan")?;
    let stem = folder.join(format!("{}_{seed}", scene.name));
    let scan_path: PathBuf;
    if let Some(taken) = scene.sweep(seed) {
        scan_path = stem.with_extension("pcd");
        std::fs::write(&scan_path, pcd(&taken))?;
    } else {
        scan_path = stem.with_extension("png");
        let taken = scene.picture(&DepthNoise::default(), seed);
        std::fs::write(&scan_path, taken.context("a picture")?.png()?)?;
    }
    let sensor = source.sensor.context("a sensor")?;
    let path = argument(&scan_path);
    let mut flags = ["--scan", &path, "--sensor", &sensor]
        .map(str::to_owned)
        .to_vec();
    match source.extrinsics {
        // Where the planner believes the sensor to be is what was identified, not the truth.
        Some(name) => {
            let path = folder.join(&name);
            std::fs::write(&path, scene.file(&name).context("a mount that ships")?)?;
            flags.extend(["--extrinsics".to_owned(), argument(&path)]);
        }
        None => flags.push(format!("--pose={}", pose(&scene.X_WV().context("a scan")?))),
    }
    Ok(flags)
}

/// Whether a scene's plan is the same, byte for byte, on 1, 2 and 4 threads.
pub fn threads(program: &Program, names: &[&str], folder: &Path) -> Result<Table> {
    let columns = vec![column("identical on 1, 2, 4 threads", Less, 0.0, 0.0, 0)];
    let mut table = Table::new("Determinism", columns);
    for name in names {
        let mut files = Vec::new();
        for threads in ["1", "2", "4"] {
            let flags = ["--threads", threads].map(str::to_owned);
            let folder = folder.join("threads");
            plan(program, name, &flags, &folder)?;
            let read = |file: &str| std::fs::read(folder.join(file)).ok();
            files.push((read("plan.json"), read("motion.json")));
        }
        let same = files[0].0.is_some() && files.iter().all(|f| *f == files[0]);
        table.push(*name, vec![Some(f64::from(same))]);
    }
    Ok(table)
}
