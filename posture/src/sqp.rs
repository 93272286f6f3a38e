//! Sequential quadratic programming on SE(3) × joints × forces.
//!
//! Each iteration linearises the constraints at the iterate, takes the cost's Gauss–Newton
//! matrix, and solves an ℓ1-elastic QP inside a trust region; a step is kept when it lowers
//!
//!   merit = cost + γ Σ violation
//!
//! by a fair part of what the linear model promised. Source: Fletcher's Sℓ1QP [fletcher1987].

use nalgebra::DMatrix;

use crate::constraint::{self, Scratch};
use crate::iterate::{Context, Iterate};
use crate::outcome::{Outcome, Posture, Violation};
use crate::problem::Problem;
use crate::qp::{self, Failure, Program, QpEngine};
use crate::rows::{Constraint, Rows};
use crate::starts::starts;
use crate::{Config, Error, cost, evaluate};

/// Part of the promised reduction below which a step is refused.
const KEEP: f64 = 1e-3;
/// Promised reduction, over the cost, at which the search ends.
const OPTIMAL: f64 = 2e-3;
/// Iterations over which the violation must fall by [`FAIR`], or the search gives up.
const PATIENCE: usize = 8;
/// Part of the violation that may be left after that many iterations.
const FAIR: f64 = 0.8;
/// Trust-region scale at which the search gives up.
const SMALLEST: f64 = 1e-5;

/// Finds a posture for a contact set, or the reason why there is none.
///
///   min cost(q, f)  s.t.  closure, inclusion, equilibrium, friction, torques, joint limits,
///                         clearances, goal
///
/// Shapes and units: see [`Posture`].
///
/// # Errors
/// [`Error`] where the problem itself makes no sense; that no posture exists is an [`Outcome`].
///
/// Source: the posture generator of [brossette2013] and [escande2013], as one SQP; deviation:
/// contact forces are variables beside q, so torque limits hold together with everything else.
pub fn solve(problem: &Problem, config: &Config) -> Result<Outcome, Error> {
    config.validate()?;
    problem.validate()?;
    let ctx = Context::new(problem, config)?;
    let mut solver = Solver::new(&ctx);
    let mut best: Option<Outcome> = None;
    for start in starts(&ctx) {
        let outcome = solver.from(ctx.start(&start));
        if matches!(outcome, Outcome::Feasible(_)) {
            return Ok(outcome);
        }
        let amount = |o: &Outcome| o.violation().map_or(0.0, |v| v.amount);
        if best.as_ref().is_none_or(|b| amount(&outcome) < amount(b)) {
            best = Some(outcome);
        }
    }
    best.ok_or(Error::Unsupported)
}

/// Working memory of one problem.
struct Solver<'a> {
    ctx: &'a Context<'a>,
    engine: Box<dyn QpEngine>,
    scratch: Scratch,
    rows: Rows,
    trial_rows: Rows,
    gradient: Vec<f64>,
    hessian: DMatrix<f64>,
    iterations: usize,
}

impl<'a> Solver<'a> {
    fn new(ctx: &'a Context<'a>) -> Self {
        let n = ctx.layout.n;
        Self {
            ctx,
            engine: qp::engine(ctx.config.engine),
            scratch: Scratch::default(),
            rows: Rows::new(n),
            trial_rows: Rows::new(n),
            gradient: vec![0.0; n],
            hessian: DMatrix::zeros(n, n),
            iterations: 0,
        }
    }

    /// Runs the SQP from one start.
    fn from(&mut self, mut it: Iterate) -> Outcome {
        let config = self.ctx.config;
        let gamma = config.elastic_weight;
        let mut trial = it.clone();
        let mut trust: f64 = 1.0;
        let mut cost = self.linearise(&it);
        let mut status = "iteration limit";
        let mut checkpoint = f64::INFINITY;
        for iteration in 0..config.max_iterations {
            self.iterations += 1;
            let violation = self.rows.total_violation();
            if iteration % PATIENCE == PATIENCE - 1 {
                if violation > config.tolerance && violation > FAIR * checkpoint {
                    status = "stalled";
                    break;
                }
                checkpoint = violation;
            }
            let worst = self.rows.worst().map_or(0.0, |(_, amount)| amount);

            // The step, and what the linear model promises of it.
            let delta = match self.step(&it, trust) {
                Ok(delta) => delta,
                Err(failure) => {
                    tracing::debug!("QP failed: {}", failure.0);
                    trust *= 0.25;
                    if trust < SMALLEST {
                        status = "QP failure";
                        break;
                    }
                    continue;
                }
            };
            let (model_cost, model_violation) = self.model(&delta);
            let promised = gamma * (violation - model_violation) - model_cost;
            if worst <= config.tolerance && promised < OPTIMAL * (0.01 + cost) {
                return self.finish(&it, cost, "");
            }
            if promised < 1e-9 {
                status = "stationary";
                break;
            }

            // Keep it if the merit falls by a fair part of the promise.
            self.ctx.step(&it, &delta, 1.0, &mut trial);
            self.trial_rows.clear(false);
            constraint::all(self.ctx, &trial, &mut self.scratch, &mut self.trial_rows);
            let trial_cost = cost::value(self.ctx, &trial);
            let actual =
                cost - trial_cost + gamma * (violation - self.trial_rows.total_violation());
            let ratio = actual / promised;
            if ratio > KEEP {
                std::mem::swap(&mut it, &mut trial);
                cost = self.linearise(&it);
                if ratio > 0.7 {
                    trust = (2.0 * trust).min(1.0);
                } else if ratio < 0.2 {
                    trust = 0.5 * self.used(&delta).min(trust);
                }
            } else {
                trust = 0.3 * self.used(&delta).min(trust);
                if trust < SMALLEST {
                    status = "stalled";
                    break;
                }
            }
        }
        self.finish(&it, cost, status)
    }

    /// Linearises constraints and cost at the iterate; the cost's value.
    fn linearise(&mut self, it: &Iterate) -> f64 {
        self.rows.clear(true);
        constraint::all(self.ctx, it, &mut self.scratch, &mut self.rows);
        cost::quadratic(self.ctx, it, &mut self.gradient, &mut self.hessian)
    }

    /// The QP's step inside joint limits and trust region.
    fn step(&mut self, it: &Iterate, trust: f64) -> Result<Vec<f64>, Failure> {
        let ctx = self.ctx;
        let n = ctx.layout.n;
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        for k in 0..6 {
            let reach = trust
                * if k < 3 {
                    ctx.config.step_max_m
                } else {
                    ctx.config.step_max_rad
                };
            (lower[k], upper[k]) = (-reach, reach);
        }
        for (i, column) in ctx.layout.column.iter().enumerate().skip(1) {
            let Some(column) = *column else { continue };
            let reach = trust * ctx.config.step_max_rad;
            let (low, high) = ctx.joint_bounds(i);
            let q = it.q.joints[i - 1];
            lower[column] = (low - q).max(-reach).min(0.0);
            upper[column] = (high - q).min(reach).max(0.0);
        }
        let rows = &self.rows;
        let row_lower: Vec<f64> = rows
            .lower
            .iter()
            .zip(&rows.value)
            .map(|(l, v)| l - v)
            .collect();
        let row_upper: Vec<f64> = rows
            .upper
            .iter()
            .zip(&rows.value)
            .map(|(u, v)| u - v)
            .collect();
        let program = Program {
            hessian: &self.hessian,
            gradient: &self.gradient,
            a: &rows.a,
            row_lower: &row_lower,
            row_upper: &row_upper,
            hard: &rows.hard,
            lower: &lower,
            upper: &upper,
            elastic_weight: ctx.config.elastic_weight,
        };
        self.engine.solve(&program).or_else(|failure| {
            tracing::debug!("{}; trying the interior point", failure.0);
            qp::InteriorPoint.solve(&program)
        })
    }

    /// Change of the cost and sum of the violations that the linear model gives a step.
    fn model(&self, delta: &[f64]) -> (f64, f64) {
        let n = self.ctx.layout.n;
        let mut change = 0.0;
        for i in 0..n {
            change += self.gradient[i] * delta[i] + 0.5 * self.hessian[(i, i)] * delta[i].powi(2);
            for j in 0..i {
                change += self.hessian[(i, j)] * delta[i] * delta[j];
            }
        }
        let mut violation = 0.0;
        for i in 0..self.rows.len() {
            let moved: f64 = self.rows.row(i).iter().zip(delta).map(|(a, d)| a * d).sum();
            let value = self.rows.value[i] + moved;
            violation += (self.rows.lower[i] - value)
                .max(value - self.rows.upper[i])
                .max(0.0);
        }
        (change, violation)
    }

    /// Part of the largest allowed step that a step uses.
    fn used(&self, delta: &[f64]) -> f64 {
        let config = self.ctx.config;
        delta[..self.ctx.layout.nq]
            .iter()
            .enumerate()
            .map(|(k, d)| {
                d.abs()
                    / if k < 3 {
                        config.step_max_m
                    } else {
                        config.step_max_rad
                    }
            })
            .fold(0.0, f64::max)
    }

    /// Evaluates where the search ended.
    fn finish(&mut self, it: &Iterate, cost: f64, status: &str) -> Outcome {
        let (posture, worst): (Posture, Option<Violation>) = evaluate::posture(
            self.ctx,
            it,
            &mut self.scratch,
            &mut self.trial_rows,
            cost,
            self.iterations,
        );
        let worst = worst.unwrap_or(Violation {
            constraint: Constraint::Equilibrium,
            amount: 0.0,
        });
        if worst.amount <= self.ctx.config.tolerance {
            return Outcome::Feasible(Box::new(posture));
        }
        if status == "stationary" || status == "stalled" {
            return Outcome::Infeasible(worst);
        }
        Outcome::Undecided {
            status: status.to_owned(),
            violation: worst,
        }
    }
}
