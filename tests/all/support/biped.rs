//! A biped small enough to pose by hand, and a plan for it that steps up one step.
//!
//! Two legs of roll–pitch–pitch–pitch–roll under a torso; feet flat, base upright, so that every
//! posture has a closed form. The plan's postures come from that form and from the kinematics of
//! `robot_model`, its forces from weights on the corners of the feet: nothing of it from the
//! verifier.

use nalgebra::{DMatrix, DVector, Vector3};
use plan::{
    Change, Contact, GoalContact, GoalRecord, Margins, Plan, Pose, RequiredMargins, Stance,
};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};
use surfaces::{Face, Terrain};

use super::record::record;
use super::walk::face;

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

/// The robot: 30 kg, hips 0.2 m apart, legs of 0.78 m.
pub fn robot() -> Robot {
    of_urdf(include_str!("biped/biped.urdf"))
}

/// The same with a ball around its left ankle.
pub fn with_ankle(radius_m: f64) -> Robot {
    let (link, urdf) = (
        "<link name=\"left_ankle_pitch_link\">",
        include_str!("biped/biped.urdf"),
    );
    let ball =
        format!("<collision><geometry><sphere radius=\"{radius_m}\"/></geometry></collision>");
    of_urdf(&urdf.replace(link, &(link.to_owned() + &ball)))
}

fn of_urdf(urdf: &str) -> Robot {
    robot_model::load_from_strings(
        urdf,
        None,
        Some(include_str!("biped/contacts.toml")),
        "biped",
        &|_| Ok(include_bytes!("biped/keel.obj").to_vec()),
        &robot_model::Config::default(),
    )
    .expect("it loads")
}

/// Left and right.
const SIDES: [(&str, f64); 2] = [("left", 1.0), ("right", -1.0)];

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
    let half = [(x[1] - x[0]) / 2.0, (y[1] - y[0]) / 2.0];
    let mut face = face(id, centre, Vector3::x(), Vector3::y(), half);
    let edges = face.region.edges_mut().flatten();
    edges.for_each(|edge| edge.further_m = 0.015);
    face
}

/// Which feet are listed: the surface, and the share of the weight they bear (none: unloaded).
type Listed = [Option<(&'static str, f64)>; 2];

/// What leads to a stance, where its feet are (left, right), which are listed, where the centre of mass
/// is, and how high the hips are.
type Step = (Change, [Vector3<f64>; 2], Listed, [f64; 2], f64);

/// A plan for [`robot`]: from level ground with both feet onto a step 0.08 m high.
pub fn plan() -> Plan {
    let robot = robot();
    let ground = [HIP_Y, -HIP_Y].map(|y| Vector3::new(0.0, y, 0.0));
    let step = ground.map(|p| p + Vector3::new(0.25, 0.0, 0.08));
    let (left_up, both_up) = ([step[0], ground[1]], step);
    let add = |side: &str| Change::Add {
        patch: format!("{side}_foot"),
        face: "step".into(),
    };
    let remove = |side: &str| Change::Remove {
        patch: format!("{side}_foot"),
        face: "ground".into(),
    };
    let low = |share| Some(("ground", share));
    let high = |share| Some(("step", share));
    let (right, left) = ([0.0, -HIP_Y], [0.25, HIP_Y]);
    #[rustfmt::skip]
    let steps: [Step; 6] = [
        (Change::Start, ground, [low(0.5), low(0.5)], [0.0, 0.0], 0.70),
        (remove("left"), ground, [low(0.0), low(1.0)], right, 0.70),
        (add("left"), left_up, [high(0.0), low(1.0)], right, 0.70),
        (remove("right"), left_up, [high(1.0), low(0.0)], left, 0.70),
        (add("right"), both_up, [high(1.0), high(0.0)], left, 0.75),
        (Change::Goal, both_up, [high(0.5), high(0.5)], [0.25, 0.0], 0.78),
    ];
    let stances = steps.into_iter().enumerate();
    let stances = stances.map(|(k, step)| stance(&robot, k, step)).collect();
    let terrain = Terrain {
        faces: vec![
            level("ground", [-0.5, 0.13], [-0.5, 0.5], 0.0),
            level("step", [0.13, 1.0], [-0.5, 0.5], 0.08),
        ],
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
            joints: None,
        },
        ..record(&robot, terrain, 0.05, stances)
    }
}

fn stance(robot: &Robot, index: usize, step: Step) -> Stance {
    let (change, feet, listed, over, height) = step;
    let q = posture(robot, &feet, over, height);
    let kinematics = Kinematics::new(robot, &Configuration::from_q(&q).unwrap());
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let listed = robot.patches.iter().zip(feet).zip(listed);
    let contacts: Vec<Contact> = listed
        .filter_map(|((patch, foot), listed)| {
            let (surface, share) = listed?;
            let at = |[x, y]: [f64; 2]| [foot.x + x, foot.y + y, foot.z];
            let points = corners(FOOT[0] - COM_MARGIN, FOOT[1] - COM_MARGIN).map(at);
            // Each foot bears its share where the whole would act in the middle of the feet.
            let middle = (feet[0] + feet[1]) / 2.0;
            let centre = if share == 1.0 { foot } else { middle };
            let offset = [over[0] - centre.x, over[1] - centre.y];
            let forces = corner_forces(offset, share * weight).map(|f| [0.0, 0.0, f]);
            let loaded = share > 0.0;
            let bearing = if loaded { 4 } else { 0 };
            Some(Contact {
                patch: patch.name.clone(),
                link: patch.link.clone(),
                face: surface.into(),
                X_WC: Pose {
                    p: [foot.x, foot.y, foot.z],
                    quat_xyzw: [0.0, 0.0, 0.0, 1.0],
                },
                rolls_from: None,
                friction: patch.friction,
                loaded,
                vertices_W: corners(FOOT[0], FOOT[1]).map(at).to_vec(),
                force_points_W: points[..bearing].to_vec(),
                forces_W: forces[..bearing].to_vec(),
            })
        })
        .collect();
    let com_W = kinematics.com_W.into();
    Stance {
        index,
        change,
        margins: margins(robot, &kinematics, &q[7..], &contacts),
        contacts,
        q,
        com_W,
    }
}

/// What joints and forces say; nothing is claimed of distances: the verifier must find them.
fn margins(robot: &Robot, at: &Kinematics, joints: &[f64], contacts: &[Contact]) -> Margins {
    let mut torques = DVector::zeros(robot.nv());
    at.gravity_torques(robot, &mut torques);
    for contact in contacts {
        let body = robot.patches[robot.patch_index(&contact.patch).unwrap()].body;
        for (p, f) in contact.force_points_W.iter().zip(&contact.forces_W) {
            let mut jacobian = DMatrix::zeros(3, robot.nv());
            at.point_jacobian(robot, body, &Vector3::from(*p), &mut jacobian);
            torques -= jacobian.transpose() * Vector3::from(*f);
        }
    }
    let mut margins = Margins {
        joint_rad: f64::INFINITY,
        ..Margins::default()
    };
    let joints = robot.bodies.iter().skip(1).zip(joints);
    for ((body, q), torque) in joints.zip(torques.iter().skip(6)) {
        margins.torque_use = margins.torque_use.max(torque.abs() / body.effort);
        margins.joint_rad = margins.joint_rad.min(q - body.lower).min(body.upper - q);
    }
    margins
}
