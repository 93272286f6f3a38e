//! What the points of contacts bear, and what joints exert for it, at rest and beyond.

use std::array::from_fn;

use nalgebra::{Vector3, Vector6};
use posture::Contact;
use robot_model::{JointKind, Kinematics, Robot};

use super::{CONE_INSIDE, UNLOADED_N};
use crate::load_shares::LoadShares;
use crate::problem::MotionContext;

/// Parts of the friction and of the torques that are used at most.
pub(super) fn uses(context: &MotionContext) -> (f64, f64) {
    let (config, posture) = (context.config, context.posture);
    (
        config.friction_use.max(posture.friction_use),
        config.torque_use.max(posture.torque_use),
    )
}

/// Adds to the points' forces what is needed beyond their resultants, by what each bears at rest.
pub(super) fn share<const N: usize>(
    shares: &LoadShares,
    loads: &[f64],
    at: (&[Vector3<f64>], &Vector3<f64>),
    needs: [Vector6<f64>; N],
    forces_W: &mut [[Vector3<f64>; N]],
) {
    let has = shares.resultants(at, forces_W);
    let needed: [_; N] = from_fn(|k| needs[k] - has[k]);
    let shared = shares.shared(&shares.weights(loads), at, needed);
    for (forces, shared) in forces_W.iter_mut().zip(shared) {
        let each = forces.iter_mut().zip(shared);
        each.for_each(|(f, share)| *f += share);
    }
}

/// Takes what the points' forces do from what joints exert if nothing is touched; `joint_W` has the axis and the
/// origin of a body's joint.
pub(super) fn relieve<const N: usize>(
    robot: &Robot,
    closed: &[Contact],
    (shares, points_W): (&LoadShares, &[Vector3<f64>]),
    joint_W: impl Fn(usize) -> [Vector3<f64>; 2],
    forces_W: &[[Vector3<f64>; N]],
    tau: &mut [[f64; N]],
) {
    for (number, closed) in closed.iter().enumerate() {
        let mut wrenches = [(Vector3::zeros(), Vector3::zeros()); N];
        let own = forces_W.iter().zip(points_W).zip(&shares.points);
        for ((forces, p_W), _) in own.filter(|(_, p)| p.contact == number) {
            for ((force, moment), f) in wrenches.iter_mut().zip(forces) {
                *force += f;
                *moment += p_W.cross(f);
            }
        }
        let mut body = robot.patches[closed.patch].body;
        while let Some(parent) = robot.bodies[body].parent {
            let [axis, origin] = joint_W(body);
            for (tau, (force, moment)) in tau[body - 1].iter_mut().zip(&wrenches) {
                *tau -= match robot.bodies[body].kind {
                    JointKind::Prismatic => axis.dot(force),
                    _ => axis.dot(&(moment - origin.cross(force))),
                };
            }
            body = parent;
        }
    }
}

/// Whether contacts and joints can hold a body at rest where it is, by the forces that the postures have there.
pub(crate) fn stands(
    context: &MotionContext,
    closed: &[Contact],
    shares: &LoadShares,
    kinematics: &Kinematics,
    gravity: &[f64],
    forces_W: &[Vec<Vector3<f64>>],
) -> bool {
    let robot = context.robot;
    let mut forces_W: Vec<_> = (shares.at_rest(forces_W).into_iter().map(|f| [f])).collect();
    let loads = shares.loads(forces_W.iter().map(|[f]| *f));
    let weight = Vector6::z() * gravity[2];
    let points_W = shares.points_W(kinematics);
    let at = (&points_W[..], &kinematics.com_W);
    share(shares, &loads, at, [weight], &mut forces_W);
    let mut tau: Vec<[f64; 1]> = gravity[6..].iter().map(|tau| [*tau]).collect();
    let joint_W = |body: usize| [kinematics.axis_W[body], kinematics.origin_W[body]];
    let shares_at = (shares, &points_W[..]);
    relieve(robot, closed, shares_at, joint_W, &forces_W, &mut tau);
    let (friction_use, torque_use) = uses(context);
    let mut torques = tau.iter().zip(robot.joint_bodies());
    let holds = torques.all(|([tau], body)| {
        let bound = body.effort > 0.0 && body.effort.is_finite();
        !bound || tau.abs() <= body.effort * torque_use
    });
    let mut forces = forces_W.iter().zip(&shares.points);
    holds
        && forces.all(|([f], point)| {
            let contact = &closed[point.contact];
            let normal = f.dot(&contact.normal_W());
            let across = (f - contact.normal_W() * normal).norm();
            normal > -UNLOADED_N
                && across
                    <= CONE_INSIDE * contact.friction * friction_use * normal.max(0.0) + UNLOADED_N
        })
}
