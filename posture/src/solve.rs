//! A posture problem from its starts to its outcome.
//!
//! What no posture can mend is refused before any is sought. The guess is tried first. Where it fails, or its contacts stay far from their places, other
//! starts are drawn, brought to their contacts, and ranked by what then still collides or gapes;
//! the SQP takes the best of them, one after the other.

use crate::approach::Approach;
use crate::iterate::{Context, Dropped, Iterate};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::sqp::Sqp;
use crate::starts::start;
use crate::{Config, Error, proof};

/// Starts that are drawn for every one that is taken.
const DRAWN: usize = 8;
/// A start that is nearer to all that does not depend on forces than this is good enough.
const NEAR: f64 = 0.02;
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
/// Source: the posture generator of [brossette2013] and [escande2013], as one SQP; deviation:
/// contact forces are variables beside q, so torque limits hold together with everything else.
pub fn solve(problem: &Problem, config: &Config) -> Result<Outcome, Error> {
    config.validate()?;
    problem.validate()?;
    solve_without(problem, config, Dropped::default())
}

/// As [`solve`], of a problem that is known to make sense, without the constraints that are
/// dropped.
pub(crate) fn solve_without(
    problem: &Problem,
    config: &Config,
    dropped: Dropped,
) -> Result<Outcome, Error> {
    let whole = !dropped.equilibrium && !dropped.places.contains(&true);
    let mut ctx = Context::new(problem, config)?;
    ctx.dropped = dropped;
    if whole && let Some(violation) = proof::infeasible(&ctx) {
        return Ok(Outcome::Infeasible(violation));
    }
    let mut sqp = Sqp::new(&ctx);
    let mut approach = Approach::new(&ctx);
    let mut draw = |k: usize| {
        let mut it = ctx.start(&start(&ctx, k));
        let apart_m = approach.run(&ctx, &mut it);
        (apart_m, it)
    };

    // Candidates for the next attempt, the best last.
    let mut pool: Vec<(f64, Iterate)> = Vec::new();
    let mut best: Option<Outcome> = None;
    let mut drawn = 1;
    let (apart_m, guess) = draw(0);
    for attempt in 0..=config.restarts {
        let it = if attempt == 0 && apart_m < FAR_M {
            guess.clone()
        } else {
            if attempt == 0 {
                pool.push((sqp.distance(&guess), guess.clone()));
            }
            for _ in 0..DRAWN {
                let it = draw(drawn).1;
                drawn += 1;
                pool.push((sqp.distance(&it), it));
                if pool.last().is_some_and(|(distance, _)| *distance < NEAR) {
                    break;
                }
            }
            pool.sort_by(|a, b| b.0.total_cmp(&a.0));
            let Some((_, it)) = pool.pop() else { break };
            it
        };
        let outcome = sqp.descend(it);
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
