//! A plan on disk, and the robot that it was made for.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use plan::{Motion, PLAN_FORMAT, Plan};
use robot_model::Robot;

use crate::provenance::{Inputs, canonical, read, sha256};
use crate::robot_files::{BesideUrdf, RobotFiles, Robots};

/// Reads a plan.
///
/// # Errors
/// A file that cannot be read, is no JSON (with line and column) or no plan of this version.
pub fn open(path: &Path) -> Result<Plan> {
    parsed(path, &read("plan", path)?)
}

/// The plan that a file's bytes are.
///
/// # Errors
/// As [`open`].
pub fn parsed(path: &Path, bytes: &[u8]) -> Result<Plan> {
    let name = path.display();
    let value: serde_json::Value =
        serde_json::from_slice(bytes).with_context(|| format!("{name}: not valid JSON"))?;
    match value.get("format").and_then(|format| format.as_str()) {
        Some(PLAN_FORMAT) => {}
        Some(other) => bail!("{name}: the format is {other:?}, not {PLAN_FORMAT:?}"),
        None => bail!("{name}: not a plan: there is no \"format\""),
    }
    serde_json::from_slice(bytes).with_context(|| format!("{name}: not a plan"))
}

/// Reads the motion that a plan names, from the plan's folder.
///
/// # Errors
/// A name that leads elsewhere; a file that cannot be read, is not the one that the plan was
/// written with, or is no motion.
pub fn open_motion(path: &Path, plan: &Plan) -> Result<Option<Motion>> {
    let Some(named) = &plan.motion else {
        return Ok(None);
    };
    if Path::new(&named.file).file_name() != Some(named.file.as_ref()) {
        let (plan, name) = (path.display(), &named.file);
        bail!("{plan}: the motion's name {name:?} is a path");
    }
    let file = path.with_file_name(&named.file);
    let bytes = read("motion", &file)?;
    if sha256(&bytes) != named.sha256 {
        bail!("{}: changed since the plan was made", file.display());
    }
    let motion = serde_json::from_slice(&bytes)
        .with_context(|| format!("{}: not a motion", file.display()))?;
    Ok(Some(motion))
}

/// Where a file of a plan is: its name says it, or it is in the plan's folder or one above.
///
/// # Errors
/// A name that leads to no file there.
pub fn located(folder: &Path, name: &Path) -> Result<PathBuf> {
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let folder = canonical(folder).unwrap_or_else(|_| folder.to_owned());
    let mut there = folder.ancestors().map(|above| above.join(name));
    there.find(|path| path.exists()).with_context(|| {
        let (name, folder) = (name.display(), folder.display());
        format!("{name}: neither in {folder}, the plan's folder, nor in one above")
    })
}

/// The robot's files, where the plan does not name them or they have moved.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PlanRobotFlags {
    /// The robot: a URDF file, or builtin:NAME (default, as of the next two: what the plan names)
    #[arg(long, value_name = "URDF")]
    robot: Option<String>,
    #[command(flatten)]
    beside: BesideUrdf,
}

impl PlanRobotFlags {
    /// Whether any of them is given.
    pub fn any(&self) -> bool {
        self.robot.is_some() || self.beside.srdf.is_some() || self.beside.contacts.is_some()
    }

    /// The robot of a plan: the files that it names, unless flags name others.
    ///
    /// # Errors
    /// A plan that names no robot; files that changed since the plan was made; else as
    /// [`RobotFiles::load`].
    pub fn load(&self, plan: &Plan) -> Result<Robot> {
        Ok(self.load_noted(plan, &Robots::default())?.0)
    }

    /// [`load`](Self::load), by way of `robots`, and the names of the files that are none of the plan's.
    ///
    /// # Errors
    /// As there.
    pub fn load_noted(&self, plan: &Plan, robots: &Robots) -> Result<(Robot, Vec<String>)> {
        let named = |role: &str| plan.inputs.iter().find(|i| i.role == role).map(|i| &i.name);
        let path = |role: &str, flag: &Option<PathBuf>| {
            let named = named(role).filter(|name| !name.starts_with("builtin:"));
            flag.clone().or_else(|| named.map(PathBuf::from))
        };
        let urdf = self.robot.as_ref().or(named("urdf"));
        let urdf = urdf.context("the plan names no robot: give --robot")?;
        let files = RobotFiles {
            urdf: urdf.clone(),
            beside: BesideUrdf {
                srdf: path("srdf", &self.beside.srdf),
                contacts: path("contacts", &self.beside.contacts),
                packages: self.beside.packages.clone(),
            },
        };
        // The settings that the plan's robot was read with.
        let config = match plan.config.get("robot_model") {
            Some(table) => {
                serde_json::from_value(table.clone()).context("the plan's config.robot_model")?
            }
            None => robot_model::Config::default(),
        };
        let mut inputs = Inputs::default();
        let mut robot = robots.load(&files, &config, &mut inputs)?;
        let mut other = Vec::new();
        for now in inputs.into_list() {
            let (name, role) = (&now.name, &now.role);
            let mut inputs = plan.inputs.iter();
            let then = inputs.find(|i| i.role == *role && i.name == *name);
            if then.is_some_and(|then| then.sha256 != now.sha256) {
                bail!("{name}: this {role} file changed since the plan was made");
            }
            let mut inputs = plan.inputs.iter();
            if !inputs.any(|then| then.role == *role && then.sha256 == now.sha256) {
                other.push(name.clone());
            }
        }
        robot.notes.clear();
        Ok((robot, other))
    }
}
