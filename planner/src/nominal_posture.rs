//! The nominal posture over the contacts of a stance.
//!
//! Its base is where the feet would have it, and heads as the route does. A robot on three feet
//! or more leans with what it stands on: its up is the mean normal n of the faces under its feet,
//! so that it pitches by the stepping angle and rolls by the slope to its side, and each foot is
//! plumb below its usual place:
//!
//!   R = [n × (y × n)…, n],   z_i = z_i* − (n_x x_i + n_y y_i) / n_z
//!
//! With the usual height measured along the plumb line the body is nearer to a slope than to level
//! ground by the cosine of its angle. Over steps and blocks, whose faces are level, it stays level; a
//! robot on two feet stays upright.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use posture::Contact;
use robot_model::{Configuration, Kinematics, PatchId};

use crate::context::{LEANING_MIN, SearchContext};
use crate::crouch::lowered;

/// Faces nearer to level than this are level, 1 − cos of the angle.
const LEVEL: f64 = 1e-6;
/// Steps that put the feet in their places, and the distance that is left, m.
const STEPS: usize = 8;
const PLACED_M: f64 = 1e-4;
/// Damping of the steps, m/rad.
const DAMPING: f64 = 0.02;

/// The nominal posture with its base where the contacts would have it: the mean of the
/// places less the usual offsets, heading as the route does after `along_m`.
pub(crate) fn nominal_posture(
    context: &SearchContext,
    contacts: &[Contact],
    along_m: f64,
) -> Configuration {
    let request = context.request;
    let mut up = Vector3::zeros();
    let mut places: Vec<(PatchId, Vector3<f64>)> = Vec::new();
    for contact in contacts.iter().filter(|c| context.foot(c.patch).is_some()) {
        up += contact.normal_W();
        places.push((contact.patch, context.place_W(contact)));
    }
    let n = places.len().max(1) as f64;
    let pose = context.route.at(along_m);
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.heading);
    let base = places
        .iter()
        .map(|(patch, p)| p - heading * context.offset(*patch))
        .sum::<Vector3<f64>>()
        / n;
    let level = Isometry3::from_parts(Translation3::from(base), heading);
    let upright = request.reference.clone().with_base(&level);
    let low = (pose.crouch_m > 0.0).then(|| lowered(context, &upright, pose.crouch_m));
    let upright = low.flatten().unwrap_or(upright);
    let leans = places.len() >= LEANING_MIN;
    match up.try_normalize(1e-3) {
        Some(up) if leans && up.z > 0.0 && 1.0 - up.z > LEVEL => leaning(context, upright, &up),
        _ => upright,
    }
}

/// The posture with its up along `up` and its feet plumb below their usual places.
fn leaning(context: &SearchContext, upright: Configuration, up: &Vector3<f64>) -> Configuration {
    let robot = context.request.robot;
    let heading = upright.R_WB;
    let ahead = heading * Vector3::x();
    let Some(ahead) = (ahead - up * up.dot(&ahead)).try_normalize(1e-6) else {
        return upright;
    };
    let axes = Matrix3::from_columns(&[ahead, up.cross(&ahead), *up]);
    let mut q = upright.clone();
    q.R_WB = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let mut kinematics = Kinematics::new(robot, &q);
    for &foot in &context.feet {
        let patch = &robot.patches[foot];
        let usual = heading * context.offset(foot);
        let rise = -(up.x * usual.x + up.y * usual.y) / up.z;
        let touched = q.p_WB + usual + Vector3::z() * rise;
        let wanted = touched + up * patch.point_radius_m().unwrap_or(0.0);
        let mut left = f64::INFINITY;
        for _ in 0..STEPS {
            let p = kinematics.X_WC(patch).translation.vector;
            let off = wanted - p;
            left = off.norm();
            if left < PLACED_M {
                break;
            }
            let step = kinematics.point_step(robot, patch.body, &p, &off, DAMPING);
            let Some(step) = step else { break };
            q.joints += step;
            for (x, body) in q.joints.iter_mut().zip(robot.joint_bodies()) {
                *x = x.clamp(body.lower, body.upper.max(body.lower));
            }
            kinematics.update(robot, &q);
        }
        if left.is_nan() {
            return upright;
        }
    }
    q
}
