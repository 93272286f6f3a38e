//! Scans, a file of surfaces or a mesh → what the robot may touch and must avoid.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Matrix4, UnitQuaternion, Vector4};
use perception::lidar::{LidarCalibration, LidarCloud};
use perception::{BagOptions, Intrinsics, PosedScan, Scan, SensorOptions};
use scenes::scene_file::ScanSource;
use surfaces::{LookedThrough, Terrain, TriangleMesh};

use crate::config::Config;
use crate::mistakes;
use crate::provenance::{self, Inputs};
use crate::report::Stages;
use crate::scene::{Environment, Files};
use crate::slope::calibration_file;

pub mod levelled;
mod plausible;

/// The environment, and the points that it was seen by.
#[derive(Clone, Debug, Default)]
pub struct Perceived {
    /// Faces and obstacles in W.
    pub terrain: Terrain,
    /// The scans' points in W, m.
    pub cloud_W: Vec<[f32; 3]>,
    /// What each scan looked through.
    pub looked: Vec<LookedThrough>,
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
            let read = sources.iter();
            let read = read.map(|source| ReadScan::new(source, files, stages, inputs));
            let read = mistakes::all(read)?;
            let scans: Vec<PosedScan> = read.iter().map(ReadScan::posed).collect();
            let mut perceived = of_scans(&scans, config, stages)?;
            let notes = read.iter().flat_map(ReadScan::notes).cloned();
            perceived.notes = notes.chain(perceived.notes).collect();
            Ok(perceived)
        }
        Environment::Surfaces(name) => {
            let text = provenance::text(name, files.read("surfaces", name, inputs)?)?;
            let terrain = Terrain::from_json(&text).with_context(|| name.clone())?;
            Ok(Perceived {
                notes: plausible::doubts(name, &terrain),
                terrain,
                ..Perceived::default()
            })
        }
        Environment::Mesh(name) => {
            let bytes = files.read("mesh", name, inputs)?;
            let thickness_m = config.surfaces.body.thickness_m;
            let work = || take_apart(name, &bytes, thickness_m);
            stages.measure("mesh", work)
        }
    }
}

/// What posed scans show.
///
/// # Errors
/// As [`perception::perceive()`].
pub fn of_scans(scans: &[PosedScan], config: &Config, stages: &mut Stages) -> Result<Perceived> {
    let work = || perception::perceive(scans, &config.perception);
    let perceived = stages.measure("perception", work)?;
    let placed = || scans.iter().zip(&perceived.moved_W);
    let looked = || placed().map(|(scan, moved)| scan.looked_through(moved));
    let looked = stages.measure("looked through", || looked().collect());
    let points = placed().flat_map(|(scan, moved)| scan.points_W(moved, 1));
    Ok(Perceived {
        cloud_W: points.collect(),
        looked,
        terrain: perceived.terrain,
        notes: perceived.notices.iter().map(ToString::to_string).collect(),
    })
}

/// The points of an environment's scans in W, m; none of any other environment.
///
/// # Errors
/// As [`perceive`].
pub fn points_W(environment: &Environment, files: &Files) -> Result<Vec<[f32; 3]>> {
    let Environment::Scans(sources) = environment else {
        return Ok(Vec::new());
    };
    let mut cloud_W = Vec::new();
    for source in sources {
        let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
        let scan = ReadScan::new(source, files, &mut stages, &mut inputs)?;
        cloud_W.extend(scan.posed().points_W(&Isometry3::identity(), 1));
    }
    Ok(cloud_W)
}

/// A scan as it was read, and where it was taken from.
enum ReadScan<'a> {
    Scan {
        name: &'a str,
        scan: Scan,
        X_WV: Isometry3<f64>,
    },
    Lidar {
        name: &'a str,
        cloud: LidarCloud,
        mount: LidarCalibration,
    },
}

impl<'a> ReadScan<'a> {
    fn new(
        source: &'a ScanSource,
        files: &Files,
        stages: &mut Stages,
        inputs: &mut Inputs,
    ) -> Result<Self> {
        let name = source.depth.as_ref().or(source.cloud.as_ref());
        let name = name.context("a scan has no file")?;
        let bytes = files.read("scan", name, inputs)?;
        if source.sensor.as_deref() == Some(perception::lidar::SENSOR) {
            let work = || perception::parse_lidar(Path::new(name), &bytes, None);
            let read = stages.measure("reading", work)?;
            let cloud = match source.eye_m {
                Some(eye_m) => read.cloud.seen_from(eye_m),
                None => read.cloud,
            };
            let mount = mount(source, files, inputs)?;
            return Ok(Self::Lidar { name, cloud, mount });
        }
        let options = sensor_options(source);
        let work = || perception::parse_scan(Path::new(name), &bytes, &options);
        let scan = stages.measure("reading", work)?;
        // What is given stands in the place of what the file states.
        let given = source.position_m.is_some() || source.quat_xyzw.is_some();
        let X_WV = if given { source.X_WV() } else { scan.X_WV };
        Ok(Self::Scan { name, scan, X_WV })
    }

    fn notes(&self) -> &[String] {
        match self {
            Self::Scan { scan, .. } => &scan.notes,
            Self::Lidar { .. } => &[],
        }
    }

    fn posed(&self) -> PosedScan<'_> {
        match self {
            Self::Scan { name, scan, X_WV } => PosedScan::Scan {
                name,
                scan,
                X_WV: *X_WV,
            },
            Self::Lidar { name, cloud, mount } => PosedScan::Lidar { name, cloud, mount },
        }
    }
}

/// What is known of a LiDAR's mount: its calibration at the scan's pose, or the pose alone, which is
/// known as well as a calibration would tell it.
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

/// Standard deviations of a mount's angles (rad) and height (m) where a scene gives the pose.
const MOUNT_RAD: f64 = 0.002;
const MOUNT_M: f64 = 0.005;

/// What the reader must know beside the file.
pub fn sensor_options(source: &ScanSource) -> SensorOptions {
    let intrinsics = match (source.fx, source.fy, source.cx, source.cy) {
        (Some(fx), Some(fy), Some(cx), Some(cy)) => Some(Intrinsics { fx, fy, cx, cy }),
        _ => None,
    };
    let generic = intrinsics.is_some() || source.cloud.is_some();
    let unnamed = if generic { "generic" } else { "xtion" };
    SensorOptions {
        sensor: source.sensor.clone().unwrap_or_else(|| unnamed.to_owned()),
        intrinsics,
        depth_scale_m: source.depth_scale_m,
        eye_m: source.eye_m,
        bag: BagOptions {
            topic: source.topic.clone(),
            at_s: source.at_s,
            frame: source.frame.clone(),
        },
    }
}

/// The surfaces and bodies of a mesh file.
fn take_apart(name: &str, bytes: &[u8], thickness_m: f64) -> Result<Perceived> {
    let read = robot_model::mesh_file::parse(Path::new(name), bytes)?;
    let (vertices, triangles) = (read.vertices.iter(), read.triangles.iter());
    let mesh = TriangleMesh {
        vertices: vertices.map(|p| read.R_up * p).collect(),
        triangles: triangles.map(|t| t.map(|v| v as usize)).collect(),
    };
    let extracted = surfaces::mesh::extract(&mesh, thickness_m);
    let (terrain, report) = extracted.with_context(|| name.to_owned())?;
    let mut notes = vec![format!(
        "{name}: {} triangles, {} plane faces kept, {} too small, {} solids",
        report.triangles, report.faces, report.faces_dropped, report.solids
    )];
    let wound = "edges whose triangles are wound in opposite ways";
    let turned =
        "triangles turned, that were wound otherwise than most of what they are connected with";
    let inward = "closed parts that face inward: rooms seen from inside, or turned inside out";
    for (n, flaw) in [
        (report.open_edges, "open edges"),
        (report.inward_parts, inward),
        (report.crowded_edges, "edges of more than two triangles"),
        (report.flipped_edges, wound),
        (report.turned_triangles, turned),
        (
            report.stitched_edges,
            "edges split where others end on them",
        ),
        (report.faces_broken, "faces whose outline could not be used"),
        (
            report.flat_parts,
            "closed parts without an inside: no solids",
        ),
    ] {
        if n > 0 {
            notes.push(format!("{name}: {n} {flaw}"));
        }
    }
    if read.R_up != UnitQuaternion::identity() {
        notes.push(format!(
            "{name}: its up_axis is not z: turned so that it is"
        ));
    }
    notes.extend(
        plausible::of_mesh(name, &mesh, report.part_dropped)
            .or_else(|| plausible::of_turned(name, &terrain, read.R_up))
            .map_or_else(|| plausible::doubts(name, &terrain), |doubt| vec![doubt]),
    );
    Ok(Perceived {
        terrain,
        notes,
        ..Perceived::default()
    })
}
