//! A posture problem from its seeds to its outcome.
//!
//! A problem that is proved to have no posture is refused before any is sought. The guess is tried
//! first. Where it fails, or its contacts stay far from their places, other seeds are drawn, brought
//! to their contacts, and sorted by what then still collides or gapes; the SQP takes the best of
//! them, one after the other.

use crate::contact_ik::ContactIk;
use crate::iterate::{Context, Iterate, Relaxed};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::seeding::seed;
use crate::sqp::Sqp;
use crate::{Config, Error, proof};

/// Seeds that are drawn for every one that is taken.
const DRAWN: usize = 8;
/// Geometric violation below which a seed is good enough and no more are drawn, m.
const GOOD_ENOUGH: f64 = 0.02;
/// A guess that is left farther from its contacts than this waits its turn among the others, m.
const FAR_M: f64 = 0.05;

/// Finds a posture for a contact set, or the reason why there is none.
///
///   min cost(q, f)  s.t.  closure, inclusion, equilibrium, friction, torques, joint limits,
///                         clearances, goal
///
/// Shapes and units: see [`crate::Posture`].
///
/// # Errors
/// [`Error`] where the problem itself makes no sense; that no posture exists is an [`Outcome`].
///
/// Source: the posture generator of \[brossette2013\] and \[escande2013\], as one SQP; deviation:
/// contact forces are variables beside q, so torque limits hold together with everything else.
pub fn solve(problem: &Problem, config: &Config) -> Result<Outcome, Error> {
    config.validate()?;
    problem.validate()?;
    solve_relaxed(problem, config, Relaxed::default())
}

/// As [`solve`], of a problem that is known to make sense, without the constraints that `relaxed`
/// leaves out.
///
/// # Errors
/// As [`solve`].
pub(crate) fn solve_relaxed(
    problem: &Problem,
    config: &Config,
    relaxed: Relaxed,
) -> Result<Outcome, Error> {
    let whole = relaxed.is_nothing();
    let ctx = Context::new(problem, config, relaxed);
    if whole && let Some(violation) = proof::infeasible(&ctx) {
        return Ok(Outcome::Infeasible(violation));
    }
    let mut sqp = Sqp::new(&ctx);
    let mut contact_ik = ContactIk::new(&ctx);
    let mut draw = |k: usize| {
        let mut it = ctx.start(&seed(&ctx, k));
        let apart_m = contact_ik.run(&ctx, &mut it);
        (apart_m, it)
    };

    // Seeds that wait, with their geometric violation.
    let mut pool: Vec<(f64, Iterate)> = Vec::new();
    let (apart_m, guess) = draw(0);
    let mut first = None;
    if apart_m < FAR_M {
        first = Some(guess);
    } else {
        pool.push((sqp.geometric_violation(&guess), guess));
    }
    let mut drawn = 1;
    let mut nearest: Option<Outcome> = None;
    for _ in 0..=config.restarts {
        let it = if let Some(guess) = first.take() {
            guess
        } else {
            for _ in 0..DRAWN {
                let it = draw(drawn).1;
                drawn += 1;
                let violation = sqp.geometric_violation(&it);
                pool.push((violation, it));
                if violation < GOOD_ENOUGH {
                    break;
                }
            }
            // The best last.
            pool.sort_by(|a, b| b.0.total_cmp(&a.0));
            let Some((_, it)) = pool.pop() else { break };
            it
        };
        let outcome = sqp.descend(it);
        if matches!(outcome, Outcome::Feasible(_)) {
            return Ok(outcome);
        }
        let amount = |o: &Outcome| o.violation().map_or(0.0, |v| v.amount);
        if nearest
            .as_ref()
            .is_none_or(|b| amount(&outcome) < amount(b))
        {
            nearest = Some(outcome);
        }
    }
    nearest.ok_or(Error::Unsupported)
}
