//! Extrinsics → the pose of a scene's scans: the robot stands as at the start.

use std::path::Path;

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Matrix3, Matrix6};
use robot_model::Kinematics;

use super::file::Extrinsics;
use crate::cli::Global;
use crate::config::Config;
use crate::provenance::{self, Inputs};
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
        if let Some(path) = given {
            let (path, scene) = (path.display(), &scene.name);
            bail!("{path}: a mount belongs to scans, and {scene} has none");
        }
        return Ok(());
    };
    if given.is_none() && sources.iter().all(|source| source.extrinsics.is_none()) {
        return Ok(());
    }
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    // The pipeline notes the robot's files and reads it again: friction is not its business here.
    let files = &scene.robot;
    let robot = files.load(&config.robot_model, &mut Inputs::default())?;
    let stand = start::stand(
        &robot,
        &scene.start,
        &posture::Environment::default(),
        &config.posture,
    )?;
    let kinematics = Kinematics::new(&robot, &stand.configuration);
    let mut placed = sources.clone();
    let mut mounts = vec![None; placed.len()];
    for (source, known) in placed.iter_mut().zip(&mut mounts) {
        let (name, bytes) = match (given, &source.extrinsics) {
            (Some(path), _) => (path.display().to_string(), inputs.read("extrinsics", path)?),
            (None, Some(name)) => (name.clone(), scene.files.read("extrinsics", name, inputs)?),
            (None, None) => continue,
        };
        let text = provenance::text(&name, bytes)?;
        let mount = Extrinsics::parse(&text).with_context(|| name.clone())?;
        if mount.robot != robot.name {
            let (on, given) = (&mount.robot, &robot.name);
            bail!("{name}: the mount is on robot {on:?}, the scene's is {given:?}");
        }
        let X_WL = kinematics.X_WL(&robot, &mount.link).context(name)?;
        source.place(&(X_WL * mount.X_RV()));
        *known = mount.covariance.map(|rows| turned(&rows, &X_WL));
    }
    scene.mounts = mounts;
    scene.environment = Environment::Scans(placed);
    Ok(())
}

/// The covariance of (δθ, δp) in the link, about and along W's axes.
fn turned(rows: &[[f64; 6]; 6], X_WL: &Isometry3<f64>) -> Matrix6<f64> {
    let R_WL: Matrix3<f64> = X_WL.rotation.to_rotation_matrix().into_inner();
    let mut both = Matrix6::zeros();
    both.fixed_view_mut::<3, 3>(0, 0).copy_from(&R_WL);
    both.fixed_view_mut::<3, 3>(3, 3).copy_from(&R_WL);
    both * Matrix6::from_fn(|i, j| rows[i][j]) * both.transpose()
}
