//! Scans whose pose is taken from what they show, and poses that cannot be those of the scans.

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Vector3};
use perception::{ground_pose, up_by_planes};
use surfaces::Terrain;

use super::ReadScan;
use super::plausible::LevelArea;
use crate::config::Config;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};

/// Part of all faces' area that must be level by another pose for the one given to be doubted.
const LEVEL_PART: f64 = 0.3;
/// With less than this part of all faces' area level, it may be other planes that are.
const FEW_PART: f64 = 0.1;

/// The environment with a pose for each scan that is to be levelled, and what was found, for the user. Of scans
/// with poses the first is levelled, and the others keep their places to it.
///
/// # Errors
/// A scan that cannot be read or shows no ground; a scan of a spinning LiDAR, which has a calibration.
pub fn levelled(
    environment: &Environment,
    files: &Files,
    config: &Config,
) -> Result<(Environment, Vec<String>)> {
    let mut environment = environment.clone();
    let mut notes = Vec::new();
    // From the world of the poses given to the levelled one, by the first scan that has one.
    let mut turned: Option<Isometry3<f64>> = None;
    if let Environment::Scans(sources) = &mut environment {
        for source in sources.iter_mut().filter(|source| source.level) {
            let given = source.position_m.is_some();
            if let (true, Some(turned)) = (given, turned) {
                source.place(&(turned * source.X_WV()));
                continue;
            }
            let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
            let read = ReadScan::new(source, files, &mut stages, &mut inputs)?;
            let ReadScan::Scan { name, scan, .. } = read else {
                bail!(
                    "a spinning LiDAR is levelled by its calibration: `scandent calibrate lidar`"
                );
            };
            let up_V = source.up.map(Vector3::from);
            let found = ground_pose(&scan, up_V, &config.perception);
            let found = found.with_context(|| name.to_owned())?;
            let [level_m2, all_m2] = found.level_m2;
            let doubtful = up_V.is_none() && level_m2 < FEW_PART * all_m2;
            let warning = if doubtful {
                "warning: hardly anything shown is level, give what is up (--up, --imu): "
            } else {
                ""
            };
            notes.push(format!(
                "{warning}{name}: levelled by {level_m2:.2} of {all_m2:.2} m² of faces: the sensor is {:.3} m over the \
                 ground and looks down by {:.1}°; its place on the ground is the world's origin, x ahead",
                found.height_m(),
                found.looks_down_rad().to_degrees(),
            ));
            turned = given
                .then(|| found.X_WV * source.X_WV().inverse())
                .or(turned);
            source.place(&found.X_WV);
        }
    }
    Ok((environment, notes))
}

/// Why the pose of a single scan cannot be the one given, where nothing in it is level by that pose and
/// much would be by another.
pub fn doubt(environment: &Environment, terrain: &Terrain) -> Option<String> {
    let Environment::Scans(sources) = environment else {
        return None;
    };
    let [source] = &sources[..] else {
        return None;
    };
    let level = LevelArea::of(terrain);
    if level.up_m2 > 0.0 {
        return None;
    }
    let (all_m2, down_m2) = (level.all_m2, level.down_m2);
    if let (Some(name), None) = (&source.cloud, source.eye_m)
        && down_m2 > LEVEL_PART * all_m2
    {
        return Some(format!(
            "{name}: its floors ({down_m2:.2} of {all_m2:.2} m²) face down: where the sensor stood is not its origin; \
             give the --eye"
        ));
    }
    let R_VW = source.X_WV().rotation.inverse();
    let faces = terrain.faces.iter();
    let in_V = faces.map(|face| (R_VW * face.normal_W(), face.region.area()));
    let (up_V, level_m2) = up_by_planes(&in_V.collect::<Vec<_>>(), None)?;
    let tilt = (source.X_WV().rotation * up_V).angle(&Vector3::z());
    (level_m2 > LEVEL_PART * all_m2).then(|| {
        let name = source.depth.as_ref().or(source.cloud.as_ref());
        format!(
            "{}: by its pose nothing that it shows is level, and what is by its planes ({level_m2:.2} of \
             {all_m2:.2} m²) is tilted by {:.0}°: give the sensor's --pose, or --level to take it from the \
             planes",
            name.map_or("the scan", String::as_str),
            tilt.to_degrees(),
        )
    })
}
