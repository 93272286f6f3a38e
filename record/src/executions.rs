//! Plans held and executed in the physics simulation.

use std::path::Path;

use anyhow::{Result, ensure};
use serde_json::Value;

use crate::program::{Program, argument, json};
use crate::table::Worse::{Less, More};
use crate::table::{Table, column};

/// The criteria that are told, in the order of the columns.
const NAMES: [&str; 6] = [
    "com error",
    "slip",
    "swing error",
    "tilt",
    "torque use",
    "penetration",
];

/// Executes the plans that lie in `folder/SCENE`; without MuJoCo, or without a motion, the notes say so.
pub fn executed(program: &Program, names: &[String], folder: &Path) -> Result<Table> {
    let mut table = Table::new(
        "Executions",
        vec![
            column("passed", Less, 0.0, 0.0, 0),
            column("CoM error mm", More, 2.0, 0.2, 1),
            column("slip mm", More, 1.0, 0.2, 1),
            column("swing error mm", More, 2.0, 0.2, 1),
            column("tilt °", More, 0.3, 0.2, 2),
            column("torque use", More, 0.05, 0.0, 3),
            column("penetration mm", More, 0.1, 0.2, 3),
        ],
    );
    let out = folder.join("simulation.json");
    for name in names {
        let plan = folder.join(name).join("plan.json");
        if !folder.join(name).join("motion.json").exists() {
            table.note(format!("{name} has no motion to execute."));
            continue;
        }
        let (plan, to) = (argument(&plan), argument(&out));
        let args = ["simulate", &plan, "--execute", "-o", &to];
        let ran = program.run(&args, &[0, 1, 3])?;
        if ran.code == 1 {
            let without = ran.errors.contains("--features mujoco");
            ensure!(without, "`scandent {}`: {}", args.join(" "), ran.errors);
            eprintln!("SKIPPED: executions: the program was built without MuJoCo");
            table.note("SKIPPED: the program was built without MuJoCo.");
            break;
        }
        table.push(name.clone(), figures(&json(&out)?));
    }
    Ok(table)
}

fn figures(file: &Value) -> Vec<Option<f64>> {
    let criterion = |name: &str| {
        let list = file["execution"]["criteria"].as_array()?;
        list.iter().find(|c| c["name"] == name)?["value"].as_f64()
    };
    let mut figures = vec![file["execution"]["pass"].as_bool().map(f64::from)];
    figures.extend(NAMES.map(criterion));
    figures
}
