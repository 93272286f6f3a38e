//! The joints of one sample: their limits, rates, and what the samples beside say of these.

use nalgebra::Vector3;
use plan::Motion;

use crate::extremes::Extremes;
use crate::scene::Scene;
use crate::{Check, TOLERANCES};

/// Joints are inside their limits, and within their speeds and accelerations.
pub(super) fn limits(scene: &Scene, motion: &Motion, i: usize, worst: &mut Extremes) {
    let sample = &motion.samples[i];
    let limits = &motion.limits;
    let bodies = scene.robot.bodies.iter().enumerate().skip(1);
    for (b, body) in bodies {
        let q = sample.q[6 + b];
        let room = (q - body.lower).min(body.upper - q);
        let at = || format!("{} at {:.2} s", body.joint, sample.t_s);
        let kept = body.kept_margin(scene.plan.required.joint_rad);
        worst.add(
            Check::JointLimit,
            room,
            kept - TOLERANCES.motion_joint_rad,
            at,
        );
        if body.velocity.is_finite() && body.velocity > 0.0 {
            let speed = sample.v[5 + b].abs() / body.velocity;
            let bound = limits.joint_speed_use + TOLERANCES.motion_part;
            worst.add(Check::MotionSpeed, speed, bound, at);
        }
        let bound = limits.joint_acceleration_rad_s2 * (1.0 + TOLERANCES.motion_part);
        worst.add(Check::MotionAcceleration, sample.a[5 + b].abs(), bound, at);
    }
    let quaternion: f64 = sample.q[3..7].iter().map(|x| x * x).sum();
    let off = (quaternion.sqrt() - 1.0).abs();
    worst.add(Check::Quaternion, off, TOLERANCES.quaternion, || {
        format!("motion at {:.2} s", sample.t_s)
    });
}

/// Stated velocities are those of the samples:
///
///   Δq = h (v + v')/2 − h² (a' − a)/12      over the time h between two samples
pub(super) fn rates(motion: &Motion, i: usize, worst: &mut Extremes) {
    let (before, now, h) = (&motion.samples[i - 1], &motion.samples[i], motion.dt_s);
    let turn = rotation_vector(&before.q[3..7], &now.q[3..7]);
    let most = TOLERANCES.motion_rate * motion.limits.joint_acceleration_rad_s2 * h;
    for k in 0..now.v.len() {
        let moved = match k {
            0..3 => now.q[k] - before.q[k],
            3..6 => turn[k - 3],
            _ => now.q[k + 1] - before.q[k + 1],
        };
        let bend = h * (now.a[k] - before.a[k]) / 12.0;
        let off = moved / h - 0.5 * (before.v[k] + now.v[k]) + bend;
        worst.add(Check::MotionRate, off.abs(), most, || {
            format!("motion at {:.2} s", now.t_s)
        });
    }
}

/// Samples over which accelerations are summed up: what they do between two of them is not known.
pub(super) const JUMP_STEPS: usize = 4;

/// Stated accelerations are those of the velocities:
///
///   Δv = h Σ (a + a')/2      over some steps of the time h
pub(super) fn jumps(motion: &Motion, i: usize, worst: &mut Extremes) {
    let steps = &motion.samples[i - JUMP_STEPS..=i];
    let most = TOLERANCES.motion_jump * motion.limits.joint_acceleration_rad_s2;
    for k in 0..steps[0].v.len() {
        let means = steps
            .windows(2)
            .map(|pair| 0.5 * (pair[0].a[k] + pair[1].a[k]));
        let change = (steps[JUMP_STEPS].v[k] - steps[0].v[k]) / motion.dt_s;
        let off = (change - means.sum::<f64>()) / JUMP_STEPS as f64;
        worst.add(Check::MotionJump, off.abs(), most, || {
            format!("motion at {:.2} s", motion.samples[i].t_s)
        });
    }
}

/// The rotation from one unit quaternion to the next in W, where it is small: 2 (q' q*), the vector part.
fn rotation_vector(from: &[f64], to: &[f64]) -> Vector3<f64> {
    let part = |q: &[f64]| (Vector3::new(q[0], q[1], q[2]), q[3]);
    let ((a, s), (b, t)) = (part(from), part(to));
    let sign = (a.dot(&b) + s * t).signum();
    (b * s - a * t + a.cross(&b)) * (2.0 * sign)
}
