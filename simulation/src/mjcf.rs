//! A robot and its world as MuJoCo's model text (MJCF).
//!
//! The robot is the parsed one, so that what is simulated is what was planned for: bodies with
//! lumped inertias, joints with limits and efforts, collision shapes, and for self-collision
//! exactly the pairs that the robot model watches. The root floats.
//!
//! | MJCF name | what |
//! |---|---|
//! | `b{i}`, `j{i}`, `a{i}` | body i, its joint, the joint's actuator |
//! | `s{k}` | collision shape k |
//! | `w{k}` | body k of the world |
//!
//! `mjcf.xml` is the template of the text.

use nalgebra::{Isometry3, Matrix3, Point3, Vector2, Vector3};
use robot_model::collision::{ShapeGeometry, closest};
use robot_model::{Body, GRAVITY_M_S2, JointKind, Robot};
use serde_json::{Value, json};

use crate::Error;
use crate::physics::{Physics, Scales, Servo};
use crate::world::{WorldBody, WorldShape};

/// Mass, kg, and moments, kg·m², of a body that has none: just more than MuJoCo takes for none.
const MASSLESS: f64 = 1e-10;
/// What rounding may take off a moment of inertia, relative.
const ROUNDING: f64 = 1e-6;

/// The most points of contact that MuJoCo gives two hulls.
const POINTS_OF_CONTACT: usize = 4;
/// Radius of the ball that is a corner of a patch, m.
const CORNER_M: f64 = 0.001;

/// The model text of `robot` in `world` with position servos of these gains.
///
/// # Errors
/// [`Error::Robot`] where the template cannot be filled in.
pub fn model(
    robot: &Robot,
    world: &[WorldBody],
    physics: &Physics,
    servo: Servo,
    scales: &Scales,
) -> Result<String, Error> {
    let corners: Vec<Corner> = corners(robot).collect();
    let mut open: Vec<usize> = Vec::new();
    let mut bodies = Vec::new();
    // The tree of bodies, depth first as the robot's bodies are.
    for (i, body) in robot.bodies.iter().enumerate() {
        let on = (open.iter()).rposition(|top| Some(*top) == body.parent);
        let stays = on.map_or(0, |k| k + 1);
        let friction = friction_of(robot, i).unwrap_or(physics.friction_elsewhere);
        let mut said = link(body, scales.mass);
        said["armature"] = json!(physics.armature_of(body.effort));
        said["damping"] = json!(physics.damping_of(body));
        said["closes"] = json!(open.len() - stays);
        said["friction"] = json!(friction * scales.friction);
        said["shapes"] = shapes(robot, &corners, i);
        bodies.push(said);
        open.truncate(stays);
        open.push(i);
    }
    let said = json!({
        "dt_s": physics.dt_s,
        "gravity_m_s2": GRAVITY_M_S2,
        "kp": servo.kp,
        "kv": servo.kv,
        "meshes": meshes(robot, world),
        "world": world.iter().enumerate().map(world_form).collect::<Vec<_>>(),
        "bodies": bodies,
        "open": open.len(),
        "pairs": robot.collision.pairs(),
        "slippery": slippery(robot, &corners, world, physics, scales),
    });
    let said = minijinja::value::Serde(said);
    let text = minijinja::Environment::new().render_str(include_str!("mjcf.xml"), said);
    text.map_err(|e| Error::Robot(e.to_string()))
}

/// The hulls, as meshes of which MuJoCo takes the hull.
fn meshes(robot: &Robot, world: &[WorldBody]) -> Vec<(String, Vec<f64>)> {
    let flat = |points: &[Point3<f64>]| points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    let shapes = robot.collision.shapes().iter().enumerate();
    let shapes = shapes.filter_map(|(k, shape)| match &shape.geometry {
        ShapeGeometry::ConvexHull(hull) => Some((format!("s{k}"), flat(hull.vertices()))),
        _ => None,
    });
    let world = world.iter().enumerate();
    let world = world.filter_map(|(k, body)| match &body.shape {
        WorldShape::Hull(points) => Some((format!("w{k}"), flat(points))),
        WorldShape::Box { .. } => None,
    });
    shapes.chain(world).collect()
}

/// Geom, body of the world and friction of the pairs that have less of it than the robot's patches.
fn slippery(
    robot: &Robot,
    corners: &[Corner],
    world: &[WorldBody],
    physics: &Physics,
    scales: &Scales,
) -> Vec<(String, usize, f64)> {
    let own = world.iter().enumerate();
    let own = own.filter_map(|(w, body)| Some((w, body.friction?)));
    let all = robot.collision.shapes();
    let geoms = || {
        let shapes = (0..all.len()).map(|k| (format!("s{k}"), k));
        shapes.chain(corners.iter().map(|c| (c.name.clone(), c.shape)))
    };
    own.flat_map(|(w, most)| {
        geoms().filter_map(move |(name, shape)| {
            let robots = friction_of(robot, all[shape].body).unwrap_or(physics.friction_elsewhere);
            (most < robots).then_some((name, w, most * scales.friction))
        })
    })
    .collect()
}

fn world_form((k, body): (usize, &WorldBody)) -> String {
    match &body.shape {
        WorldShape::Box { X_WO, half_m } => format!("{} {}", solid_box(half_m), pose(X_WO)),
        WorldShape::Hull(_) => format!(r#"type="mesh" mesh="w{k}""#),
    }
}

/// Joint and inertia of a body; efforts without a bound are left out.
fn link(body: &Body, mass_scale: f64) -> Value {
    let inertia = match body.mass_kg > 0.0 {
        true => body.inertia_B,
        false => Matrix3::zeros(),
    };
    // Links may state a mass and no moments, or moments of which two are less than the third; as much about every
    // axis as lacks makes it a body's inertia.
    let moments = inertia.symmetric_eigenvalues();
    let short = 2.0 * moments.max() * (1.0 + ROUNDING) - moments.sum();
    let lacks = (MASSLESS - moments.min()).max(short).max(0.0);
    let inertia = inertia + Matrix3::identity() * lacks;
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    json!({
        "pose": pose(&body.X_PJ),
        "slides": body.kind == JointKind::Prismatic,
        "axis": numbers(body.axis.as_slice()),
        "range": numbers(&[body.lower, body.upper]),
        "effort": body.effort,
        "com": numbers(body.com_B.as_slice()),
        "mass_kg": body.mass_kg.max(MASSLESS) * mass_scale,
        "inertia": numbers(&entries.map(|at| inertia[at] * mass_scale)),
    })
}

/// Name and form of the collision shapes of a body, and of the corners of its patches.
fn shapes(robot: &Robot, corners: &[Corner], body: usize) -> Value {
    let of_body = |shape: usize| robot.collision.shapes()[shape].body == body;
    let shapes = robot.collision.shapes().iter().enumerate();
    let shapes = shapes.map(|(k, shape)| {
        let form = geometry(k, &shape.geometry);
        (format!("s{k}"), k, format!("{form} {}", pose(&shape.X_BG)))
    });
    let corners = corners.iter().map(|corner| {
        let at = numbers(corner.p_B.coords.as_slice());
        let form = format!(r#"type="sphere" size="{CORNER_M}" pos="{at}""#);
        (corner.name.clone(), corner.shape, form)
    });
    let own = shapes
        .chain(corners)
        .filter(|(_, shape, _)| of_body(*shape));
    own.map(|(name, _, form)| json!([name, form])).collect()
}

/// A corner of a patch, as a small ball of its own.
pub struct Corner {
    /// Name of its geom.
    pub name: String,
    /// The collision shape that it is part of.
    pub shape: usize,
    /// Its middle in the body, m.
    p_B: Point3<f64>,
}

/// The corners of patches that have more than two hulls have points of contact in MuJoCo: of a sole of eight corners four
/// would carry, and it would tip over the line between two of them that are far inside its edge.
pub fn corners(robot: &Robot) -> impl Iterator<Item = Corner> {
    let patches = robot.patches.iter().enumerate();
    let many = patches.filter(|(_, patch)| patch.polygon.len() > POINTS_OF_CONTACT);
    many.flat_map(move |(number, patch)| {
        let middle = patch.polygon.iter().map(|p| p.coords).sum::<Vector2<f64>>()
            / patch.polygon.len() as f64;
        (patch.polygon.iter().enumerate()).filter_map(move |(k, corner)| {
            let inward = (middle - corner.coords).normalize() * CORNER_M;
            let p_C = Point3::new(corner.x + inward.x, corner.y + inward.y, CORNER_M);
            let p_B = patch.X_BC * p_C;
            let (name, shape) = (format!("c{number}_{k}"), shape_at(robot, patch.body, &p_B)?);
            Some(Corner { name, shape, p_B })
        })
    })
}

/// The shape of a body that a corner's ball is deepest in; nothing where a patch is larger than its body.
fn shape_at(robot: &Robot, body: usize, p_B: &Point3<f64>) -> Option<usize> {
    let ball = ShapeGeometry::Sphere { radius_m: CORNER_M };
    let at = Isometry3::from(p_B.coords);
    let shapes = robot.collision.shapes().iter().enumerate();
    let own = shapes.filter(|(_, shape)| shape.body == body);
    let depths = own.filter_map(|(k, shape)| {
        let found = closest(&ball, &at, &shape.geometry, &shape.X_BG, 0.0)?;
        (found.distance < 0.0).then_some((found.distance, k))
    });
    let deepest = depths.min_by(|a, b| a.0.total_cmp(&b.0));
    deepest.map(|(_, shape)| shape)
}

/// The least friction of the patches on a body.
fn friction_of(robot: &Robot, body: usize) -> Option<f64> {
    let own = robot.patches.iter().filter(|patch| patch.body == body);
    own.map(|patch| patch.friction).reduce(f64::min)
}

fn geometry(k: usize, geometry: &ShapeGeometry) -> String {
    match geometry {
        ShapeGeometry::Sphere { radius_m } => format!(r#"type="sphere" size="{radius_m}""#),
        ShapeGeometry::Capsule {
            half_length_m,
            radius_m,
        } => format!(r#"type="capsule" size="{radius_m} {half_length_m}""#),
        ShapeGeometry::Cylinder {
            half_length_m,
            radius_m,
        } => format!(r#"type="cylinder" size="{radius_m} {half_length_m}""#),
        ShapeGeometry::Box { half_extents_m } => solid_box(half_extents_m),
        ShapeGeometry::ConvexHull(_) => format!(r#"type="mesh" mesh="s{k}""#),
    }
}

fn solid_box(half_m: &Vector3<f64>) -> String {
    format!(r#"type="box" size="{}""#, numbers(half_m.as_slice()))
}

fn numbers(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(f64::to_string).collect();
    words.join(" ")
}

fn pose(X: &Isometry3<f64>) -> String {
    let (p, q) = (numbers(X.translation.vector.as_slice()), &X.rotation);
    let q = numbers(&[q.w, q.i, q.j, q.k]);
    format!(r#"pos="{p}" quat="{q}""#)
}
