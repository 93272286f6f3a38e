//! A trunk on two sliding legs, with every kind of collision shape.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use robot_model::collision::{CollisionModel, Hull, Shape, ShapeGeometry};
use robot_model::{Body, Frame, JointKind, Robot};

/// The feet's distance below the base when the legs are drawn in, m.
pub const LEG_M: f64 = 0.3;
/// Half of the distance between the legs, m.
pub const HIP_M: f64 = 0.12;
/// The soles' corners, m.
pub const FOOT_M: [[f64; 2]; 4] = [[-0.08, -0.04], [0.08, -0.04], [0.08, 0.04], [-0.08, 0.04]];

/// A trunk on two legs, each sliding forward, then down.
pub fn robot() -> Robot {
    let mut bodies = vec![body(
        "trunk",
        None,
        JointKind::Floating,
        Vector3::z(),
        Vector3::zeros(),
        20.0,
    )];
    for (side, y) in [("left", HIP_M), ("right", -HIP_M)] {
        let hip = Vector3::new(0.0, y, 0.0);
        bodies.push(body(
            &format!("{side}_hip"),
            Some(0),
            JointKind::Prismatic,
            Vector3::x(),
            hip,
            1.0,
        ));
        let parent = Some(bodies.len() - 1);
        bodies.push(body(
            &format!("{side}_leg"),
            parent,
            JointKind::Prismatic,
            -Vector3::z(),
            Vector3::zeros(),
            2.0,
        ));
    }
    let frames = bodies.iter().enumerate().map(|(body, b)| Frame {
        name: b.name.clone(),
        body,
        X_BL: Isometry3::identity(),
    });
    let collision = CollisionModel::new(shapes(), &bodies);
    Robot::new(
        "walker".to_owned(),
        bodies.clone(),
        frames.collect(),
        collision,
    )
    .expect("a tree")
}

fn body(
    name: &str,
    parent: Option<usize>,
    kind: JointKind,
    axis: Vector3<f64>,
    at: Vector3<f64>,
    mass_kg: f64,
) -> Body {
    Body {
        name: name.to_owned(),
        joint: if parent.is_some() {
            format!("{name}_joint")
        } else {
            String::new()
        },
        parent,
        X_PJ: Isometry3::translation(at.x, at.y, at.z),
        kind,
        axis,
        lower: -0.4,
        upper: 0.4,
        effort: 400.0,
        velocity: 1.0,
        mass_kg,
        com_B: Vector3::zeros(),
        inertia_B: Matrix3::identity() * 0.1,
    }
}

fn shapes() -> Vec<Shape> {
    let shape = |body: usize, at: [f64; 3], geometry: ShapeGeometry| Shape {
        link: format!("body {body}"),
        body,
        X_BG: Isometry3::translation(at[0], at[1], at[2]),
        geometry,
    };
    let block = |x, y, z| ShapeGeometry::Box {
        half_extents_m: Vector3::new(x, y, z),
    };
    let mut shapes = vec![
        shape(0, [0.0, 0.0, 0.2], block(0.1, 0.14, 0.16)),
        shape(
            0,
            [0.0, 0.0, 0.46],
            ShapeGeometry::Sphere { radius_m: 0.09 },
        ),
        shape(
            0,
            [0.0, 0.0, 0.0],
            ShapeGeometry::Cylinder {
                half_length_m: 0.04,
                radius_m: 0.1,
            },
        ),
    ];
    let sole: Vec<_> = FOOT_M
        .iter()
        .flat_map(|&[x, y]| {
            [
                Point3::new(x, y, -LEG_M),
                Point3::new(0.7 * x, 0.7 * y, -LEG_M + 0.05),
            ]
        })
        .collect();
    for leg in [2, 4] {
        let shin = ShapeGeometry::Capsule {
            half_length_m: 0.09,
            radius_m: 0.035,
        };
        shapes.push(shape(leg, [0.0, 0.0, -0.14], shin));
        shapes.push(shape(
            leg,
            [0.0; 3],
            ShapeGeometry::ConvexHull(Hull::new(&sole).expect("a hull")),
        ));
    }
    shapes
}
