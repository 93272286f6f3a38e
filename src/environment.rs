//! Scans, a file of surfaces or a mesh → what the robot may touch and must avoid.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Matrix4, Point3, Vector4};
use perception::lidar::{LidarCalibration, LidarCloud};
use perception::{Intrinsics, Scan, SensorOptions, Several};
use scenes::scene_file::ScanSource;
use surfaces::merge::{Change, Seen, Sight, View};
use surfaces::{SurfaceSet, TriangleMesh, rim};

use crate::config::Config;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};
use crate::slope::calibration_file;

/// Of so many points of a scan one tells what is free behind a wall.
const SEEN_STEP: usize = 16;

/// The environment, and the points that it was seen by.
#[allow(non_snake_case)]
#[derive(Clone, Debug, Default)]
pub struct Perceived {
    /// Surfaces and obstacles in W.
    pub set: SurfaceSet,
    /// The scans' points in W, m.
    pub cloud_W: Vec<[f32; 3]>,
    /// What was read and found, for the user.
    pub notes: Vec<String>,
}

/// Reads an environment and extracts its surfaces.
///
/// # Errors
/// A file that cannot be read or used, with its name and the cause.
pub fn perceive(
    environment: &Environment,
    files: &Files,
    config: &Config,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<Perceived> {
    match environment {
        Environment::Scans(sources) => {
            let mut perceived = Perceived::default();
            let mut several = Several::default();
            for source in sources {
                let mut shown = show(source, files, config, stages, inputs)?;
                let registration = &config.perception.registration;
                match several.add(shown.view, registration) {
                    Some(Ok(found)) => {
                        shown.notes.push(registered(&found));
                        move_all(&mut shown.cloud_W, &found.X_W);
                    }
                    Some(Err(cause)) => {
                        let stays = format!("{}: stays at the pose given: {cause}", shown.name);
                        shown.notes.push(stays);
                    }
                    None => {}
                }
                perceived.notes.extend(shown.notes);
                perceived.cloud_W.extend(shown.cloud_W);
            }
            // Faces that more than one scan shows are one.
            let merging = &config.surfaces.merge;
            let merged = stages.measure("perception", || several.merged(merging));
            perceived.notes.extend(merged.changes.iter().map(told));
            perceived.set.surfaces = merged.surfaces;
            perceived.set.obstacles = merged.obstacles;
            // What may be there beside what can be touched.
            let seen = perceived.cloud_W.iter().step_by(SEEN_STEP);
            let free: Vec<Point3<f64>> = seen.map(|p| Point3::from(p.map(f64::from))).collect();
            let set = &mut perceived.set;
            let (body, rim) = (&config.surfaces.body, &config.surfaces.rim);
            let rims = rim::widen(&mut set.surfaces, &free, body, rim);
            set.obstacles.extend(rims);
            Ok(perceived)
        }
        Environment::Surfaces(name) => {
            let bytes = files.read("surfaces", name, inputs)?;
            let text =
                std::str::from_utf8(&bytes).with_context(|| format!("{name}: not a text file"))?;
            let set = SurfaceSet::from_json(text).with_context(|| name.clone())?;
            Ok(Perceived {
                set,
                ..Perceived::default()
            })
        }
        Environment::Mesh(name) => {
            let bytes = files.read("mesh", name, inputs)?;
            stages
                .measure("mesh", || take_apart(name, &bytes, &config.surfaces.mesh))
                .with_context(|| name.clone())
        }
    }
}

/// The points of an environment's scans in W, m; none of any other environment.
///
/// # Errors
/// As [`perceive`].
#[allow(non_snake_case)]
pub fn points_W(environment: &Environment, files: &Files) -> Result<Vec<[f32; 3]>> {
    let Environment::Scans(sources) = environment else {
        return Ok(Vec::new());
    };
    let mut cloud_W = Vec::new();
    for source in sources {
        if is_lidar(source) {
            let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
            let (cloud, _) = read_lidar(source, files, &mut stages, &mut inputs)?;
            let X_WV = mount(source, files, &mut inputs)?.X_WV();
            cloud_W.extend(cloud.points_V.iter().map(|p| -> [f32; 3] {
                let p_W = X_WV * Point3::from(p.map(f64::from));
                p_W.coords.map(|x| x as f32).into()
            }));
            continue;
        }
        let (scan, X_WV, _) = read_scan(
            source,
            files,
            &mut Stages::default(),
            &mut Inputs::default(),
        )?;
        cloud_W.extend(in_W(&scan, &X_WV));
    }
    Ok(cloud_W)
}

/// What one scan shows.
#[allow(non_snake_case)]
struct Shown {
    name: String,
    view: View,
    cloud_W: Vec<[f32; 3]>,
    notes: Vec<String>,
}

/// Extracts the surfaces of one scan.
#[allow(non_snake_case)]
fn show(
    source: &ScanSource,
    files: &Files,
    config: &Config,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<Shown> {
    if is_lidar(source) {
        return detect(source, files, config, stages, inputs);
    }
    let (scan, X_WV, name) = read_scan(source, files, stages, inputs)?;
    let extraction = stages
        .measure("perception", || {
            perception::extract(&scan, &X_WV, &config.perception)
        })
        .with_context(|| name.to_owned())?;
    let counts = &extraction.statistics;
    let note = format!(
        "{name}: {} of {} points measured, {} in range, {} on {} planes",
        counts.valid, counts.points, counts.used, counts.assigned, counts.planes
    );
    let surfaces = extraction.surfaces.into_iter();
    let range_max_m = config.perception.range_max_m;
    Ok(Shown {
        name: name.to_owned(),
        view: View {
            surfaces: surfaces
                .map(|surface| surfaces::level::leveled(surface, &config.surfaces.level))
                .collect(),
            obstacles: extraction.obstacles,
            sight: perception::sight(&scan, &X_WV, range_max_m, perception::SIGHT_STEP),
        },
        cloud_W: in_W(&scan, &X_WV).collect(),
        notes: vec![note],
    })
}

/// How a scan was moved onto those before it.
fn registered(found: &perception::Registration) -> String {
    let (turn, shift) = (
        found.X_W.rotation.angle().to_degrees(),
        (found.X_W * found.about_W - found.about_W).norm(),
    );
    let (before, after) = found.offset_rms_m;
    format!(
        "    registered by {} planes: moved by {:.1} mm and {turn:.2}°; they lay {:.1} mm apart, now \
         {:.1} mm (χ² per degree of freedom {:.2})",
        found.pairs.len(),
        1e3 * shift,
        1e3 * before,
        1e3 * after,
        found.misfit
    )
}

/// What became of a face, in words.
fn told(change: &Change) -> String {
    match change {
        Change::Joined { id, with } => format!("{id} and {} are one face", with.join(", ")),
        Change::Cut { id, area_m2 } => {
            format!("warning: a later scan looks through {area_m2:.3} m² of {id}: taken off")
        }
        Change::Dropped { id } => {
            format!("warning: a later scan looks through {id}: dropped")
        }
    }
}

/// Moves points of W.
#[allow(non_snake_case)]
fn move_all(cloud_W: &mut [[f32; 3]], X_W: &Isometry3<f64>) {
    for p in cloud_W {
        let moved = X_W * Point3::from(p.map(f64::from));
        *p = moved.coords.map(|x| x as f32).into();
    }
}

/// Whether a scan is a spinning LiDAR's.
fn is_lidar(source: &ScanSource) -> bool {
    source.sensor.as_deref() == Some(perception::lidar::SENSOR)
}

/// Standard deviation of a LiDAR's range where its rings are not calibrated, m.
const LIDAR_SIGMA_M: f64 = 0.015;

/// Ground, slopes, walls and things that a LiDAR's cloud shows, the sensor at the scan's pose.
#[allow(non_snake_case)]
fn detect(
    source: &ScanSource,
    files: &Files,
    config: &Config,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<Shown> {
    let (cloud, name) = read_lidar(source, files, stages, inputs)?;
    let mount = mount(source, files, inputs)?;
    let seen = stages
        .measure("perception", || {
            perception::lidar::look_around(&cloud, Some(&mount), &config.perception.lidar)
        })
        .with_context(|| name.to_owned())?;
    let scan = seen.scan.with_context(|| format!("{name}: no ground"))?;
    let counts = &scan.counts;
    let mut notes = vec![format!(
        "{name}: {} points, {} in view, {} not isolated, {} on the ground",
        counts.points, counts.in_view, counts.kept, counts.ground
    )];
    for (number, slope) in scan.slopes.iter().enumerate() {
        let d = &slope.description;
        notes.push(format!(
            "slope {number}: {:.2}° ± {:.2}°, from ({:.3}, {:.3}) to ({:.3}, {:.3}) m",
            d.delta_rad.to_degrees(),
            slope.delta_sigma_rad.to_degrees(),
            d.p1_W.x,
            d.p1_W.y,
            d.p2_W.x,
            d.p2_W.y
        ));
    }
    let around = seen.around;
    notes.push(format!(
        "{} parts of walls, {} things around",
        around.walls.len(),
        around.things.len()
    ));
    let point = |p: &[f32; 3]| Seen {
        p_W: Point3::from(p.map(f64::from)),
        sigma_m: LIDAR_SIGMA_M,
    };
    let walls = around.surfaces().cloned();
    Ok(Shown {
        name: name.to_owned(),
        view: View {
            surfaces: scan.surfaces().into_iter().chain(walls).collect(),
            obstacles: around.obstacles().cloned().collect(),
            sight: Sight {
                eye_W: Point3::from(mount.X_WV().translation.vector),
                points: scan.points_W.iter().map(point).collect(),
            },
        },
        cloud_W: scan.points_W,
        notes,
    })
}

/// What is known of a LiDAR's mount: its calibration at the scan's pose, or the pose alone, which is
/// known as well as a calibration would tell it.
#[allow(non_snake_case)]
fn mount(source: &ScanSource, files: &Files, inputs: &mut Inputs) -> Result<LidarCalibration> {
    if let Some(name) = &source.calibration {
        let bytes = files.read("calibration", name, inputs)?;
        let calibration = calibration_file::parse(&bytes).with_context(|| name.clone())?;
        return Ok(calibration.placed(&source.X_WV()));
    }
    let tilt = MOUNT_RAD * MOUNT_RAD;
    let known = Matrix4::from_diagonal(&Vector4::new(tilt, tilt, tilt, MOUNT_M * MOUNT_M));
    let [x, y, z] = source.eye_m.unwrap_or_default();
    let X_WV = source.X_WV() * Isometry3::translation(x, y, z);
    Ok(LidarCalibration::from_pose(&X_WV, &known))
}

/// A LiDAR's cloud and its name.
fn read_lidar<'a>(
    source: &'a ScanSource,
    files: &Files,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<(LidarCloud, &'a str)> {
    let name = source
        .cloud
        .as_ref()
        .context("a LiDAR's scan has no cloud")?;
    let bytes = files.read("scan", name, inputs)?;
    let read = stages.measure("reading", || {
        perception::parse_lidar(Path::new(name), &bytes, None)
    })?;
    let cloud = match source.eye_m {
        Some(eye_m) => read.cloud.seen_from(eye_m),
        None => read.cloud,
    };
    Ok((cloud, name))
}

/// Standard deviations of a mount's angles (rad) and height (m) where a scene gives the pose.
const MOUNT_RAD: f64 = 0.002;
const MOUNT_M: f64 = 0.005;

/// A scan, the pose of its frame V in W, and its name.
#[allow(non_snake_case)]
fn read_scan<'a>(
    source: &'a ScanSource,
    files: &Files,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<(Scan, Isometry3<f64>, &'a str)> {
    let name = source
        .depth
        .as_ref()
        .or(source.cloud.as_ref())
        .context("a scan has no file")?;
    let bytes = files.read("scan", name, inputs)?;
    let options = sensor_options(source);
    let scan = stages.measure("reading", || {
        perception::parse_scan(Path::new(name), &bytes, &options)
    })?;
    let X_WV = source.X_WV() * scan.X_WV;
    Ok((scan, X_WV, name))
}

/// What the reader must know beside the file.
fn sensor_options(source: &ScanSource) -> SensorOptions {
    let intrinsics = match (source.fx, source.fy, source.cx, source.cy) {
        (Some(fx), Some(fy), Some(cx), Some(cy)) => Some(Intrinsics { fx, fy, cx, cy }),
        _ => None,
    };
    let unnamed = if intrinsics.is_some() || source.cloud.is_some() {
        "generic"
    } else {
        "xtion"
    };
    SensorOptions {
        sensor: source.sensor.clone().unwrap_or_else(|| unnamed.to_owned()),
        intrinsics,
        depth_scale_m: source.depth_scale_m,
        eye_m: source.eye_m,
    }
}

/// The measured points in W, m.
#[allow(non_snake_case)]
fn in_W<'a>(scan: &'a Scan, X_WV: &'a Isometry3<f64>) -> impl Iterator<Item = [f32; 3]> + 'a {
    scan.cloud.finite().map(move |p| {
        let p_W = X_WV * Point3::from(p.map(f64::from));
        p_W.coords.map(|x| x as f32).into()
    })
}

/// The surfaces and bodies of a mesh file.
fn take_apart(name: &str, bytes: &[u8], config: &surfaces::mesh::Config) -> Result<Perceived> {
    let read = robot_model::mesh_file::parse(Path::new(name), bytes)?;
    let mesh = TriangleMesh {
        vertices: read.vertices,
        triangles: read
            .triangles
            .iter()
            .map(|t| t.map(|vertex| vertex as usize))
            .collect(),
    };
    let (set, report) = surfaces::mesh::extract(&mesh, config)?;
    let mut notes = vec![format!(
        "{name}: {} triangles, {} plane faces kept, {} too small, {} solids",
        report.triangles, report.faces, report.faces_dropped, report.solids
    )];
    let flaws = [
        (report.open_edges, "open edges"),
        (report.crowded_edges, "edges of more than two triangles"),
        (
            report.flipped_edges,
            "edges whose triangles are wound in opposite ways",
        ),
        (report.faces_broken, "faces whose outline could not be used"),
    ];
    notes.extend(
        flaws
            .iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, flaw)| format!("{name}: {n} {flaw}")),
    );
    Ok(Perceived {
        set,
        cloud_W: Vec::new(),
        notes,
    })
}
