//! The folder of results of one scene.

use anyhow::Result;
use planner::Status;

use crate::export::{self, Format};
use crate::output::{self, Folder};
use crate::pipeline::{MOTION_FILE, PlanOutcome};
use crate::search_file::{self, SEARCH_FILE};
use crate::view::{self, ViewInput};

/// The way to the contact set nearest to the goal, where there is no plan.
const PARTIAL: &str = "partial_plan.json";
/// A plan that the verifier does not pass.
const REJECTED: &str = "rejected_plan.json";
/// What a simulation showed.
pub const SIMULATION: &str = "simulation.json";
/// The trace of the motion that it executed.
pub const TRACE: &str = "simulation.csv";
/// Names of what a run writes, and of what a simulation writes of it: nothing of an earlier run may
/// pass for this one's.
pub const NAMES: &[&str] = &[
    "surfaces.json",
    "plan.json",
    MOTION_FILE,
    "contacts.yaml",
    "plan.csv",
    PARTIAL,
    REJECTED,
    SEARCH_FILE,
    "certificate.json",
    "view.html",
    "report.json",
    SIMULATION,
    TRACE,
];

/// Writes everything that came of a scene; a plan under the name of one only if it was found and
/// passes the verifier.
///
/// # Errors
/// A file that cannot be written, with its path.
pub fn write(folder: Folder, planned: &PlanOutcome) -> Result<()> {
    write_all(&folder, planned, true)?;
    folder.publish()
}

/// As [`write`], into a folder that is not whole with it; `page` says whether to draw the page
/// and to tell what was tried.
///
/// # Errors
/// As there.
pub fn write_all(folder: &Folder, planned: &PlanOutcome, page: bool) -> Result<()> {
    folder.write("surfaces.json", planned.extracted.to_json()?.as_bytes())?;
    let plan = &planned.plan;
    let found = planned.status == Status::Found;
    let plan_json = output::json(plan)?;
    if planned.verified() {
        if planned.motion.is_some() {
            folder.write(MOTION_FILE, &planned.motion_json)?;
        }
        folder.write("plan.json", &plan_json)?;
        for (name, format) in [
            ("contacts.yaml", Format::MccYaml),
            ("plan.csv", Format::Csv),
        ] {
            // That controller knows no contact of a ball.
            let balls = || export::balls_touched(plan, &planned.robot).next().is_some();
            if format == Format::MccYaml && balls() {
                continue;
            }
            let (motion, config) = (planned.motion.as_ref(), &planned.config.export);
            let bytes = export::export(plan, motion, &planned.robot, format, config)?;
            folder.write(name, &bytes)?;
        }
    } else {
        let name = if found { REJECTED } else { PARTIAL };
        folder.write(name, &plan_json)?;
    }
    if found {
        folder.write(
            "certificate.json",
            planned.certificate.to_json()?.as_bytes(),
        )?;
    }
    if page {
        let page = view::page(&ViewInput {
            plan,
            motion: planned.motion.as_ref(),
            trace: Some(&planned.trace),
            robot: &planned.robot,
            certificate: found.then_some(&planned.certificate),
            cloud_W: &planned.cloud_W,
        })?;
        folder.write("view.html", page.as_bytes())?;
        folder.write(SEARCH_FILE, &search_file::json(&planned.trace, &plan_json)?)?;
    }
    folder.write("report.json", &output::json(&planned.report)?)
}
