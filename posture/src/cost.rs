//! What makes one posture better than another:
//!
//!   ½ w_q Σ (q_j − q_j*)²  +  ½ w_B ‖log R_WB R*ᵀ‖²  +  ½ w_f Σ ‖φ_i‖²  +  ½ w_μ Σ ‖φ_t‖²/μ²  +  ½ w_p ‖p_C − p*‖²  +  …
//!
//! all of them squares, so that the Gauss–Newton matrix is positive definite and exact but for
//! the curvature of p_C.

use nalgebra::{DMatrix, Point2, Vector3};

use crate::constraint::ANGLE_ARM_M;
use crate::iterate::{Context, Iterate};

/// Weight of the joints' distance from the reference posture, 1/rad².
const WEIGHT_POSTURE: f64 = 0.1;
/// Weight of the contact forces over the robot's weight.
const WEIGHT_FORCES: f64 = 1e-2;
/// Weight of the distance of a free contact from its wanted place, and of a relaxed one from its own, over the
/// robot's size ([`robot_model::Robot::size_m`]): more than the other terms, less than any constraint, whatever
/// joints turn for it.
const WEIGHT_PLACEMENT: f64 = 8.0;
/// Weight of the heading of a free contact, where one is wanted, 1/rad².
const WEIGHT_HEADING: f64 = 1.0;
/// Weight that keeps the base position's block positive definite, 1/m².
const WEIGHT_POSITION: f64 = 1e-3;

/// Least friction coefficient in the cost: a contact without friction would cost without bound.
const MU_MIN: f64 = 0.05;

/// Value, gradient (n) and Gauss–Newton matrix (n × n, lower triangle used) at the iterate.
pub(crate) fn quadratic(
    ctx: &Context,
    it: &Iterate,
    gradient: &mut [f64],
    hessian: &mut DMatrix<f64>,
) -> f64 {
    gradient.fill(0.0);
    hessian.fill(0.0);
    let config = ctx.config;
    let mut value = 0.0;
    for k in 0..3 {
        hessian[(k, k)] += WEIGHT_POSITION;
    }
    let turn = base_turn(ctx, it);
    value += 0.5 * config.weight_base * turn.norm_squared();
    for k in 0..3 {
        gradient[3 + k] += config.weight_base * turn[k];
        hessian[(3 + k, 3 + k)] += config.weight_base.max(WEIGHT_POSITION);
    }
    for (i, column) in ctx.layout.joints() {
        let error = it.q.joints[i - 1] - ctx.problem.reference.joints[i - 1];
        value += 0.5 * WEIGHT_POSTURE * error * error;
        gradient[column] += WEIGHT_POSTURE * error;
        hessian[(column, column)] += WEIGHT_POSTURE;
    }
    for (column, weight) in force_weights(ctx) {
        let f = it.force[column - ctx.layout.nq];
        value += 0.5 * weight * f * f;
        gradient[column] += weight * f;
        hessian[(column, column)] += weight;
    }
    let mut row = vec![0.0; ctx.layout.n];
    squares(ctx, it, |error, weight, body, direction, point| {
        value += 0.5 * weight * error * error;
        row.fill(0.0);
        match point {
            Some(p) => ctx.add_point_gradient(it, body, p, direction, &mut row),
            None => ctx.add_rotation_gradient(it, body, direction, &mut row),
        }
        let used: Vec<usize> = (0..ctx.layout.nq).filter(|&i| row[i] != 0.0).collect();
        for &i in &used {
            gradient[i] += weight * error * row[i];
            for &j in &used {
                if j <= i {
                    hessian[(i, j)] += weight * row[i] * row[j];
                }
            }
        }
    });
    value
}

/// The cost alone.
pub(crate) fn value(ctx: &Context, it: &Iterate) -> f64 {
    let config = ctx.config;
    let mut value = 0.5 * config.weight_base * base_turn(ctx, it).norm_squared();
    for (i, _) in ctx.layout.joints() {
        let error = it.q.joints[i - 1] - ctx.problem.reference.joints[i - 1];
        value += 0.5 * WEIGHT_POSTURE * error * error;
    }
    for (column, weight) in force_weights(ctx) {
        let f = it.force[column - ctx.layout.nq];
        value += 0.5 * weight * f * f;
    }
    squares(ctx, it, |error, weight, _, _, _| {
        value += 0.5 * weight * error * error
    });
    value
}

/// Column and weight of every component of a force: tangential ones cost the friction they use.
fn force_weights<'a>(ctx: &'a Context) -> impl Iterator<Item = (usize, f64)> + 'a {
    let config = ctx.config;
    let contacts = ctx.layout.force.iter().zip(&ctx.contacts);
    contacts.flat_map(move |(columns, model)| {
        let slip = config.weight_friction / model.mu.max(MU_MIN).powi(2);
        let (along, across) = (WEIGHT_FORCES, WEIGHT_FORCES + slip);
        let weights = move |&c: &usize| [(c, across), (c + 1, across), (c + 2, along)];
        columns.iter().flat_map(weights)
    })
}

fn base_turn(ctx: &Context, it: &Iterate) -> Vector3<f64> {
    (it.q.R_WB * ctx.problem.reference.R_WB.inverse()).scaled_axis()
}

/// The squares that couple joints: calls `term(error, weight, body, direction, point)` with the
/// gradient of the error being `direction · d point`, or `direction · rotation` without a point.
fn squares(
    ctx: &Context,
    it: &Iterate,
    mut term: impl FnMut(f64, f64, usize, &Vector3<f64>, Option<&Vector3<f64>>),
) {
    let weight = WEIGHT_PLACEMENT / ctx.problem.robot.size_m.powi(2);
    for (i, (contact, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        let (body, X_WC) = (model.body, ctx.X_WC(it, i));
        let is = ctx.patch_point_W(it, i, &Point2::origin());
        let mut draw = |to: Vector3<f64>| {
            for k in 0..3 {
                let (direction, p) = (Vector3::ith(k, 1.0), &X_WC.translation.vector);
                term(is[k] - to[k], weight, body, &direction, Some(p));
            }
        };
        // A relaxed contact is drawn to its place.
        if ctx.relaxed.place(i) {
            draw(ctx.wanted_W(it, i));
        }
        let Some(area) = contact.area() else {
            continue;
        };
        if let Some(toward) = &area.toward {
            draw(toward.coords);
        }
        if let Some(yaw) = area.yaw_rad
            && model.radius.is_none()
        {
            // The wanted x axis, made tangent to the face; the error is the sine of the angle.
            let n = contact.normal_W();
            let wanted = Vector3::new(yaw.cos(), yaw.sin(), 0.0);
            let across = n.cross(&wanted);
            if across.norm() > ANGLE_ARM_M {
                let across = across.normalize();
                let x_C = X_WC.rotation * Vector3::x();
                let (error, direction) = (across.dot(&x_C), x_C.cross(&across));
                term(error, WEIGHT_HEADING, body, &direction, None);
            }
        }
    }
}
