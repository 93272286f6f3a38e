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

use nalgebra::{Isometry3, Point3};
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
    xml.line("<mujoco model=\"scandent\">");
    xml.line("<compiler angle=\"radian\" inertiafromgeom=\"false\" autolimits=\"true\"/>");
    xml.line(&format!(
        "<option timestep=\"{}\" gravity=\"0 0 {}\" integrator=\"implicitfast\" cone=\"elliptic\" \
         impratio=\"{}\"><flag multiccd=\"enable\"/></option>",
        physics.dt_s, -GRAVITY_M_S2, IMPRATIO
    ));
    xml.line("<visual><global offwidth=\"1920\" offheight=\"1080\"/><headlight ambient=\"0.35 0.35 0.35\" diffuse=\"0.5 0.5 0.5\"/></visual>");
    xml.line(&format!(
        "<default><geom condim=\"3\" solref=\"{t} {d}\"/><pair condim=\"3\" solref=\"{t} {d}\"/></default>",
        t = CONTACT_TIME_S,
        d = CONTACT_DAMPING
    ));
    assets(&mut xml, robot, world);
    xml.line("<worldbody>");
    xml.line(
        "<light pos=\"0 -3 6\" dir=\"0 0.4 -1\" directional=\"true\" diffuse=\"0.5 0.5 0.5\"/>",
    );
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
    xml.line(
        "<texture type=\"skybox\" builtin=\"gradient\" rgb1=\"0.72 0.8 0.9\" rgb2=\"1 1 1\" \
         width=\"64\" height=\"384\"/>",
    );
    let mut mesh = |name: String, points: &[Point3<f64>]| {
        let mut vertices = String::new();
        for p in points {
            let _ = write!(vertices, "{} {} {} ", p.x, p.y, p.z);
        }
        xml.line(&format!(
            "<mesh name=\"{name}\" inertia=\"convex\" vertex=\"{}\"/>",
            vertices.trim_end()
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
    let bits = format!("contype=\"0\" conaffinity=\"{ROBOT_BIT}\" friction=\"0 0 0\"");
    let grey = 0.55 + 0.08 * (k % 4) as f64;
    let colour = format!("rgba=\"{grey} {grey} {} 1\"", grey * 0.9);
    let shape = match &body.shape {
        WorldShape::Box { X_WO, half_m: h } => format!(
            "type=\"box\" size=\"{} {} {}\" {}",
            h.x,
            h.y,
            h.z,
            pose(X_WO)
        ),
        WorldShape::Hull(_) => format!("type=\"mesh\" mesh=\"w{k}\""),
    };
    xml.line(&format!("<geom name=\"w{k}\" {shape} {bits} {colour}/>"));
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
        xml.line(&format!("<body name=\"b{i}\" {}>", pose(&body.X_PJ)));
        match body.kind {
            JointKind::Floating => xml.line("<freejoint name=\"root\"/>"),
            kind => joint(xml, i, body, kind, physics),
        }
        inertial(xml, body, scales.mass)?;
        let friction = friction_of(robot, i).unwrap_or(physics.friction_elsewhere);
        for (k, shape) in robot.collision.shapes().iter().enumerate() {
            if shape.body == i {
                xml.line(&format!(
                    "<geom name=\"s{k}\" {} {} mass=\"0\" contype=\"{ROBOT_BIT}\" \
                     conaffinity=\"0\" friction=\"{} 0 0\" rgba=\"0.35 0.45 0.6 1\"/>",
                    geometry(k, &shape.geometry),
                    pose(&shape.X_BG),
                    friction * scales.friction
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
    robot
        .patches
        .iter()
        .filter(|patch| patch.body == body)
        .map(|patch| patch.friction)
        .reduce(f64::min)
}

fn joint(xml: &mut Text, i: usize, body: &Body, kind: JointKind, physics: &Physics) {
    let slides = kind == JointKind::Prismatic;
    let effort = if body.effort.is_finite() {
        format!("actuatorfrcrange=\"{} {}\"", -body.effort, body.effort)
    } else {
        String::new()
    };
    xml.line(&format!(
        "<joint name=\"j{i}\" type=\"{}\" axis=\"{} {} {}\" range=\"{} {}\" armature=\"{}\" \
         damping=\"{}\" {effort}/>",
        if slides { "slide" } else { "hinge" },
        body.axis.x,
        body.axis.y,
        body.axis.z,
        body.lower,
        body.upper,
        physics.armature,
        physics.damping,
    ));
}

fn inertial(xml: &mut Text, body: &Body, scale: f64) -> Result<(), Error> {
    if body.mass_kg <= 0.0 || body.mass_kg.is_nan() {
        return Err(Error::Robot(format!(
            "body \"{}\" has no mass and moves",
            body.name
        )));
    }
    let (c, m) = (body.com_B, body.inertia_B * scale);
    xml.line(&format!(
        "<inertial pos=\"{} {} {}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>",
        c.x,
        c.y,
        c.z,
        body.mass_kg * scale,
        m[(0, 0)],
        m[(1, 1)],
        m[(2, 2)],
        m[(0, 1)],
        m[(0, 2)],
        m[(1, 2)]
    ));
    Ok(())
}

fn geometry(k: usize, geometry: &ShapeGeometry) -> String {
    match geometry {
        ShapeGeometry::Sphere { radius_m } => format!("type=\"sphere\" size=\"{radius_m}\""),
        ShapeGeometry::Capsule {
            half_length_m,
            radius_m,
        } => format!("type=\"capsule\" size=\"{radius_m} {half_length_m}\""),
        ShapeGeometry::Cylinder {
            half_length_m,
            radius_m,
        } => format!("type=\"cylinder\" size=\"{radius_m} {half_length_m}\""),
        ShapeGeometry::Box { half_extents_m: h } => {
            format!("type=\"box\" size=\"{} {} {}\"", h.x, h.y, h.z)
        }
        ShapeGeometry::ConvexHull(_) => format!("type=\"mesh\" mesh=\"s{k}\""),
    }
}

fn self_collision(xml: &mut Text, robot: &Robot) {
    xml.line("<contact>");
    for (a, b) in robot.collision.pairs() {
        xml.line(&format!("<pair geom1=\"s{a}\" geom2=\"s{b}\"/>"));
    }
    xml.line("</contact>");
}

/// force = kp·(ctrl − q) − kv·q̇, limited to the effort.
fn actuators(xml: &mut Text, robot: &Robot, servo: Servo) {
    xml.line("<actuator>");
    for (i, body) in robot.bodies.iter().enumerate().skip(1) {
        let limit = if body.effort.is_finite() {
            format!("forcerange=\"{} {}\"", -body.effort, body.effort)
        } else {
            String::new()
        };
        xml.line(&format!(
            "<general name=\"a{i}\" joint=\"j{i}\" gaintype=\"fixed\" biastype=\"affine\" \
             gainprm=\"{kp}\" biasprm=\"0 {} {}\" {limit}/>",
            -servo.kp,
            -servo.kv,
            kp = servo.kp
        ));
    }
    xml.line("</actuator>");
}

fn pose(X: &Isometry3<f64>) -> String {
    let (p, q) = (&X.translation.vector, &X.rotation);
    format!(
        "pos=\"{} {} {}\" quat=\"{} {} {} {}\"",
        p.x, p.y, p.z, q.w, q.i, q.j, q.k
    )
}
