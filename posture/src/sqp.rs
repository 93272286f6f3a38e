//! Sequential quadratic programming on SE(3) × joints × forces.
//!
//! Each iteration linearises the constraints at the iterate, takes the cost's Gauss–Newton
//! matrix, damped, and solves an ℓ1-elastic QP inside a trust region; a step is kept when it lowers
//!
//!   merit = cost + γ Σ violation
//!
//! by a fair part of what the linear model promised; a step that curvature spoils is corrected to
//! second order. Source: Fletcher's Sℓ1QP [fletcher1987], γ steered by what the model can take off
//! [byrd2008].

mod subproblem;

use crate::evaluate;
use crate::iterate::{Context, Iterate};
use crate::outcome::Outcome;
use crate::qp::ELASTIC_WEIGHT;
use crate::rows::Tag;
use subproblem::Subproblem;

/// Iterations from one seed at most.
const ITERATIONS_MAX: usize = 60;
/// Largest violation of a constraint that still counts as fulfilled: m for lengths, the limit's
/// part for torques, the weight's part for forces; angles count times 0.1 m.
const TOLERANCE: f64 = 1e-5;
/// Part of the promised reduction below which a step is refused.
const ACCEPT_MIN: f64 = 1e-3;
/// Part of the promised reduction below which a step is corrected to second order.
const CORRECT_BELOW: f64 = 0.75;
/// Part of the promised reduction above which the trust region grows, and below which it shrinks.
const GROW_ABOVE: f64 = 0.7;
const SHRINK_BELOW: f64 = 0.2;
/// Trust-region scale at which the search gives up.
const TRUST_MIN: f64 = 1e-5;
/// Promised reduction of the merit that counts as none.
const PROMISE_MIN: f64 = 1e-9;
/// Added to the cost before `optimality` takes its part: a cost near zero needs no more digits.
const COST_FLOOR: f64 = 0.05;
/// Damping of a step, 1/rad² and 1/m², where a tenth of the cost may be left: it stands for the
/// curvature that the Gauss–Newton matrix leaves out, and falls with what may be left.
const DAMPING: f64 = 2.8;
/// Damping once the cost has little to gain and only the constraints are to be met.
const CLOSING_DAMPING: f64 = 20.0;
/// Sum of violations below which only the constraints may be left to meet.
const CLOSING_BELOW: f64 = 0.1;
/// Part of the violation that a step must promise to take off, of a trust region of scale [`TELLING`]
/// or more; where it does not, the price of violations rises, and where that does not help no step does.
const PROMISED_MIN: f64 = 0.1;
/// Scale of the trust region from which a model tells of more than its neighbourhood.
const TELLING: f64 = 0.1;
/// Every so many iterations the violation must have fallen to a part of what it was.
const PATIENCE: usize = 5;
/// Part of the violation that may be left after [`PATIENCE`] iterations; of one that is patient.
const PROGRESS: [f64; 2] = [0.8, 0.95];

/// The SQP with its working memory, for one problem.
pub(crate) struct Sqp<'a> {
    ctx: &'a Context<'a>,
    subproblem: Subproblem<'a>,
    /// Iterations over all seeds.
    pub iterations: usize,
    /// Whether it goes on where progress is slow.
    pub is_patient: bool,
}

impl<'a> Sqp<'a> {
    /// One that counts on from the iterations of another.
    pub fn new(ctx: &'a Context<'a>, iterations: usize) -> Self {
        Self {
            ctx,
            subproblem: Subproblem::new(ctx),
            iterations,
            is_patient: false,
        }
    }

    /// Sum of the violations of what does not depend on the forces: places, clearances, goal.
    pub fn geometric_violation(&mut self, it: &Iterate) -> f64 {
        let forces = |tag| matches!(tag, Tag::Equilibrium | Tag::Balance | Tag::Torque(_));
        let rows = self.subproblem.values_at(it);
        let others = (0..rows.len()).filter(|&i| !forces(rows.tag[i]));
        others.map(|i| rows.violation(i)).sum()
    }

    /// Runs from one seed to where no step helps.
    pub fn descend(&mut self, mut it: Iterate) -> Outcome {
        let optimality = self.ctx.config.solver.optimality;
        let damping = DAMPING * (10.0 * optimality).sqrt();
        let progress = PROGRESS[usize::from(self.is_patient)];
        let (mut trial, mut other) = (it.clone(), it.clone());
        let mut trust: f64 = 1.0;
        let mut cost = self.subproblem.begin(&it);
        let mut checkpoint = f64::INFINITY;
        let mut closing = false;
        for iteration in 0..ITERATIONS_MAX {
            self.iterations += 1;
            let (violation, worst) = self.subproblem.violation();
            if iteration % PATIENCE == PATIENCE - 1 {
                if violation > TOLERANCE && violation > progress * checkpoint {
                    break;
                }
                checkpoint = violation;
            }

            // The step, and by how much the linear model promises to lower the merit.
            self.subproblem
                .damp(if closing { CLOSING_DAMPING } else { damping });
            let mut delta = match self.subproblem.step(&it, trust) {
                Ok(delta) => delta,
                Err(failure) => {
                    tracing::debug!("QP failed: {}", failure.0);
                    trust *= 0.25;
                    if trust < TRUST_MIN {
                        break;
                    }
                    continue;
                }
            };
            let (model_cost, model_violation) = self.subproblem.model(&delta);
            // Where little is promised, cost and damping may be in the way; where they are not, no step helps.
            if worst > TOLERANCE
                && model_violation > (1.0 - PROMISED_MIN) * violation
                && trust >= TELLING
            {
                let Some(cost_now) = self.subproblem.favour_constraints(cost) else {
                    break;
                };
                cost = cost_now;
                continue;
            }
            let promised = ELASTIC_WEIGHT * (violation - model_violation) - model_cost;
            let little = optimality * (COST_FLOOR + cost);
            if worst <= TOLERANCE && promised < little {
                return self.finish(&it, cost);
            }
            if promised < PROMISE_MIN {
                break;
            }
            closing = violation < CLOSING_BELOW && (closing || -model_cost < little);

            // Keep it if the merit falls by a fair part of the promise.
            let merit = cost + ELASTIC_WEIGHT * violation;
            let mut ratio = (merit - self.subproblem.take(&it, &delta, &mut trial)) / promised;
            if ratio < CORRECT_BELOW
                && let Some(corrected) = self.subproblem.corrected(&it, trust, &delta)
            {
                let merit_there = self.subproblem.take(&it, &corrected, &mut other);
                let corrected_ratio = (merit - merit_there) / promised;
                if corrected_ratio > ratio {
                    ratio = corrected_ratio;
                    delta = corrected;
                    std::mem::swap(&mut trial, &mut other);
                }
            }
            if ratio > ACCEPT_MIN {
                std::mem::swap(&mut it, &mut trial);
                cost = self.subproblem.linearise(&it);
                if ratio > GROW_ABOVE {
                    trust = (2.0 * trust).min(1.0);
                } else if ratio < SHRINK_BELOW {
                    trust = 0.5 * self.subproblem.length(&delta).min(trust);
                }
            } else {
                trust = 0.3 * self.subproblem.length(&delta).min(trust);
                if trust < TRUST_MIN {
                    break;
                }
            }
        }
        self.finish(&it, cost)
    }

    /// Evaluates where the search ended. A posture that is not found is no proof that there is
    /// none, whatever stopped the search.
    fn finish(&mut self, it: &Iterate, cost: f64) -> Outcome {
        let (scratch, rows) = self.subproblem.memory();
        let (ctx, iterations) = (self.ctx, self.iterations);
        let (posture, worst) = evaluate::posture(ctx, it, scratch, rows, cost, iterations);
        match worst {
            Some(violation) if violation.amount > TOLERANCE => {
                let nearest = Box::new(posture);
                Outcome::Undecided { violation, nearest }
            }
            _ => Outcome::Feasible(Box::new(posture)),
        }
    }
}
