//! Newton and Euler for every body, by velocities and accelerations of the record.

use nalgebra::{Matrix4, Vector3};
use robot_model::{GRAVITY_M_S2, JointKind};

use crate::posture::{Load, Posture, column, point};

/// What the loads on a moving robot leave to explain.
pub(super) struct Exerted {
    /// Force that the body needs and the loads do not give, N.
    pub force: Vector3<f64>,
    /// Moment about the centre of mass that they do not give, N·m.
    pub moment: Vector3<f64>,
    /// What each joint must exert, N·m or N.
    pub tau: Vec<f64>,
}

/// How one body moves, in W: turning, its change, and the acceleration of its origin.
type Moves = [Vector3<f64>; 3];

/// What is left at velocity `v` and acceleration `a` (`[v_B, ω_B, joint rates…]`, in W) under loads:
///
///   m c̈ + m g ẑ − Σ f,   İω + Σ m (c_b − c) × (c̈_b + g ẑ) − Σ (p − c) × f
pub(super) fn exerted(posture: &Posture, v: &[f64], a: &[f64], loads: &[Load]) -> Exerted {
    let bodies = &posture.robot.bodies;
    let three = |x: &[f64], k: usize| Vector3::new(x[k], x[k + 1], x[k + 2]);
    let mut moves: Vec<Moves> = vec![[three(v, 3), three(a, 3), three(a, 0)]];
    let origin = |i: usize| column(&posture.X_WB[i], 3);
    for (i, body) in bodies.iter().enumerate().skip(1) {
        let parent = body.parent.unwrap_or(0);
        let [omega, alpha, _] = moves[parent];
        let axis = turned(&posture.X_WB[i], &body.axis);
        let (rate, change) = (axis * v[5 + i], axis * a[5 + i]);
        let carried = carried(&moves[parent], &(origin(i) - origin(parent)));
        moves.push(match body.kind {
            JointKind::Prismatic => [omega, alpha, carried + change + omega.cross(&rate) * 2.0],
            _ => [omega + rate, alpha + change + omega.cross(&rate), carried],
        });
    }
    // Force and moment about W's origin that each body needs, less what loads give.
    let needs = bodies.iter().enumerate().map(|(i, body)| {
        let com = posture.coms_W[i];
        let acceleration = carried(&moves[i], &(com - origin(i)));
        let force = (acceleration + Vector3::z() * GRAVITY_M_S2) * body.mass_kg;
        let R = posture.X_WB[i].fixed_view::<3, 3>(0, 0);
        let inertia = R * body.inertia_B * R.transpose();
        let [omega, alpha, _] = moves[i];
        let spin = inertia * alpha + omega.cross(&(inertia * omega));
        (force, spin + com.cross(&force))
    });
    let mut needs: Vec<(Vector3<f64>, Vector3<f64>)> = needs.collect();
    for (body, p, f) in loads {
        needs[*body].0 -= f;
        needs[*body].1 -= p.cross(f);
    }
    let mut tau = vec![0.0; bodies.len() - 1];
    for (i, body) in bodies.iter().enumerate().skip(1).rev() {
        let (force, moment) = needs[i];
        let axis = turned(&posture.X_WB[i], &body.axis);
        tau[i - 1] = match body.kind {
            JointKind::Prismatic => axis.dot(&force),
            _ => axis.dot(&(moment - origin(i).cross(&force))),
        };
        let parent = &mut needs[body.parent.unwrap_or(0)];
        parent.0 += force;
        parent.1 += moment;
    }
    let (force, moment) = needs[0];
    Exerted {
        force,
        moment: moment - posture.com_W.cross(&force),
        tau,
    }
}

/// A direction of a body, in W.
fn turned(X: &Matrix4<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
    point(X, axis) - column(X, 3)
}

/// Acceleration of the point of a body at `r` from its origin.
fn carried([omega, alpha, linear]: &Moves, r: &Vector3<f64>) -> Vector3<f64> {
    linear + alpha.cross(r) + omega.cross(&omega.cross(r))
}
