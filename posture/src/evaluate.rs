//! The final evaluation: every margin from the variables alone, joints that were held included.

use nalgebra::{Point3, Vector3};
use plan::Margins;

use crate::constraint::Scratch;
use crate::iterate::{Context, Iterate};
use crate::outcome::{ContactState, Posture, Violation};
use crate::rows::{Constraint, Rows, Tag};

/// A force of this part of the weight uses no friction: it is rounding, as to the verifier.
const ROUNDING: f64 = 1e-4;

/// The posture at an iterate, and the worst violation of any constraint.
pub(crate) fn posture(
    ctx: &Context,
    it: &Iterate,
    scratch: &mut Scratch,
    rows: &mut Rows,
    cost: f64,
    iterations: usize,
) -> (Posture, Option<Violation>) {
    rows.clear(false);
    crate::constraint::all(ctx, it, scratch, rows);
    let mut worst = rows.worst().map(|(i, amount)| Violation {
        constraint: ctx.constraint(rows.tag[i]),
        amount,
    });
    let mut consider = |constraint: Constraint, amount: f64| {
        if worst.as_ref().is_none_or(|w| amount > w.amount) {
            worst = Some(Violation { constraint, amount });
        }
    };
    let robot = ctx.robot();

    let mut margins = Margins {
        joint_rad: f64::INFINITY,
        ..Margins::default()
    };
    for i in 0..rows.len() {
        match rows.tag[i] {
            Tag::Closure(_) => margins.closure_m = margins.closure_m.max(rows.violation(i)),
            Tag::Equilibrium | Tag::Balance => {
                margins.equilibrium = margins.equilibrium.max(rows.violation(i));
            }
            _ => {}
        }
    }

    let mut torques = Vec::with_capacity(robot.nj());
    for (b, body) in robot.bodies.iter().enumerate().skip(1) {
        let torque = scratch.torques.holding(ctx, it, b);
        torques.push(torque);
        if body.effort > 0.0 && body.effort.is_finite() {
            let used = torque.abs() / body.effort;
            margins.torque_use = margins.torque_use.max(used);
            consider(Constraint::Torque(b), used / ctx.config.torque_use - 1.0);
        }
        let q = it.q.joints[b - 1];
        margins.joint_rad = margins.joint_rad.min(q - body.lower).min(body.upper - q);
        let (lower, upper) = ctx.joint_bounds(b);
        consider(Constraint::JointLimit(b), (lower - q).max(q - upper));
    }

    let own = scratch.clearances.own.iter().map(|pair| pair.distance);
    margins.self_clearance_m = own.min_by(f64::total_cmp);
    margins.clearance_m = scratch.clearances.clearance_m(ctx.config.clearance_m);

    let mut contacts = Vec::new();
    for (i, (contact, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        let to_W = |points: &[nalgebra::Point2<f64>]| -> Vec<Vector3<f64>> {
            points.iter().map(|p| ctx.patch_point_W(it, i, p)).collect()
        };
        let vertices_W = to_W(&model.vertices);
        if let Some(area) = contact.area() {
            for v in &vertices_W {
                let p = area.X_WF.inverse_transform_point(&Point3::from(*v)).xy();
                let inside = -area.polygon.signed_distance(&p);
                margins.inclusion_m = Some(margins.inclusion_m.map_or(inside, |m| m.min(inside)));
            }
        }
        let mut forces_W = vec![Vector3::zeros(); model.force_points.len()];
        for (force, &column) in forces_W.iter_mut().zip(&ctx.layout.force[i]) {
            *force = ctx.weight * ctx.force_W(it, i, column);
            let local = model.axes.transpose() * *force;
            let (across, rounding) = (local.xy().norm(), ROUNDING * ctx.weight);
            if across > rounding {
                let used = (across - rounding) / (local.z.max(0.0) * contact.friction);
                margins.friction_use = margins.friction_use.max(used);
            }
        }
        let mut X_WC = ctx.X_WC(it, i);
        if model.radius.is_some() {
            X_WC.rotation = contact.X_WC.rotation;
        }
        contacts.push(ContactState {
            X_WC,
            vertices_W,
            force_points_W: to_W(&model.force_points),
            forces_W,
        });
    }
    let posture = Posture {
        q: it.q.clone(),
        contacts,
        com_W: it.kinematics.com_W,
        upright: ctx.config.solver.upright,
        torques,
        margins,
        cost,
        iterations,
    };
    (posture, worst)
}
