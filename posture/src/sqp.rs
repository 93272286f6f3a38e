//! Sequential quadratic programming on SE(3) × joints × forces.
//!
//! Each iteration linearises the constraints at the iterate, takes the cost's Gauss–Newton
//! matrix, damped, and solves an ℓ1-elastic QP inside a trust region; a step is kept when it lowers
//!
//!   merit = cost + γ Σ violation
//!
//! by a fair part of what the linear model promised; a step that curvature spoils is corrected to
//! second order. Source: Fletcher's Sℓ1QP [fletcher1987].

use nalgebra::DMatrix;

use crate::constraint::{self, Scratch};
use crate::iterate::{Context, Iterate};
use crate::outcome::{Outcome, Posture, Violation};
use crate::qp::{self, Failure, Program, QpEngine};
use crate::rows::{Constraint, Rows, Tag};
use crate::{cost, evaluate};

/// Part of the promised reduction below which a step is refused.
const KEEP: f64 = 1e-3;
/// Part of the promised reduction below which a step is corrected to second order.
const CORRECT: f64 = 0.75;
/// Cost that counts as nothing.
const COST_FLOOR: f64 = 0.05;
/// Damping of a step, 1/rad² and 1/m², where a tenth of the cost may be left: it stands for the
/// curvature that the Gauss–Newton matrix leaves out, and falls with what may be left.
const DAMPING: f64 = 2.8;
/// Damping once the cost has little to gain and only the constraints are to be met.
const CLOSING_DAMPING: f64 = 20.0;
/// Sum of violations below which the constraints may be closed.
const CLOSING: f64 = 0.1;
/// Iterations over which the violation must fall by [`FAIR`], or the search gives up.
const PATIENCE: usize = 5;
/// Part of the violation that may be left after that many iterations.
const FAIR: f64 = 0.8;
/// Trust-region scale at which the search gives up.
const SMALLEST: f64 = 1e-5;

/// What a step starts from and what the linear model promises of it.
struct Promise {
    cost: f64,
    violation: f64,
    promised: f64,
}

/// The SQP with its working memory, for one problem.
pub(crate) struct Sqp<'a> {
    ctx: &'a Context<'a>,
    engine: Box<dyn QpEngine>,
    scratch: Scratch,
    rows: Rows,
    trial_rows: Rows,
    gradient: Vec<f64>,
    hessian: DMatrix<f64>,
    /// Damping that stands in the Hessian.
    damping: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
    iterations: usize,
}

impl<'a> Sqp<'a> {
    pub fn new(ctx: &'a Context<'a>) -> Self {
        let n = ctx.layout.n;
        Self {
            ctx,
            engine: qp::engine(ctx.config.engine),
            scratch: Scratch::default(),
            rows: Rows::new(n),
            trial_rows: Rows::new(n),
            gradient: vec![0.0; n],
            hessian: DMatrix::zeros(n, n),
            damping: 0.0,
            lower: vec![f64::NEG_INFINITY; n],
            upper: vec![f64::INFINITY; n],
            row_lower: Vec::new(),
            row_upper: Vec::new(),
            iterations: 0,
        }
    }

    /// How far an iterate is from what does not depend on the forces.
    pub fn distance(&mut self, it: &Iterate) -> f64 {
        self.trial_rows.clear(false);
        constraint::all(self.ctx, it, &mut self.scratch, &mut self.trial_rows);
        let forces = |tag| matches!(tag, Tag::Equilibrium | Tag::Balance | Tag::Torque(_));
        (0..self.trial_rows.len())
            .filter(|&i| !forces(self.trial_rows.tag[i]))
            .map(|i| self.trial_rows.violation(i))
            .sum()
    }

    /// Runs from one start to where no step helps.
    pub fn descend(&mut self, mut it: Iterate) -> Outcome {
        let config = self.ctx.config;
        let gamma = config.elastic_weight;
        let (mut trial, mut other) = (it.clone(), it.clone());
        let mut trust: f64 = 1.0;
        let mut cost = self.linearise(&it);
        let mut status = "iteration limit";
        let mut checkpoint = f64::INFINITY;
        let mut closing = false;
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
            self.damp(if closing {
                CLOSING_DAMPING
            } else {
                DAMPING * (10.0 * config.optimality).sqrt()
            });
            let mut delta = match self.step(&it, trust) {
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
            let little = config.optimality * (COST_FLOOR + cost);
            if worst <= config.tolerance && promised < little {
                return self.finish(&it, cost, "");
            }
            if promised < 1e-9 {
                status = "stationary";
                break;
            }
            closing = violation < CLOSING && (closing || -model_cost < little);

            // Keep it if the merit falls by a fair part of the promise.
            let promise = Promise {
                cost,
                violation,
                promised,
            };
            let mut ratio = self.attempt(&it, &delta, &promise, &mut trial);
            if ratio < CORRECT
                && let Some(corrected) = self.corrected(&it, trust, &delta)
            {
                let again = self.attempt(&it, &corrected, &promise, &mut other);
                if again > ratio {
                    ratio = again;
                    delta = corrected;
                    std::mem::swap(&mut trial, &mut other);
                }
            }
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

    /// Takes a step; the part of the promised reduction of the merit that it brings.
    fn attempt(
        &mut self,
        it: &Iterate,
        delta: &[f64],
        promise: &Promise,
        trial: &mut Iterate,
    ) -> f64 {
        self.ctx.step(it, delta, 1.0, trial);
        self.trial_rows.clear(false);
        constraint::all(self.ctx, trial, &mut self.scratch, &mut self.trial_rows);
        let fall = promise.cost - cost::value(self.ctx, trial)
            + self.ctx.config.elastic_weight
                * (promise.violation - self.trial_rows.total_violation());
        fall / promise.promised
    }

    /// The step whose linear model has the constraints' values at the end of `delta`; nothing
    /// where rows came or went.
    fn corrected(&mut self, it: &Iterate, trust: f64, delta: &[f64]) -> Option<Vec<f64>> {
        if self.trial_rows.tag != self.rows.tag {
            return None;
        }
        let kept = self.rows.value.clone();
        for i in 0..self.rows.len() {
            let moved: f64 = self.rows.row(i).iter().zip(delta).map(|(a, d)| a * d).sum();
            self.rows.value[i] = self.trial_rows.value[i] - moved;
        }
        let step = self.step(it, trust);
        self.rows.value = kept;
        step.ok()
    }

    /// Linearises constraints and cost at the iterate; the cost's value.
    fn linearise(&mut self, it: &Iterate) -> f64 {
        self.rows.clear(true);
        constraint::all(self.ctx, it, &mut self.scratch, &mut self.rows);
        self.damping = 0.0;
        cost::quadratic(self.ctx, it, &mut self.gradient, &mut self.hessian)
    }

    /// Sets the damping of the configuration's columns.
    fn damp(&mut self, damping: f64) {
        for k in 0..self.ctx.layout.nq {
            self.hessian[(k, k)] += damping - self.damping;
        }
        self.damping = damping;
    }

    /// The QP's step inside joint limits and trust region.
    fn step(&mut self, it: &Iterate, trust: f64) -> Result<Vec<f64>, Failure> {
        let ctx = self.ctx;
        for k in 0..6 {
            let reach = trust
                * if k < 3 {
                    ctx.config.step_max_m
                } else {
                    ctx.config.step_max_rad
                };
            (self.lower[k], self.upper[k]) = (-reach, reach);
        }
        for (i, column) in ctx.layout.column.iter().enumerate().skip(1) {
            let Some(column) = *column else { continue };
            let reach = trust * ctx.config.step_max_rad;
            let (low, high) = ctx.joint_bounds(i);
            let q = it.q.joints[i - 1];
            self.lower[column] = (low - q).max(-reach).min(0.0);
            self.upper[column] = (high - q).min(reach).max(0.0);
        }
        let rows = &self.rows;
        let less = |bounds: &[f64], out: &mut Vec<f64>| {
            out.clear();
            out.extend(bounds.iter().zip(&rows.value).map(|(b, v)| b - v));
        };
        less(&rows.lower, &mut self.row_lower);
        less(&rows.upper, &mut self.row_upper);
        let program = Program {
            hessian: &self.hessian,
            gradient: &self.gradient,
            a: &rows.a,
            names: &rows.tag,
            row_lower: &self.row_lower,
            row_upper: &self.row_upper,
            hard: &rows.hard,
            lower: &self.lower,
            upper: &self.upper,
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
