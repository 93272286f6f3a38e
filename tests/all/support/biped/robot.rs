//! The biped itself.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Vector3};
use robot_model::collision::{CollisionModel, Hull, Shape, ShapeGeometry};
use robot_model::{Body, ContactPatch, Frame, JointKind, PatchKind, Robot};

use super::{ANKLE, FOOT, FRICTION, HIP_Y, SHIN, SIDES, THIGH, corners};

/// A joint of a leg: name, place in the parent, axis, limits; mass and height of the centre of mass of
/// the link that it moves.
type LegJoint = (&'static str, [f64; 3], [f64; 3], [f64; 2], [f64; 2]);

/// The robot: 30 kg, hips 0.2 m apart, legs of 0.78 m.
pub fn robot() -> Robot {
    let torso = ("", [0.0; 3], [0.0; 3], [0.0; 2], [20.0, 0.2]);
    let mut bodies = vec![body("torso", String::new(), None, torso)];
    let trunk = cuboid(0.08, 0.12, 0.20);
    let mut shapes = vec![shape("torso", 0, [0.0, 0.0, 0.25], trunk)];
    // A head, a pelvis and a keel, inside one another: every kind of shape that there is.
    let keel = [[0.05, 0.0], [-0.05, 0.04], [-0.05, -0.04]]
        .map(|[x, y]| [Point3::new(x, y, 0.1), Point3::new(0.5 * x, 0.5 * y, 0.2)]);
    let keel = Hull::new(&keel.concat()).unwrap();
    #[rustfmt::skip]
    let inside = [
        (0.50, ShapeGeometry::Sphere { radius_m: 0.07 }),
        (0.10, ShapeGeometry::Cylinder { half_length_m: 0.03, radius_m: 0.07 }),
        (0.0, ShapeGeometry::ConvexHull(keel)),
    ];
    for (z, geometry) in inside {
        shapes.push(shape("torso", 0, [0.0, 0.0, z], geometry));
    }
    let mut patches = Vec::new();
    for (side, sign) in SIDES {
        let hip = bodies.len();
        let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        #[rustfmt::skip]
        let joints: [LegJoint; 5] = [
            ("hip_roll", [0.0, sign * HIP_Y, 0.0], x, [-0.6, 0.6], [0.5, 0.0]),
            ("hip_pitch", [0.0; 3], y, [-1.6, 1.0], [1.8, -0.15]),
            ("knee", [0.0, 0.0, -THIGH], y, [0.0, 2.4], [1.5, -0.15]),
            ("ankle_pitch", [0.0, 0.0, -SHIN], y, [-1.3, 1.3], [0.2, 0.0]),
            ("ankle_roll", [0.0; 3], x, [-0.6, 0.6], [1.0, -0.06]),
        ];
        for (k, joint) in joints.into_iter().enumerate() {
            let parent = if k == 0 { 0 } else { bodies.len() - 1 };
            let name = format!("{side}_{}", joint.0);
            bodies.push(body(&format!("{name}_link"), name, Some(parent), joint));
        }
        let link = |k: usize| bodies[hip + k].name.clone();
        for (k, [top, bottom], radius_m) in [(1, [-0.05, -0.30], 0.05), (2, [-0.05, -0.28], 0.04)] {
            let half_length_m = (top - bottom) / 2.0;
            let middle = [0.0, 0.0, (top + bottom) / 2.0];
            #[rustfmt::skip]
            let capsule = ShapeGeometry::Capsule { half_length_m, radius_m };
            shapes.push(shape(&link(k), hip + k, middle, capsule));
        }
        let foot = cuboid(FOOT[0], FOOT[1], 0.02);
        shapes.push(shape(&link(4), hip + 4, [0.0, 0.0, -0.06], foot));
        patches.push(ContactPatch {
            kind: PatchKind::Area,
            name: format!("{side}_foot"),
            link: link(4),
            body: hip + 4,
            X_BC: Isometry3::translation(0.0, 0.0, -ANKLE),
            polygon: corners(FOOT[0], FOOT[1]).map(Point2::from).to_vec(),
            roles: vec!["foot".to_owned()],
            friction: FRICTION,
        });
    }
    let frame = |(body, b): (usize, &Body)| Frame {
        name: b.name.clone(),
        body,
        X_BL: Isometry3::identity(),
    };
    let frames = bodies.iter().enumerate().map(frame).collect();
    let collision = CollisionModel::new(shapes, &bodies);
    let mut robot = Robot::new("biped".to_owned(), bodies, frames, collision).unwrap();
    robot.patches = patches;
    robot
}

fn body(name: &str, joint: String, parent: Option<usize>, moved: LegJoint) -> Body {
    let (_, offset, axis, [lower, upper], [mass_kg, com_z]) = moved;
    let (kind, com_x) = match parent {
        Some(_) => (JointKind::Revolute, 0.0),
        None => (JointKind::Floating, 0.01),
    };
    Body {
        name: name.to_owned(),
        joint,
        parent,
        X_PJ: Isometry3::from(offset),
        kind,
        axis: Vector3::from(axis),
        lower,
        upper,
        effort: 150.0,
        velocity: 5.0,
        mass_kg,
        com_B: Vector3::new(com_x, 0.0, com_z),
        inertia_B: Matrix3::identity() * 0.01 * mass_kg,
    }
}

fn shape(link: &str, body: usize, centre: [f64; 3], geometry: ShapeGeometry) -> Shape {
    Shape {
        link: link.to_owned(),
        body,
        X_BG: Isometry3::from(centre),
        geometry,
    }
}

/// A box, by half its edges.
fn cuboid(x: f64, y: f64, z: f64) -> ShapeGeometry {
    ShapeGeometry::Box {
        half_extents_m: Vector3::new(x, y, z),
    }
}
