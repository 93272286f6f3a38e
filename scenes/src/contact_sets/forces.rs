//! Whether forces exist, by linear programming.
//!
//!   find λ ≥ 0 with  Σ λ_k g_k + m g = 0,  Σ λ_k (p_k − c) × g_k = 0,
//!                    |g(q) − Σ λ_k J_kᵀ g_k| ≤ part · τ_max
//!
//! over the edges g_k of a friction pyramid at every vertex of every patch.

use std::f64::consts::{PI, TAU};

use microlp::{ComparisonOp, Error as LpError, OptimizationDirection, Problem, Variable};
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};

/// Coefficients below this are rounding.
const ROUNDING: f64 = 1e-10;

/// Where forces act, in which axes, on which body.
pub(super) struct Support {
    pub body: usize,
    pub points_W: Vec<Vector3<f64>>,
    /// Two tangents and the outward normal.
    pub axes: Rotation3<f64>,
    /// Part of the weight that each point has to bear at least, upright.
    pub least_load: f64,
}

/// Unit normal part and friction: the edges of a pyramid of `edges` sides.
fn edges(axes: &Rotation3<f64>, mu: f64, edges: usize) -> Vec<Vector3<f64>> {
    (0..edges)
        .map(|k| {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / edges as f64).sin_cos();
            axes * Vector3::new(mu * cos, mu * sin, 1.0)
        })
        .collect()
}

/// Whether forces hold the robot at `q` within `part` of its torque limits. The pyramid is
/// inscribed in the cone, its sides along the axes.
pub(super) fn hold(
    robot: &Robot,
    q: &Configuration,
    supports: &[Support],
    mu: f64,
    part: f64,
) -> bool {
    let kinematics = Kinematics::new(robot, q);
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let mut gravity = DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut gravity);
    // One column a generator: what it exerts on the base and on the joints.
    let mut columns: Vec<DVector<f64>> = Vec::new();
    let mut J = DMatrix::zeros(3, robot.nv());
    for support in supports {
        for p in &support.points_W {
            kinematics.point_jacobian(robot, support.body, p, &mut J);
            gravity -= J.transpose() * Vector3::z() * (weight * support.least_load);
            for g in edges(&support.axes, mu, 4) {
                columns.push(J.transpose() * g * weight);
            }
        }
    }
    let mut problem = Problem::new(OptimizationDirection::Minimize);
    let lambda: Vec<Variable> = columns
        .iter()
        .map(|_| problem.add_var(1.0, (0.0, f64::INFINITY)))
        .collect();
    let row = |i: usize, scale: f64| -> Vec<(Variable, f64)> {
        let terms = lambda.iter().zip(&columns);
        let terms = terms.map(|(&variable, column)| (variable, column[i] / scale));
        terms.filter(|(_, c)| c.abs() > ROUNDING).collect()
    };
    // The rows of the floating base are the equilibrium of the whole robot.
    for i in 0..6 {
        problem.add_constraint(row(i, weight), ComparisonOp::Eq, gravity[i] / weight);
    }
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        if !body.effort.is_finite() {
            continue;
        }
        let limit = part * body.effort;
        let at = gravity[6 + j] / limit;
        let terms = row(6 + j, limit);
        if terms.is_empty() {
            if at.abs() > 1.0 {
                return false;
            }
            continue;
        }
        problem.add_constraint(terms.clone(), ComparisonOp::Le, at + 1.0);
        problem.add_constraint(terms, ComparisonOp::Ge, at - 1.0);
    }
    problem.solve().is_ok()
}

/// How the friction cone is replaced by a pyramid.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Pyramid {
    /// Inside the cone: forces found are forces.
    Inscribed,
    /// Around the cone: where no forces are found, there are none.
    Circumscribed,
}

/// Sides of the pyramid where the centre of mass is free.
const SIDES: usize = 16;

/// Whether forces carry a weight whose centre of mass may be anywhere: `None` where the linear
/// program fails.
///
///   Σ f + m g = 0,   Σ (p × f)_z = 0        (the horizontal moments place the centre of mass)
pub(super) fn carry_somewhere(supports: &[Support], mu: f64, pyramid: Pyramid) -> Option<bool> {
    let mu = match pyramid {
        Pyramid::Inscribed => mu,
        Pyramid::Circumscribed => mu / (PI / SIDES as f64).cos(),
    };
    let mut problem = Problem::new(OptimizationDirection::Minimize);
    let mut rows: [Vec<(Variable, f64)>; 4] = Default::default();
    for support in supports {
        for p in &support.points_W {
            for g in edges(&support.axes, mu, SIDES) {
                let variable = problem.add_var(1.0, (0.0, f64::INFINITY));
                let values = [g.x, g.y, g.z, p.x * g.y - p.y * g.x];
                for (row, value) in rows.iter_mut().zip(values) {
                    if value.abs() > ROUNDING {
                        row.push((variable, value));
                    }
                }
            }
        }
    }
    for (row, wanted) in rows.into_iter().zip([0.0, 0.0, 1.0, 0.0]) {
        if row.is_empty() {
            if wanted != 0.0 {
                return Some(false);
            }
            continue;
        }
        problem.add_constraint(row, ComparisonOp::Eq, wanted);
    }
    match problem.solve() {
        Ok(_) => Some(true),
        Err(LpError::Infeasible) => Some(false),
        Err(_) => None,
    }
}
