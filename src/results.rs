//! The folder of results of one scene.

use std::path::Path;

use anyhow::{Context, Result};
use planner::Status;

use crate::export::{self, Format};
use crate::output;
use crate::pipeline::{MOTION_FILE, PlanOutcome};
use crate::view::{self, ViewInput};

/// The way to the contact set nearest to the goal, where there is no plan.
const PARTIAL: &str = "partial_plan.json";
/// A plan that the verifier does not pass.
const REJECTED: &str = "rejected_plan.json";
/// Files that are there only after a success.
const OF_SUCCESS: [&str; 5] = [
    "plan.json",
    MOTION_FILE,
    "contacts.yaml",
    "plan.csv",
    "certificate.json",
];

/// Writes everything that came of a scene; a plan under the name of one only if it was found and
/// passes the verifier.
///
/// # Errors
/// A file that cannot be written, with its path.
pub fn write(folder: &Path, planned: &PlanOutcome) -> Result<()> {
    // What an earlier run left must not pass for this one's.
    for name in OF_SUCCESS.iter().chain(&[PARTIAL, REJECTED, "view.html"]) {
        remove(&folder.join(name))?;
    }
    let surfaces = planned.extracted.to_json()?;
    output::write(&folder.join("surfaces.json"), surfaces.as_bytes())?;
    let plan = &planned.plan;
    let found = planned.status == Status::Found;
    if found && planned.certificate.pass {
        // The motion first: a plan never names a file that is not there.
        if planned.motion.is_some() {
            output::write(&folder.join(MOTION_FILE), &planned.motion_json)?;
        }
        output::write_json(&folder.join("plan.json"), plan)?;
        for (name, format) in [
            ("contacts.yaml", Format::MccYaml),
            ("plan.csv", Format::Csv),
        ] {
            // That controller knows no contact of a ball.
            if format == Format::MccYaml && touches_with_balls(planned) {
                continue;
            }
            let (motion, config) = (planned.motion.as_ref(), &planned.config.export);
            let text = export::export(plan, motion, &planned.robot, format, config)?;
            output::write(&folder.join(name), text.as_bytes())?;
        }
    } else {
        let name = if found { REJECTED } else { PARTIAL };
        output::write_json(&folder.join(name), plan)?;
    }
    if found {
        let certificate = planned.certificate.to_json()?;
        output::write(&folder.join("certificate.json"), certificate.as_bytes())?;
    }
    let page = view::page(&ViewInput {
        plan,
        motion: planned.motion.as_ref(),
        robot: &planned.robot,
        certificate: found.then_some(&planned.certificate),
        cloud_W: &planned.cloud_W,
    })?;
    output::write(&folder.join("view.html"), page.as_bytes())?;
    output::write_json(&folder.join("report.json"), &planned.report)
}

/// Whether the plan touches anything with a point patch.
fn touches_with_balls(planned: &PlanOutcome) -> bool {
    let contacts = planned.plan.stances.iter().flat_map(|s| &s.contacts);
    let mut patches = contacts.filter_map(|c| planned.robot.patch(&c.patch).ok());
    patches.any(|patch| patch.point_radius_m().is_some())
}

fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("{}: cannot be replaced", path.display()))
        }
        _ => Ok(()),
    }
}
