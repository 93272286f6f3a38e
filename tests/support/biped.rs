//! A biped small enough to pose by hand, and a plan for it that steps up one step.
//!
//! Two legs of roll–pitch–pitch–pitch–roll under a torso; feet flat, base upright, so that every
//! posture has a closed form. The plan's postures come from that form and from the kinematics of
//! `robot_model`, its forces from weights on the corners of the feet: nothing of it from the
//! verifier.
#![allow(non_snake_case, dead_code, clippy::unwrap_used)]

use nalgebra::{Isometry3, Matrix3, Point2, UnitQuaternion, Vector3};
use planner::plan::{
    Change, GoalContact, GoalRecord, Margins, PLAN_FORMAT, Plan, Pose, Program, RequiredMargins,
    RobotSummary, SearchSummary, Stance, StanceContact,
};
use robot_model::collision::{CollisionModel, Shape, ShapeGeometry};
use robot_model::{
    Body, Configuration, ContactPatch, Frame, GRAVITY_M_S2, JointKind, Kinematics, PatchKind, Robot,
};
use surfaces::{ConvexPolygon, Surface};

const THIGH: f64 = 0.35;
const SHIN: f64 = 0.35;
const ANKLE: f64 = 0.08;
const HIP_Y: f64 = 0.10;
/// Half length and half width of a foot.
const FOOT: [f64; 2] = [0.10, 0.05];
/// By how much the feet are shrunk where forces act.
const COM_MARGIN: f64 = 0.025;
const FRICTION: f64 = 0.7;

/// Left and right.
const SIDES: [(&str, f64); 2] = [("left", 1.0), ("right", -1.0)];

/// The robot: 30 kg, hips 0.2 m apart, legs of 0.78 m.
pub fn robot() -> Robot {
    let mut bodies = vec![body(
        "torso", "", None, [0.0; 3], [0.0; 3], [0.0; 2], 20.0, 0.2,
    )];
    let mut shapes = vec![shape("torso", 0, [0.0, 0.0, 0.25], [0.08, 0.12, 0.20])];
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
fn level(id: &str, x: [f64; 2], y: [f64; 2], z: f64) -> Surface {
    let centre = Vector3::new((x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0, z);
    let rectangle = corners((x[1] - x[0]) / 2.0, (y[1] - y[0]) / 2.0).to_vec();
    let polygon = ConvexPolygon::try_from(rectangle).unwrap();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.0);
    let mut surface = Surface::new(id, Isometry3::from_parts(centre.into(), turn), polygon);
    surface.inset_m = 0.015;
    surface
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
    let mut stances = Vec::new();
    let mut push = |change, feet: &[Vector3<f64>; 2], listed: Listed, over: [f64; 2], height| {
        stances.push(stance(
            &robot,
            stances.len(),
            change,
            feet,
            listed,
            over,
            height,
        ));
    };
    let add = |side: &str| Change::Add {
        patch: format!("{side}_foot"),
        surface: "step".into(),
    };
    let remove = |side: &str| Change::Remove {
        patch: format!("{side}_foot"),
        surface: "ground".into(),
    };
    let on = |surface, share| Some((surface, share));
    let right = [0.0, -HIP_Y];
    let left = [0.25, HIP_Y];
    push(
        Change::Start,
        &ground,
        [on("ground", 0.5), on("ground", 0.5)],
        [0.0, 0.0],
        0.70,
    );
    push(
        remove("left"),
        &ground,
        [on("ground", 0.0), on("ground", 1.0)],
        right,
        0.70,
    );
    push(
        add("left"),
        &left_up,
        [on("step", 0.0), on("ground", 1.0)],
        right,
        0.70,
    );
    push(
        remove("right"),
        &left_up,
        [on("step", 1.0), on("ground", 0.0)],
        left,
        0.70,
    );
    push(
        add("right"),
        &both_up,
        [on("step", 1.0), on("step", 0.0)],
        left,
        0.75,
    );
    push(
        Change::Goal,
        &both_up,
        [on("step", 0.5), on("step", 0.5)],
        [0.25, 0.0],
        0.78,
    );

    Plan {
        format: PLAN_FORMAT.to_owned(),
        program: Program {
            name: "by hand".to_owned(),
            version: "0".to_owned(),
        },
        scene: "one-step".to_owned(),
        seed: 0,
        config: serde_json::Value::Null,
        inputs: Vec::new(),
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        surfaces: vec![
            level("ground", [-0.5, 0.13], [-0.5, 0.5], 0.0),
            level("step", [0.13, 1.0], [-0.5, 0.5], 0.08),
        ],
        obstacles: Vec::new(),
        thin_body_m: 0.05,
        required: RequiredMargins {
            friction_use: 0.8,
            torque_use: 0.8,
            joint_rad: 0.03,
            clearance_m: 0.01,
            self_clearance_m: 0.005,
            com_m: COM_MARGIN,
        },
        goal: GoalRecord {
            base_position_m: Some([Some(0.25), Some(0.0), None]),
            tolerance_m: 0.05,
            yaw_rad: Some(0.0),
            contacts: vec![GoalContact {
                patch: "right_foot".into(),
                surface: "step".into(),
            }],
        },
        motion: None,
        search: SearchSummary {
            nodes_generated: stances.len(),
            nodes_expanded: stances.len(),
            candidates_solved: stances.len(),
            path_stances: stances.len() - 1,
        },
        stances,
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
            Some(StanceContact {
                patch: patch.name.clone(),
                link: patch.link.clone(),
                surface: surface.to_owned(),
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
