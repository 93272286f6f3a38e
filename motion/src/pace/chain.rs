//! Phases that are gone through one after the other without a stop, in time.
//!
//! The parameter s goes from k to k + 1 along phase k. Borders are to be on samples: the last law's time τ
//! runs a little slower on each phase, by quintic steps, so that nothing jumps.

use rayon::prelude::*;

use super::dynamics::between;
use super::smoothing::{Excess, Grid, binding, excess, smooth, worst};
use super::{Lean, OVER, PLACES, Pace, Paced, Place, SUITED, place_s};
use crate::config::Config;
use crate::load_shares::LoadShares;
use crate::problem::MotionContext;
use crate::segment::PhaseTrajectory;
use crate::time_law::TimeLaw;
use crate::time_scaling::quintic;

/// How often the forces are suited to the law that came of the last ones, and the part of the time from
/// which on that is worth going on.
const PASSES: usize = 6;
const WORTH: f64 = 0.98;
/// How often a law is sought until its means over time are within the limits: while forces are still to be
/// suited to it, and in the end.
const ROUGHLY: usize = 3;
const FINALLY: usize = 8;
/// How often the limits are drawn in where samples exceed them, those of the samples taken in as well, and how
/// often all is made slower then, each time farther than what the last samples say: others meet sharp places of
/// the path elsewhere.
const DRAWN_IN: usize = 12;
const STRETCHED: usize = 24;
/// Every so many samples of a law are looked at before all of them are.
const HERE_AND_THERE: usize = 4;
/// Largest difference of velocities from those of the samples, over what the largest acceleration of a joint
/// makes of it between two of them: more is a kink.
const KINK: f64 = 0.08;

/// The least time for a phase from rest to rest, s, by the limits at the ends of so many pieces of its path:
/// before forces suit its law.
pub(crate) fn least_s(context: &MotionContext, phase: &PhaseTrajectory, pieces: usize) -> f64 {
    let mut pace = Pace::new(context, phase);
    let mut places = pace.places(pieces);
    let mut grid = Grid::new(vec![pace.limited(&mut places, &[], Vec::new())]);
    let law = smooth(&mut grid, context.config, ROUGHLY);
    law.map_or(0.0, |(law, over)| law.duration_s() * over)
}

/// The samples of the phases, `dt_s` apart, both ends of each included, and by what shares their contacts
/// bear what is needed; nothing where no law is found.
pub(crate) fn samples(
    context: &MotionContext,
    phases: &[&PhaseTrajectory],
) -> Vec<(LoadShares, Vec<Paced>)> {
    let paces = phases.iter().map(|phase| Pace::new(context, phase));
    let mut paces: Vec<Pace> = paces.collect();
    let (mut grid, leans) = suited(&mut paces, context.config);
    let (mut slower, mut seen, mut settled) = (1.0, Seen::new(), false);
    let mut sharp: Vec<[f64; 2]> = Vec::new();
    for tried in 1..=DRAWN_IN + STRETCHED {
        let Some((law, over)) = smooth(&mut grid, context.config, FINALLY) else {
            break;
        };
        let law = law.slower(over * slower);
        // Only a law that keeps to its limits here and there, and where those before did not, is worth a look at all
        // of it.
        let at_sharp = |s: f64| sharp.iter().any(|[from, to]| (*from..=*to).contains(&s));
        let some = |i: usize, s: f64| i.is_multiple_of(HERE_AND_THERE) || at_sharp(s);
        seen.clear();
        look(&mut paces, &leans, &law, some, &mut seen);
        if worst(used(&seen)) <= 1.0 + OVER || tried == DRAWN_IN + STRETCHED {
            look(&mut paces, &leans, &law, |_, _| true, &mut seen);
        }
        let over = worst(used(&seen));
        settled = over <= 1.0 + OVER;
        if settled {
            break;
        }
        let beyond = || used(&seen).filter(|excess| excess.over > 1.0 + OVER);
        sharp.extend(beyond().map(|excess| excess.span));
        if tried <= DRAWN_IN {
            grid.draw_in(beyond());
        } else {
            slower *= 1.0 + (over - 1.0) * (tried - DRAWN_IN) as f64;
        }
    }
    // What stays outside the limits is no law for several phases, which may stop instead.
    if !settled && phases.len() > 1 {
        return Vec::new();
    }
    let shares = paces.into_iter().map(|pace| pace.shares);
    let samples = seen.into_iter().map(|seen| seen.into_iter().flatten());
    let samples = samples.map(|seen| seen.map(|(paced, _)| paced).collect());
    shares.zip(samples).collect()
}

/// The limits at the places of the phases' paths, and how forces lean that suit the fastest law: sought at some of
/// them.
fn suited(paces: &mut [Pace], config: &Config) -> (Grid, Vec<Vec<Lean>>) {
    let places = paces.par_iter_mut().map(|pace| pace.places(PLACES));
    let mut places: Vec<Vec<Place>> = places.collect();
    let mut leans = vec![Vec::new(); paces.len()];
    let (mut best, mut known) = (leans.clone(), vec![Vec::new(); paces.len()]);
    let mut before = f64::INFINITY;
    for _ in 0..PASSES {
        let rows = paces.par_iter().zip(&mut places).zip(&leans);
        let rows = rows.map(|((pace, places), leans)| {
            let mut memory = Vec::new();
            let some = some(places).enumerate().map(|(i, place)| {
                pace.bear(place, leans.get(i).unwrap_or(&Lean::new()));
                pace.limits(place, &mut memory)
            });
            some.collect()
        });
        let mut grid = Grid::new(rows.collect());
        let Some((law, _)) = smooth(&mut grid, config, ROUGHLY) else {
            break;
        };
        let time = law.duration_s();
        if time >= before {
            break;
        }
        (best, known) = (leans, grid.into_own());
        if time > WORTH * before {
            break;
        }
        before = time;
        let next = paces.par_iter().zip(&mut places).enumerate();
        let next = next.map(|(k, (pace, places))| {
            let some: Vec<&mut Place> = some(places).collect();
            let pieces = some.len() - 1;
            let leans = some.iter().enumerate().map(|(i, place)| {
                let [_, rate, bend] = law.at(law.time_s(k as f64 + place_s(i, pieces)));
                pace.lean(place, rate, bend)
            });
            leans.collect()
        });
        leans = next.collect();
    }
    let rows = paces.par_iter().zip(&mut places).zip(&best).zip(known);
    let rows = rows.map(|(((pace, places), leans), known)| pace.limited(places, leans, known));
    (Grid::new(rows.collect()), best)
}

/// Those of the places of a phase at which forces are suited to a law.
fn some(places: &mut [Place]) -> impl Iterator<Item = &mut Place> {
    let every = (places.len().saturating_sub(1) / SUITED).max(1);
    places.iter_mut().step_by(every)
}

/// The samples of every phase, those that were looked at, and by how much they exceed what is allowed.
type Seen = Vec<Vec<Option<(Paced, Excess)>>>;

fn used(seen: &Seen) -> impl Iterator<Item = &Excess> {
    seen.iter().flatten().flatten().map(|(_, excess)| excess)
}

/// Looks at those samples of every phase by a law that `looked_at` says by their number and their s and that were not
/// seen yet.
fn look(
    paces: &mut [Pace],
    leans: &[Vec<Lean>],
    law: &TimeLaw,
    looked_at: impl Fn(usize, f64) -> bool + Sync,
    seen: &mut Seen,
) {
    let count = paces.len();
    let time = |k: usize| match k {
        0 => 0.0,
        k if k == count => law.duration_s(),
        k => law.time_s(k as f64),
    };
    let borders: Vec<f64> = (0..=count).map(time).collect();
    seen.resize_with(count, Vec::new);
    let all = paces.par_iter_mut().zip(leans).zip(&mut *seen).enumerate();
    all.for_each(|(k, ((pace, leans), seen))| {
        let states = stepped([borders[k], borders[k + 1]], pace.context.config.dt_s);
        seen.resize_with(states.len(), || None);
        for (i, ([tau, slower, change], seen)) in states.into_iter().zip(seen).enumerate() {
            let ([s, rate, bend], span) = law.with_span(tau);
            if seen.is_none() && looked_at(i, s) {
                let state = [s, rate * slower, bend * slower * slower + rate * change];
                *seen = Some(sampled(pace, leans, k, state, span));
            }
        }
    });
    for k in 0..count {
        // The first sample of a phase takes the place of the last one before it.
        let (so_far, next) = seen.split_at_mut(k + 1);
        let samples = &mut so_far[k];
        let last = samples.len() - 1;
        let first_after = next.first().and_then(|next| next[0].as_ref());
        for i in 1..=last {
            let Some((before, _)) = &samples[i - 1] else {
                continue;
            };
            let follow = [samples[i].as_ref(), first_after.filter(|_| i == last)];
            let kinks = follow.into_iter().flatten();
            let kinks = kinks.map(|(now, _)| kink(before, now, paces[k].context.config));
            let kink = kinks.fold(0.0, f64::max);
            if let Some((_, excess)) = &mut samples[i] {
                excess.over = excess.over.max(kink);
            }
        }
    }
}

/// The sample of phase `k` with this s, ṡ and s̈, and by how much it exceeds what is allowed.
fn sampled(
    pace: &mut Pace,
    leans: &[Lean],
    k: usize,
    [s, rate, bend]: [f64; 3],
    span: [f64; 2],
) -> (Paced, Excess) {
    let mut rows = std::mem::take(&mut pace.memory);
    rows.clear();
    let mut at = |pace: &mut Pace, s: f64| {
        let along = (s - k as f64).clamp(0.0, 1.0);
        let place = pace.place(along, &between(leans, along));
        pace.rows(&place, &mut rows);
        (place, excess(&rows, rate, bend))
    };
    let (place, over) = at(pace, s);
    let is_sharp = over > 1.0 + OVER;
    if is_sharp {
        // Others meet beside it what is sharp here.
        let beside = 0.5 * rate * pace.context.config.dt_s;
        at(pace, s - beside);
        at(pace, s + beside);
    } else {
        rows.clear();
    }
    let excess = Excess {
        s,
        span,
        over,
        rows: binding(&mut rows),
    };
    pace.memory = rows;
    (pace.paced(&place, rate, bend), excess)
}

/// How much slower a step has to be for velocities and accelerations that agree with where it leads:
///
///   Δq = h (v + v')/2 − h² (a' − a)/12
fn kink(before: &Paced, now: &Paced, config: &Config) -> f64 {
    let h = config.dt_s;
    let moved = before.q.difference(&now.q) / h;
    let meant = (&before.v + &now.v) / 2.0 - (&now.a - &before.a) * (h / 12.0);
    let most = KINK * config.joint_acceleration_rad_s2 * h;
    ((moved - meant).amax() / most).sqrt()
}

/// Times τ at whole steps from one time to another, with their first and second derivatives: with as many
/// steps as are needed, slower in the middle and as fast as before at both ends.
fn stepped([from, to]: [f64; 2], dt_s: f64) -> Vec<[f64; 3]> {
    let steps = ((to - from) / dt_s - 1e-9).ceil().max(1.0);
    let time = steps * dt_s;
    let longer = time - (to - from);
    let states = (0..=steps as usize).map(|i| {
        let x = i as f64 / steps;
        let (first, second) = (
            30.0 * (x * (1.0 - x)).powi(2),
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        );
        let tau = from + x * time - longer * quintic(x);
        [
            tau,
            1.0 - longer / time * first,
            -longer / (time * time) * second,
        ]
    });
    states.collect()
}
