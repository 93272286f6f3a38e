//! A mount → the pose of a scene's scans: the robot stands as at the start.
#![allow(non_snake_case)]

use std::path::Path;

use anyhow::{Context, Result, bail};
use robot_model::Kinematics;

use super::extrinsics::Extrinsics;
use crate::cli::Global;
use crate::config::Config;
use crate::provenance::Inputs;
use crate::scene::{Environment, Scene};
use crate::start;

/// Puts the scans of `scene` where its files of mounts, or `given` for all of them, say.
///
///   X_WV = X_WL(start) · X_LV
///
/// # Errors
/// A file that cannot be read or is no mount; a mount on another robot or on no link of this one;
/// `given` for a scene without scans.
pub fn place(
    scene: &mut Scene,
    given: Option<&Path>,
    global: &Global,
    inputs: &mut Inputs,
) -> Result<()> {
    let Environment::Scans(sources) = &scene.environment else {
        return match given {
            Some(path) => bail!(
                "{}: a mount belongs to scans, and {} has none",
                path.display(),
                scene.name
            ),
            None => Ok(()),
        };
    };
    if given.is_none() && sources.iter().all(|source| source.extrinsics.is_none()) {
        return Ok(());
    }
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    // The pipeline notes the robot's files and reads it again: friction is not its business here.
    let robot = scene
        .robot
        .load(&config.robot_model, &mut Inputs::default())?;
    let stand = start::stand(&robot, &scene.start, &config.posture)?;
    let kinematics = Kinematics::new(&robot, &stand.configuration);
    let mut placed = sources.clone();
    for source in &mut placed {
        let (name, bytes) = match (given, &source.extrinsics) {
            (Some(path), _) => (path.display().to_string(), inputs.read("extrinsics", path)?),
            (None, Some(name)) => (name.clone(), scene.files.read("extrinsics", name, inputs)?),
            (None, None) => continue,
        };
        let text =
            std::str::from_utf8(&bytes).with_context(|| format!("{name}: not a text file"))?;
        let mount = Extrinsics::parse(text).with_context(|| name.clone())?;
        if mount.robot != robot.name {
            bail!(
                "{name}: the mount is on robot {:?}, the scene's is {:?}",
                mount.robot,
                robot.name
            );
        }
        let X_WL = kinematics.X_WL(&robot, &mount.link).context(name)?;
        source.place(&(X_WL * mount.X_RV()));
    }
    scene.environment = Environment::Scans(placed);
    Ok(())
}
