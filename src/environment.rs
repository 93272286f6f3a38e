//! Scans, a file of surfaces or a mesh → what the robot may touch and must avoid.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Isometry3, Point3};
use perception::{Intrinsics, Scan, SensorOptions};
use scenes::scene_file::ScanSource;
use surfaces::{SurfaceSet, TriangleMesh};

use crate::config::Config;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};

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
            for (number, source) in sources.iter().enumerate() {
                let prefix = if sources.len() > 1 {
                    format!("scan{number}-")
                } else {
                    String::new()
                };
                extract(
                    source,
                    &prefix,
                    files,
                    config,
                    stages,
                    inputs,
                    &mut perceived,
                )?;
            }
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

/// Adds what one scan shows; several scans number their surfaces alike, so `prefix` tells them
/// apart.
#[allow(non_snake_case)]
fn extract(
    source: &ScanSource,
    prefix: &str,
    files: &Files,
    config: &Config,
    stages: &mut Stages,
    inputs: &mut Inputs,
    perceived: &mut Perceived,
) -> Result<()> {
    let (scan, X_WV, name) = read_scan(source, files, stages, inputs)?;
    let extraction = stages
        .measure("perception", || {
            perception::extract(&scan, &X_WV, &config.perception)
        })
        .with_context(|| name.to_owned())?;
    let counts = &extraction.statistics;
    perceived.notes.push(format!(
        "{name}: {} of {} points measured, {} in range, {} on {} planes",
        counts.valid, counts.points, counts.used, counts.assigned, counts.planes
    ));
    perceived.cloud_W.extend(in_W(&scan, &X_WV));
    perceived
        .set
        .surfaces
        .extend(extraction.surfaces.into_iter().map(|mut surface| {
            surface.id.insert_str(0, prefix);
            if let Some(face) = &mut surface.face {
                face.insert_str(0, prefix);
            }
            surfaces::level::leveled(surface, &config.surfaces.level)
        }));
    Ok(())
}

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
        eye_m: None,
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
