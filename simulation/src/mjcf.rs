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
#![allow(non_snake_case)]

use std::fmt::Write;

use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::collision::ShapeGeometry;
use robot_model::{Body, GRAVITY_M_S2, JointKind, Robot};

use crate::Error;
use crate::physics::{Physics, Scales, Servo};
use crate::world::{WorldBody, WorldShape};

/// Robot shapes meet bodies of the world through this bit, and each other through listed pairs.
const ROBOT_BIT: u32 = 1;

/// Ratio of frictional to normal constraint impedance; high values keep contacts from creeping on
/// slopes.
const IMPRATIO: f64 = 100.0;
/// Time constant of contacts, s, and their damping ratio.
const CONTACT_TIME_S: f64 = 0.004;
const CONTACT_DAMPING: f64 = 1.0;

/// The model text of `robot` in `world` with position servos of these gains.
///
/// # Errors
/// [`Error::Robot`] where a moving body has no mass.
pub fn model(
    robot: &Robot,
    world: &[WorldBody],
    physics: &Physics,
    servo: Servo,
    scales: &Scales,
) -> Result<String, Error> {
    let mut xml = Text::default();
    xml.line(r#"<mujoco model="scandent">"#);
    xml.line(r#"<compiler angle="radian" inertiafromgeom="false" autolimits="true"/>"#);
    xml.line(&format!(
        r#"<option timestep="{}" gravity="0 0 {}" integrator="implicitfast" cone="elliptic" impratio="{IMPRATIO}"><flag multiccd="enable"/></option>"#,
        physics.dt_s, -GRAVITY_M_S2
    ));
    xml.line(r#"<visual><global offwidth="1920" offheight="1080"/><headlight ambient="0.35 0.35 0.35" diffuse="0.5 0.5 0.5"/></visual>"#);
    xml.line(&format!(
        r#"<default><geom condim="3" solref="{CONTACT_TIME_S} {CONTACT_DAMPING}"/><pair condim="3" solref="{CONTACT_TIME_S} {CONTACT_DAMPING}"/></default>"#
    ));
    assets(&mut xml, robot, world);
    xml.line("<worldbody>");
    xml.line(r#"<light pos="0 -3 6" dir="0 0.4 -1" directional="true" diffuse="0.5 0.5 0.5"/>"#);
    for (k, body) in world.iter().enumerate() {
        world_geom(&mut xml, k, body);
    }
    bodies(&mut xml, robot, physics, scales)?;
    xml.line("</worldbody>");
    self_collision(&mut xml, robot);
    actuators(&mut xml, robot, servo);
    xml.line("</mujoco>");
    Ok(xml.text)
}

#[derive(Default)]
struct Text {
    text: String,
}

impl Text {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }
}

/// The hulls, as meshes of which MuJoCo takes the hull.
fn assets(xml: &mut Text, robot: &Robot, world: &[WorldBody]) {
    xml.line("<asset>");
    xml.line(r#"<texture type="skybox" builtin="gradient" rgb1="0.72 0.8 0.9" rgb2="1 1 1" width="64" height="384"/>"#);
    let mut mesh = |name: String, points: &[Point3<f64>]| {
        let mut vertices = String::new();
        for p in points {
            let _ = write!(vertices, "{} {} {} ", p.x, p.y, p.z);
        }
        let vertices = vertices.trim_end();
        xml.line(&format!(
            r#"<mesh name="{name}" inertia="convex" vertex="{vertices}"/>"#
        ));
    };
    for (k, shape) in robot.collision.shapes().iter().enumerate() {
        if let ShapeGeometry::ConvexHull(hull) = &shape.geometry {
            mesh(format!("s{k}"), hull.vertices());
        }
    }
    for (k, body) in world.iter().enumerate() {
        if let WorldShape::Hull(points) = &body.shape {
            mesh(format!("w{k}"), points);
        }
    }
    xml.line("</asset>");
}

fn world_geom(xml: &mut Text, k: usize, body: &WorldBody) {
    // Friction is that of the robot's patches: MuJoCo takes the greater one of a pair.
    let bits = format!(r#"contype="0" conaffinity="{ROBOT_BIT}" friction="0 0 0""#);
    let grey = 0.55 + 0.08 * (k % 4) as f64;
    let colour = format!(r#"rgba="{grey} {grey} {} 1""#, grey * 0.9);
    let shape = match &body.shape {
        WorldShape::Box { X_WO, half_m } => format!("{} {}", solid_box(half_m), pose(X_WO)),
        WorldShape::Hull(_) => format!(r#"type="mesh" mesh="w{k}""#),
    };
    xml.line(&format!(r#"<geom name="w{k}" {shape} {bits} {colour}/>"#));
}

/// The tree of bodies, depth first as the robot's bodies are.
fn bodies(xml: &mut Text, robot: &Robot, physics: &Physics, scales: &Scales) -> Result<(), Error> {
    let mut open: Vec<usize> = Vec::new();
    for (i, body) in robot.bodies.iter().enumerate() {
        while open.last().is_some_and(|top| Some(*top) != body.parent) {
            xml.line("</body>");
            open.pop();
        }
        open.push(i);
        xml.line(&format!(r#"<body name="b{i}" {}>"#, pose(&body.X_PJ)));
        match body.kind {
            JointKind::Floating => xml.line(r#"<freejoint name="root"/>"#),
            kind => joint(xml, i, body, kind, physics),
        }
        inertial(xml, body, scales.mass)?;
        let friction = friction_of(robot, i).unwrap_or(physics.friction_elsewhere);
        let friction = friction * scales.friction;
        for (k, shape) in robot.collision.shapes().iter().enumerate() {
            if shape.body == i {
                let (form, place) = (geometry(k, &shape.geometry), pose(&shape.X_BG));
                xml.line(&format!(
                    r#"<geom name="s{k}" {form} {place} mass="0" contype="{ROBOT_BIT}" conaffinity="0" friction="{friction} 0 0" rgba="0.35 0.45 0.6 1"/>"#
                ));
            }
        }
    }
    for _ in open {
        xml.line("</body>");
    }
    Ok(())
}

/// The least friction of the patches on a body.
fn friction_of(robot: &Robot, body: usize) -> Option<f64> {
    let own = robot.patches.iter().filter(|patch| patch.body == body);
    own.map(|patch| patch.friction).reduce(f64::min)
}

/// An attribute that bounds a force to ±`effort`; nothing where there is no bound.
fn within(attribute: &str, effort: f64) -> String {
    if effort.is_finite() {
        format!(r#"{attribute}="{} {effort}""#, -effort)
    } else {
        String::new()
    }
}

fn joint(xml: &mut Text, i: usize, body: &Body, kind: JointKind, physics: &Physics) {
    let slides = kind == JointKind::Prismatic;
    let kind = if slides { "slide" } else { "hinge" };
    let effort = within("actuatorfrcrange", body.effort);
    let (axis, lower, upper) = (numbers(body.axis.as_slice()), body.lower, body.upper);
    let Physics {
        armature, damping, ..
    } = physics;
    xml.line(&format!(
        r#"<joint name="j{i}" type="{kind}" axis="{axis}" range="{lower} {upper}" armature="{armature}" damping="{damping}" {effort}/>"#
    ));
}

fn inertial(xml: &mut Text, body: &Body, scale: f64) -> Result<(), Error> {
    if body.mass_kg <= 0.0 || body.mass_kg.is_nan() {
        let cause = format!("body \"{}\" has no mass and moves", body.name);
        return Err(Error::Robot(cause));
    }
    let (com, mass) = (numbers(body.com_B.as_slice()), body.mass_kg * scale);
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let inertia = numbers(&entries.map(|at| body.inertia_B[at] * scale));
    xml.line(&format!(
        r#"<inertial pos="{com}" mass="{mass}" fullinertia="{inertia}"/>"#
    ));
    Ok(())
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

fn self_collision(xml: &mut Text, robot: &Robot) {
    xml.line("<contact>");
    for (a, b) in robot.collision.pairs() {
        xml.line(&format!(r#"<pair geom1="s{a}" geom2="s{b}"/>"#));
    }
    xml.line("</contact>");
}

/// force = kp·(ctrl − q) − kv·q̇, limited to the effort.
fn actuators(xml: &mut Text, robot: &Robot, servo: Servo) {
    xml.line("<actuator>");
    for (i, body) in robot.bodies.iter().enumerate().skip(1) {
        let limit = within("forcerange", body.effort);
        let Servo { kp, kv } = servo;
        xml.line(&format!(
            r#"<general name="a{i}" joint="j{i}" gaintype="fixed" biastype="affine" gainprm="{kp}" biasprm="0 -{kp} -{kv}" {limit}/>"#
        ));
    }
    xml.line("</actuator>");
}

fn pose(X: &Isometry3<f64>) -> String {
    let (p, q) = (numbers(X.translation.vector.as_slice()), &X.rotation);
    let q = numbers(&[q.w, q.i, q.j, q.k]);
    format!(r#"pos="{p}" quat="{q}""#)
}
