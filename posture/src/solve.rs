//! A posture problem from its seeds to its outcome.
//!
//! A problem that is proved to have no posture is refused before any is sought. The guess is tried
//! first. Where it fails, or its contacts stay far from their places, other seeds are drawn, brought
//! to their contacts, and sorted by what then still collides or gapes; the SQP takes the best of
//! them, one after the other. A thorough search also seeks the costlier proofs, begins where these end
//! without one, and last goes on from where it came nearest.

use std::cell::OnceCell;

use robot_model::Configuration;

use crate::contact_ik::ContactIk;
use crate::iterate::{Context, Iterate, Pyramid, Relaxed};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::proof::Answer;
use crate::seeding::{seed, shaken};
use crate::sqp::Sqp;
use crate::{Config, Error, proof};

/// Seeds that are drawn for every one that is taken.
const DRAWN: usize = 8;
/// Geometric violation below which a seed is good enough and no more are drawn, m.
const GOOD_ENOUGH: f64 = 0.02;
/// A guess that is left farther from its contacts than this waits its turn among the others, m.
const FAR_M: f64 = 0.05;
/// The attempt before which a proof is sought where that is worth it, and how many are made then at least.
const PROVED_BEFORE: usize = 2;
const THOROUGH: usize = 3;
/// Parts of their ranges within which joints are kept about where an attempt began, one after the other.
const NEARER: [f64; 2] = [0.5, 0.5];
/// Descents that go on from the nearest attempts at most, from how many of these, and after how many in a row that
/// came no nearer there are no more.
const AGAIN: usize = 10;
const NEAREST: usize = 3;
const IN_VAIN: usize = 4;
/// Part of the least violation that comes nearer leaves at most.
const NEARER_BY: f64 = 0.9;

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
    // The first attempt keeps inside coarse friction pyramids, which leaves friction over where there is enough;
    // the others use all of it.
    let fine = OnceCell::new();
    let mut sqp = Sqp::new(&ctx, 0);
    let mut contact_ik = ContactIk::new(&ctx);
    let mut bring = |q: &Configuration| {
        let mut it = ctx.start(q);
        let apart_m = contact_ik.run(&ctx, &mut it);
        (apart_m, it)
    };

    // Seeds that wait, with what their contacts lack.
    let mut pool: Vec<Waiting> = Vec::new();
    let (apart_m, guess) = bring(&seed(&ctx, 0));
    let mut first = None;
    if apart_m < FAR_M {
        first = Some(guess);
    } else {
        pool.push(Waiting::new(apart_m, guess));
    }
    let mut drawn = 1;
    let mut nearest: Vec<Outcome> = Vec::new();
    let thorough = whole && config.solver.thorough;
    let restarts = config.restarts.max(if thorough { THOROUGH } else { 0 });
    for attempt in 0..=restarts {
        if attempt == 1 {
            let fine = fine.get_or_init(|| Context {
                pyramid: Pyramid::fine(),
                ..Context::new(problem, config, ctx.relaxed.clone())
            });
            sqp = Sqp::new(fine, sqp.iterations);
        }
        // A proof; where there is none, its problem has a place to begin, and others with all joints nearer to that.
        if attempt == PROVED_BEFORE && thorough {
            let mut seed = match proof::after_all(&ctx) {
                Some(Answer::Refuted(violation)) => return Ok(Outcome::Infeasible(violation)),
                Some(Answer::Seed(seed)) => Some(seed),
                None => None,
            };
            let mut nearer = NEARER.iter();
            sqp.is_patient = true;
            while let Some(q) = seed {
                // As it is: brought to their contacts first, fewer of these lead to a posture.
                let outcome = sqp.descend(ctx.start(&q));
                if matches!(outcome, Outcome::Feasible(_)) {
                    return Ok(outcome);
                }
                keep(&mut nearest, outcome);
                seed = nearer
                    .next()
                    .and_then(|part| proof::seed_near(&ctx, &q, *part));
            }
        }
        let it = if let Some(guess) = first.take() {
            guess
        } else {
            for _ in 0..DRAWN {
                let (apart_m, it) = bring(&seed(&ctx, drawn));
                drawn += 1;
                let mut seed = Waiting::new(apart_m, it);
                let good = apart_m < GOOD_ENOUGH && seed.evaluated(&mut sqp) < GOOD_ENOUGH;
                pool.push(seed);
                if good {
                    break;
                }
            }
            let Some(it) = best(&mut pool, &mut sqp) else {
                break;
            };
            it
        };
        let outcome = sqp.descend(it);
        if matches!(outcome, Outcome::Feasible(_)) {
            return Ok(outcome);
        }
        keep(&mut nearest, outcome);
    }
    if thorough && let Some(found) = go_on(&ctx, &mut sqp, &mut nearest) {
        return Ok(found);
    }
    nearest.into_iter().next().ok_or(Error::Unsupported)
}

/// Goes on from where attempts came nearest, a few in turns, until that leads no nearer.
fn go_on(ctx: &Context, sqp: &mut Sqp, nearest: &mut Vec<Outcome>) -> Option<Outcome> {
    let mut in_vain = 0;
    for k in 0..AGAIN {
        let turn = k % NEAREST.min(nearest.len().max(1));
        let Some(Outcome::Undecided { nearest: from, .. }) = nearest.get(turn) else {
            break;
        };
        let outcome = sqp.descend(ctx.start(&shaken(ctx, &from.q, k)));
        if matches!(outcome, Outcome::Feasible(_)) {
            return Some(outcome);
        }
        let is_nearer = amount(&outcome) < NEARER_BY * amount(&nearest[0]);
        in_vain = if is_nearer { 0 } else { in_vain + 1 };
        keep(nearest, outcome);
        if in_vain == IN_VAIN {
            break;
        }
    }
    None
}

/// Keeps an outcome, the one with the least violation first.
fn keep(nearest: &mut Vec<Outcome>, outcome: Outcome) {
    let at = nearest.partition_point(|o| amount(o) <= amount(&outcome));
    nearest.insert(at, outcome);
}

fn amount(outcome: &Outcome) -> f64 {
    outcome.violation().map_or(0.0, |v| v.amount)
}

/// A seed that waits for its turn.
struct Waiting {
    it: Iterate,
    /// Its geometric violation; until that is evaluated, what its contacts lack, which is part of it.
    violation: f64,
    is_evaluated: bool,
}

impl Waiting {
    fn new(apart_m: f64, it: Iterate) -> Self {
        Self {
            it,
            violation: apart_m,
            is_evaluated: false,
        }
    }

    fn evaluated(&mut self, sqp: &mut Sqp) -> f64 {
        if !self.is_evaluated {
            self.violation = sqp.geometric_violation(&self.it);
            self.is_evaluated = true;
        }
        self.violation
    }
}

/// Takes the seed with the least violation; collisions are looked at only of seeds whose contacts alone
/// do not lack more already.
fn best(pool: &mut Vec<Waiting>, sqp: &mut Sqp) -> Option<Iterate> {
    loop {
        let least =
            (0..pool.len()).min_by(|&a, &b| pool[a].violation.total_cmp(&pool[b].violation))?;
        if pool[least].is_evaluated {
            return Some(pool.remove(least).it);
        }
        pool[least].evaluated(sqp);
    }
}
