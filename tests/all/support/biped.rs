//! A biped small enough to pose by hand, and a plan for it that steps up one step.
//!
//! Two legs of roll–pitch–pitch–pitch–roll under a torso; feet flat, base upright, so that every
//! posture has a closed form. The plan's postures come from that form and from the kinematics of
//! `robot_model`, its forces from weights on the corners of the feet: nothing of it from the
//! verifier.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, UnitQuaternion, Vector3};
use plan::{
    Change, Contact, GoalContact, GoalRecord, Margins, Plan, Pose, RequiredMargins, Stance,
};
use robot_model::collision::{CollisionModel, Hull, Shape, ShapeGeometry};
use robot_model::{
    Body, Configuration, ContactPatch, Frame, GRAVITY_M_S2, JointKind, Kinematics, PatchKind, Robot,
};
use surfaces::{ConvexPolygon, Face, Region, Terrain};

use super::record::record;

const THIGH: f64 = 0.35;
const SHIN: f64 = 0.35;
/// Height of the ankle over the sole, m.
pub const ANKLE: f64 = 0.08;
/// Half of the distance between the legs, m.
pub const HIP_Y: f64 = 0.10;
/// Half length and half width of a foot.
pub const FOOT: [f64; 2] = [0.10, 0.05];
/// By how much the feet are shrunk where forces act.
pub const COM_MARGIN: f64 = 0.025;
const FRICTION: f64 = 0.7;

/// Left and right.
const SIDES: [(&str, f64); 2] = [("left", 1.0), ("right", -1.0)];

/// The robot: 30 kg, hips 0.2 m apart, legs of 0.78 m.
pub fn robot() -> Robot {
    let mut bodies = vec![body(
        "torso", "", None, [0.0; 3], [0.0; 3], [0.0; 2], 20.0, 0.2,
    )];
    let mut shapes = vec![shape("torso", 0, [0.0, 0.0, 0.25], [0.08, 0.12, 0.20])];
    // A head, a pelvis and a keel, inside one another: every kind of shape that there is.
    let keel = [[0.05, 0.0], [-0.05, 0.04], [-0.05, -0.04]]
        .map(|[x, y]| [Point3::new(x, y, 0.1), Point3::new(0.5 * x, 0.5 * y, 0.2)]);
    for (z, geometry) in [
        (0.50, ShapeGeometry::Sphere { radius_m: 0.07 }),
        (
            0.10,
            ShapeGeometry::Cylinder {
                half_length_m: 0.03,
                radius_m: 0.07,
            },
        ),
        (
            0.0,
            ShapeGeometry::ConvexHull(Hull::new(&keel.concat()).unwrap()),
        ),
    ] {
        let X_BG = Isometry3::translation(0.0, 0.0, z);
        shapes.push(Shape {
            link: "torso".to_owned(),
            body: 0,
            X_BG,
            geometry,
        });
    }
    let mut patches = Vec::new();
    for (side, sign) in SIDES {
        let hip = bodies.len();
        let x = [1.0, 0.0, 0.0];
        let y = [0.0, 1.0, 0.0];
        // name, offset in the parent, axis, limits, mass, height of the centre of mass
        let joints = [
            (
                "hip_roll",
                [0.0, sign * HIP_Y, 0.0],
                x,
                [-0.6, 0.6],
                0.5,
                0.0,
            ),
            ("hip_pitch", [0.0; 3], y, [-1.6, 1.0], 1.8, -0.15),
            ("knee", [0.0, 0.0, -THIGH], y, [0.0, 2.4], 1.5, -0.15),
            ("ankle_pitch", [0.0, 0.0, -SHIN], y, [-1.3, 1.3], 0.2, 0.0),
            ("ankle_roll", [0.0; 3], x, [-0.6, 0.6], 1.0, -0.06),
        ];
        for (k, (joint, offset, axis, limits, mass, com)) in joints.into_iter().enumerate() {
            let parent = if k == 0 { 0 } else { bodies.len() - 1 };
            let name = format!("{side}_{joint}");
            let link = format!("{name}_link");
            bodies.push(body(
                &link,
                &name,
                Some(parent),
                offset,
                axis,
                limits,
                mass,
                com,
            ));
        }
        let link = |k: usize| bodies[hip + k].name.clone();
        shapes.push(capsule(&link(1), hip + 1, [-0.05, -0.30], 0.05));
        shapes.push(capsule(&link(2), hip + 2, [-0.05, -0.28], 0.04));
        shapes.push(shape(
            &link(4),
            hip + 4,
            [0.0, 0.0, -0.06],
            [FOOT[0], FOOT[1], 0.02],
        ));
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
    let frames = bodies
        .iter()
        .enumerate()
        .map(|(body, b)| Frame {
            name: b.name.clone(),
            body,
            X_BL: Isometry3::identity(),
        })
        .collect();
    let collision = CollisionModel::new(shapes, &bodies);
    let mut robot = Robot::new("biped".to_owned(), bodies, frames, collision).unwrap();
    robot.patches = patches;
    robot
}

#[allow(clippy::too_many_arguments)]
fn body(
    name: &str,
    joint: &str,
    parent: Option<usize>,
    offset: [f64; 3],
    axis: [f64; 3],
    [lower, upper]: [f64; 2],
    mass_kg: f64,
    com_z: f64,
) -> Body {
    let kind = if parent.is_some() {
        JointKind::Revolute
    } else {
        JointKind::Floating
    };
    let com_x = if joint.is_empty() { 0.01 } else { 0.0 };
    Body {
        name: name.to_owned(),
        joint: joint.to_owned(),
        parent,
        X_PJ: Isometry3::translation(offset[0], offset[1], offset[2]),
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

fn shape(link: &str, body: usize, centre: [f64; 3], half: [f64; 3]) -> Shape {
    let geometry = ShapeGeometry::Box {
        half_extents_m: Vector3::from(half),
    };
    let X_BG = Isometry3::translation(centre[0], centre[1], centre[2]);
    Shape {
        link: link.to_owned(),
        body,
        X_BG,
        geometry,
    }
}

fn capsule(link: &str, body: usize, [top, bottom]: [f64; 2], radius_m: f64) -> Shape {
    let geometry = ShapeGeometry::Capsule {
        half_length_m: (top - bottom) / 2.0,
        radius_m,
    };
    let X_BG = Isometry3::translation(0.0, 0.0, (top + bottom) / 2.0);
    Shape {
        link: link.to_owned(),
        body,
        X_BG,
        geometry,
    }
}

/// A rectangle, counter-clockwise.
fn corners(x: f64, y: f64) -> [[f64; 2]; 4] {
    [[-x, -y], [x, -y], [x, y], [-x, y]]
}

/// Joint values that put both soles flat at `feet` (left, right), base upright at `base`.
fn joints(base: &Vector3<f64>, feet: &[Vector3<f64>; 2]) -> Vec<f64> {
    let mut joints = Vec::new();
    for ((_, sign), foot) in SIDES.into_iter().zip(feet) {
        let hip = base + Vector3::new(0.0, sign * HIP_Y, 0.0);
        let r = foot + Vector3::new(0.0, 0.0, ANKLE) - hip;
        let roll = r.y.atan2(-r.z);
        let down = r.y.hypot(r.z);
        let length = r.x.hypot(down);
        let bend = (THIGH * THIGH + SHIN * SHIN - length * length) / (2.0 * THIGH * SHIN);
        let knee = std::f64::consts::PI - bend.clamp(-1.0, 1.0).acos();
        // The thigh leads the line to the ankle by half the knee, both segments being equal.
        let pitch = (-r.x).atan2(down) - knee / 2.0;
        joints.extend([roll, pitch, knee, -(pitch + knee), -roll]);
    }
    joints
}

/// The posture with the feet there and the centre of mass over `over`, the hips at `height`.
fn posture(robot: &Robot, feet: &[Vector3<f64>; 2], over: [f64; 2], height: f64) -> Vec<f64> {
    let mut base = Vector3::new(over[0], over[1], height);
    loop {
        let mut q = vec![base.x, base.y, base.z, 0.0, 0.0, 0.0, 1.0];
        q.extend(joints(&base, feet));
        let com = Kinematics::new(robot, &Configuration::from_q(&q).unwrap()).com_W;
        let error = Vector3::new(over[0] - com.x, over[1] - com.y, 0.0);
        if error.norm() < 1e-13 {
            return q;
        }
        base += error;
    }
}

/// Forces at the corners of a shrunk foot that together act at `at` (in C): bilinear weights.
fn corner_forces(at: [f64; 2], total: f64) -> [f64; 4] {
    let (x, y) = (FOOT[0] - COM_MARGIN, FOOT[1] - COM_MARGIN);
    let (u, v) = ((1.0 + at[0] / x) / 2.0, (1.0 + at[1] / y) / 2.0);
    [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v].map(|weight| weight * total)
}

/// A level surface: its rectangle in W at a height.
fn level(id: &str, x: [f64; 2], y: [f64; 2], z: f64) -> Face {
    let centre = Vector3::new((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0, z);
    let rectangle = corners((x[1] - x[0]) / 2.0, (y[1] - y[0]) / 2.0).to_vec();
    let polygon = ConvexPolygon::try_from(rectangle).unwrap();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.0);
    let mut region = Region::from(&polygon);
    region
        .edges_mut()
        .flatten()
        .for_each(|edge| edge.further_m = 0.015);
    Face::new(id, Isometry3::from_parts(centre.into(), turn), region)
}

/// Which feet are listed: the surface, and the share of the weight they bear (none: unloaded).
type Listed<'a> = [Option<(&'a str, f64)>; 2];

/// A plan for [`robot`]: from level ground with both feet onto a step 0.08 m high.
pub fn plan() -> Plan {
    let robot = robot();
    let ground = [
        Vector3::new(0.0, HIP_Y, 0.0),
        Vector3::new(0.0, -HIP_Y, 0.0),
    ];
    let step = ground.map(|p| p + Vector3::new(0.25, 0.0, 0.08));
    let (left_up, both_up) = ([step[0], ground[1]], step);
    let change = |add: bool, side: &str| {
        let patch = format!("{side}_foot");
        match add {
            true => Change::Add {
                patch,
                face: "step".into(),
            },
            false => Change::Remove {
                patch,
                face: "ground".into(),
            },
        }
    };
    let (low, high) = (
        |share| Some(("ground", share)),
        |share| Some(("step", share)),
    );
    let (right, left) = ([0.0, -HIP_Y], [0.25, HIP_Y]);
    let stances: Vec<Stance> = [
        (
            Change::Start,
            &ground,
            [low(0.5), low(0.5)],
            [0.0, 0.0],
            0.70,
        ),
        (
            change(false, "left"),
            &ground,
            [low(0.0), low(1.0)],
            right,
            0.70,
        ),
        (
            change(true, "left"),
            &left_up,
            [high(0.0), low(1.0)],
            right,
            0.70,
        ),
        (
            change(false, "right"),
            &left_up,
            [high(1.0), low(0.0)],
            left,
            0.70,
        ),
        (
            change(true, "right"),
            &both_up,
            [high(1.0), high(0.0)],
            left,
            0.75,
        ),
        (
            Change::Goal,
            &both_up,
            [high(0.5), high(0.5)],
            [0.25, 0.0],
            0.78,
        ),
    ]
    .into_iter()
    .enumerate()
    .map(|(k, (change, feet, listed, over, height))| {
        stance(&robot, k, change, feet, listed, over, height)
    })
    .collect();

    let faces = vec![
        level("ground", [-0.5, 0.13], [-0.5, 0.5], 0.0),
        level("step", [0.13, 1.0], [-0.5, 0.5], 0.08),
    ];
    let terrain = Terrain {
        faces,
        obstacles: Vec::new(),
    };
    Plan {
        required: RequiredMargins {
            friction_use: 0.8,
            torque_use: 0.8,
            joint_rad: 0.03,
            clearance_m: 0.01,
            self_clearance_m: 0.005,
            com_m: COM_MARGIN,
            edge_sigmas: 2.0,
        },
        goal: GoalRecord {
            base_position_m: Some([Some(0.25), Some(0.0), None]),
            tolerance_m: 0.05,
            yaw_rad: Some(0.0),
            contacts: vec![GoalContact {
                patch: "right_foot".into(),
                face: "step".into(),
            }],
        },
        ..record(&robot, terrain, 0.05, stances)
    }
}

fn stance(
    robot: &Robot,
    index: usize,
    change: Change,
    feet: &[Vector3<f64>; 2],
    listed: Listed,
    over: [f64; 2],
    height: f64,
) -> Stance {
    let q = posture(robot, feet, over, height);
    let kinematics = Kinematics::new(robot, &Configuration::from_q(&q).unwrap());
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let contacts = robot
        .patches
        .iter()
        .zip(feet)
        .zip(listed)
        .filter_map(|((patch, foot), listed)| {
            let (surface, share) = listed?;
            let at = |[x, y]: [f64; 2]| [foot.x + x, foot.y + y, foot.z];
            let points = corners(FOOT[0] - COM_MARGIN, FOOT[1] - COM_MARGIN)
                .map(at)
                .to_vec();
            // Each foot bears its share where the whole would act in the middle of the feet.
            let middle = (feet[0] + feet[1]) / 2.0;
            let centre = if share == 1.0 { *foot } else { middle };
            let offset = [over[0] - centre.x, over[1] - centre.y];
            let forces = corner_forces(offset, share * weight)
                .map(|f| [0.0, 0.0, f])
                .to_vec();
            let loaded = share > 0.0;
            Some(Contact {
                patch: patch.name.clone(),
                link: patch.link.clone(),
                face: surface.into(),
                X_WC: Pose {
                    p: [foot.x, foot.y, foot.z],
                    quat_xyzw: [0.0, 0.0, 0.0, 1.0],
                },
                friction: patch.friction,
                loaded,
                vertices_W: corners(FOOT[0], FOOT[1]).map(at).to_vec(),
                force_points_W: if loaded { points } else { Vec::new() },
                forces_W: if loaded { forces } else { Vec::new() },
            })
        })
        .collect();
    Stance {
        index,
        change,
        contacts,
        q,
        com_W: kinematics.com_W.into(),
        // Nothing is claimed of the margins: the verifier must find them.
        margins: Margins {
            friction_use: 1.0,
            torque_use: 1.0,
            joint_rad: 0.0,
            ..Margins::default()
        },
    }
}
