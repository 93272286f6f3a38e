//! Files of a drawn world: its mesh and its scene, for anyone to plan in again.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, bail};
use nalgebra::{Point3, Vector3};
use posture::Environment;
use robot_model::{ContactPatch, Kinematics, PatchId, Robot};
use scenes::worlds::families::{Build, Drawn, FAMILIES, Family};

use crate::output;
use crate::provenance::is_standard;
use crate::robot_files::RobotFiles;
use crate::scene::Start;
use crate::start;

/// The family of worlds of this name.
///
/// # Errors
/// An unknown name, with those that there are.
pub fn family(name: &str) -> Result<&'static Family> {
    Family::named(name).with_context(|| {
        let known: Vec<&str> = FAMILIES.iter().map(|f| f.name).collect();
        format!("no family {name:?}; there are {}", known.join(", "))
    })
}

/// The measures of a robot that stands.
///
/// # Errors
/// A robot without feet.
pub fn build(robot: &Robot, config: &posture::Config) -> Result<Build> {
    let stands = start::stand(robot, &Start::default(), &Environment::default(), config)?;
    let kinematics = Kinematics::new(robot, &stands.configuration);
    let feet = &stands.patches;
    let corners = |foot: &PatchId| -> Vec<Point3<f64>> {
        let patch = &robot.patches[*foot];
        let X_WC = kinematics.X_WC(patch);
        let radius = patch.point_radius_m().unwrap_or(0.0);
        let about = [-radius, radius].map(|r| X_WC * Point3::origin() + Vector3::new(r, r, 0.0));
        let corners = patch.polygon.iter();
        corners
            .map(|p| X_WC * Point3::new(p.x, p.y, 0.0))
            .chain(about)
            .collect()
    };
    let all: Vec<Point3<f64>> = feet.iter().flat_map(corners).collect();
    let body = robot.collision.shapes().iter().flat_map(|shape| {
        let X_WG = kinematics.X_WB[shape.body] * shape.X_BG;
        let vertices = shape.geometry.vertices().into_iter();
        vertices.map(move |p| X_WG * p)
    });
    let body: Vec<Point3<f64>> = body.chain(all.iter().copied()).collect();
    let foot = corners(feet.first().context("the robot has no feet")?);
    Ok(Build {
        height_m: stands.configuration.p_WB.z,
        stance_m: [extent(&all, 1), extent(&all, 0)],
        width_m: extent(&body, 1),
        top_m: body.iter().map(|p| p.z).fold(0.0, f64::max),
        hands: with_role(robot, "hand").count(),
        foot_m: extent(&foot, 0),
        feet: feet.len(),
    })
}

/// The patches of a role.
fn with_role<'r>(robot: &'r Robot, role: &'r str) -> impl Iterator<Item = &'r ContactPatch> {
    robot
        .patches
        .iter()
        .filter(move |patch| patch.has_role(role))
}

fn extent(points: &[Point3<f64>], axis: usize) -> f64 {
    let along = || points.iter().map(|p| p[axis]);
    along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
}

/// Writes `NAME.obj` and `NAME.toml` into the folder.
///
/// # Errors
/// A file that cannot be written, a robot's file that does not exist.
pub fn write(
    folder: &Path,
    name: &str,
    drawn: &Drawn,
    files: &RobotFiles,
    robot: &Robot,
) -> Result<()> {
    let obj = format!("{name}.obj");
    output::write(&folder.join(&obj), mesh(drawn)?.as_bytes())?;
    let scene = scene(name, &obj, drawn, files, robot)?;
    output::write(&folder.join(format!("{name}.toml")), scene.as_bytes())
}

/// The scene of a drawn world whose mesh is in the file `obj`.
///
/// # Errors
/// A robot's file that does not exist.
pub fn scene(
    name: &str,
    obj: &str,
    drawn: &Drawn,
    files: &RobotFiles,
    robot: &Robot,
) -> Result<String> {
    let mut scene = format!("name = {name:?}\nmesh_file = {obj:?}\n\n[robot]\n");
    let urdf = match files.is_builtin() {
        true => files.urdf.clone(),
        false if is_standard(Path::new(&files.urdf)) => {
            bail!("-: the scene of a drawn world names its robot: give the URDF as a file")
        }
        false => absolute(Path::new(&files.urdf))?,
    };
    writeln!(scene, "urdf = {urdf:?}")?;
    for (key, path) in [
        ("srdf", &files.beside.srdf),
        ("contacts", &files.beside.contacts),
    ] {
        if let Some(path) = path {
            writeln!(scene, "{key} = {:?}", absolute(path)?)?;
        }
    }
    let goal_m = drawn.goal_m;
    writeln!(scene, "\n[goal]\nbase_position_m = {goal_m:?}")?;
    if let Some(yaw_rad) = drawn.yaw_rad {
        writeln!(scene, "yaw_rad = {yaw_rad:?}")?;
    }
    if let Some([feet, hands]) = drawn.friction {
        writeln!(
            scene,
            "\n[friction]\ndefault = {feet:?}\n\n[friction.patch]"
        )?;
        for patch in with_role(robot, "hand") {
            writeln!(scene, "{:?} = {hands:?}", patch.name)?;
        }
    }
    Ok(scene)
}

fn absolute(path: &Path) -> Result<String> {
    let found = path.canonicalize();
    let found = found.with_context(|| format!("{}: cannot be found", path.display()))?;
    Ok(found.display().to_string())
}

/// The boxes as a Wavefront OBJ in W, m.
///
/// # Errors
/// Never: kept for what writing returns.
pub fn mesh(drawn: &Drawn) -> Result<String> {
    let mut text = String::new();
    let mut count = 0;
    for body in &drawn.boxes {
        writeln!(text, "o {}", body.name.replace(' ', "_"))?;
        for face in body.faces() {
            for p in &face.vertices_W {
                writeln!(text, "v {} {} {}", p.x, p.y, p.z)?;
            }
            let corners: Vec<String> = (1..=face.vertices_W.len())
                .map(|k| (count + k).to_string())
                .collect();
            writeln!(text, "f {}", corners.join(" "))?;
            count += face.vertices_W.len();
        }
    }
    Ok(text)
}
