//! Phases that are gone through one after the other without a stop, in time.
//!
//! The parameter s goes from k to k + 1 along phase k. Borders are to be on samples: the last law's time τ
//! runs a little slower on each phase, by quintic steps, so that nothing jumps.

use rayon::prelude::*;

use super::dynamics::between;
use super::smoothing::{Excess, Grid, binding, excess, smooth, worst};
use super::{Lean, OVER, Pace, Paced, Place};
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
/// Largest difference of velocities from those of the samples, over what the largest acceleration of a joint
/// makes of it between two of them: more is a kink.
const KINK: f64 = 0.08;

/// The least time for a phase from rest to rest, s, by the limits at every so many of its samples: before forces
/// suit its law.
pub(crate) fn least_s(context: &MotionContext, phase: &PhaseTrajectory, every: usize) -> f64 {
    let mut pace = Pace::new(context, phase);
    let places = pace.places(every);
    let law = smooth(
        &mut Grid::new(vec![pace.limits(&places)]),
        context.config,
        ROUGHLY,
    );
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
    let Some((mut grid, leans)) = suited(&mut paces, context.config) else {
        return Vec::new();
    };
    let (mut slower, mut samples, mut settled) = (1.0, Vec::new(), false);
    let mut sharp: Vec<[f64; 2]> = Vec::new();
    for tried in 1..=DRAWN_IN + STRETCHED {
        let Some((law, over)) = smooth(&mut grid, context.config, FINALLY) else {
            break;
        };
        let law = law.slower(over * slower);
        // Only a law that keeps to its limits where those before did not is worth a look at all of it.
        let at_sharp = |s: f64| sharp.iter().any(|[from, to]| (*from..=*to).contains(&s));
        let (_, mut used) = sampled(&mut paces, &leans, &law, context.config, at_sharp);
        if worst(&used) <= 1.0 + OVER || tried == DRAWN_IN + STRETCHED {
            (samples, used) = sampled(&mut paces, &leans, &law, context.config, |_| true);
        }
        let over = worst(&used);
        settled = over <= 1.0 + OVER;
        if settled {
            break;
        }
        let beyond = used.iter().filter(|excess| excess.over > 1.0 + OVER);
        sharp.extend(beyond.map(|excess| excess.span));
        if tried <= DRAWN_IN {
            grid.draw_in(&used);
        } else {
            slower *= 1.0 + (over - 1.0) * (tried - DRAWN_IN) as f64;
        }
    }
    // What stays outside the limits is no law for several phases, which may stop instead.
    if !settled && phases.len() > 1 {
        return Vec::new();
    }
    let shares = paces.into_iter().map(|pace| pace.shares);
    shares.zip(samples).collect()
}

/// The limits at every sample of the phases' paths, between which the second derivatives of these are linear,
/// and how forces lean that suit the fastest law.
fn suited(paces: &mut [Pace], config: &Config) -> Option<(Grid, Vec<Vec<Lean>>)> {
    let places = paces.par_iter_mut().map(|pace| pace.places(1));
    let mut places: Vec<Vec<Place>> = places.collect();
    let mut best: Option<(f64, Grid, Vec<Vec<Lean>>)> = None;
    let mut leans: Vec<Vec<Lean>> = vec![Vec::new(); paces.len()];
    for _ in 0..PASSES {
        let rows = paces.par_iter().zip(&places);
        let rows = rows.map(|(pace, places)| pace.limits(places));
        // At rest every row has room, so there is one.
        let mut grid = Grid::new(rows.collect());
        let Some((law, _)) = smooth(&mut grid, config, ROUGHLY) else {
            break;
        };
        let time = law.duration_s();
        let before = best.as_ref().map_or(f64::INFINITY, |best| best.0);
        if time >= before {
            break;
        }
        best = Some((time, grid, leans));
        if time > WORTH * before {
            break;
        }
        let next = paces.par_iter().zip(&mut places).enumerate();
        let next = next.map(|(k, (pace, places))| {
            let pieces = (places.len() - 1) as f64;
            let lean = places.iter_mut().enumerate().map(|(i, place)| {
                let [_, rate, bend] = law.at(law.time_s(k as f64 + i as f64 / pieces));
                let lean = pace.lean(place, rate, bend);
                pace.bear(place, &lean);
                lean
            });
            lean.collect()
        });
        leans = next.collect();
    }
    best.map(|(_, grid, leans)| (grid, leans))
}

/// The samples of every phase by a law, where its path is to be looked at, and by how much each of them exceeds
/// what is allowed.
fn sampled(
    paces: &mut [Pace],
    leans: &[Vec<Lean>],
    law: &TimeLaw,
    config: &Config,
    looked_at: impl Fn(f64) -> bool + Sync,
) -> (Vec<Vec<Paced>>, Vec<Excess>) {
    let count = paces.len();
    let time = |k: usize| match k {
        0 => 0.0,
        k if k == count => law.duration_s(),
        k => law.time_s(k as f64),
    };
    let borders: Vec<f64> = (0..=count).map(time).collect();
    let all = paces.par_iter_mut().zip(leans).enumerate();
    let all = all.map(|(k, (pace, leans))| {
        let states = stepped([borders[k], borders[k + 1]], config.dt_s);
        let mut rows = Vec::new();
        let samples = states.into_iter().map(|[tau, slower, change]| {
            let ([s, rate, bend], span) = law.with_span(tau);
            if !looked_at(s) {
                return None;
            }
            let (rate, bend) = (rate * slower, bend * slower * slower + rate * change);
            let along = (s - k as f64).clamp(0.0, 1.0);
            let place = pace.place(along, &between(leans, along));
            pace.rows(&place, &mut rows);
            let over = excess(&rows, rate, bend);
            let beyond = over > 1.0 + OVER;
            let excess = Excess {
                s,
                span,
                over,
                rows: if beyond {
                    binding(&mut rows)
                } else {
                    Vec::new()
                },
            };
            Some((pace.paced(&place, rate, bend), excess))
        });
        samples.collect()
    });
    let mut all: Vec<Vec<Option<(Paced, Excess)>>> = all.collect();
    for k in 0..count {
        // The first sample of a phase takes the place of the last one before it.
        let (so_far, next) = all.split_at_mut(k + 1);
        let samples = &mut so_far[k];
        let last = samples.len() - 1;
        let first_after = next.first().and_then(|next| next[0].as_ref());
        for i in 1..=last {
            let Some((before, _)) = &samples[i - 1] else {
                continue;
            };
            let follow = [samples[i].as_ref(), first_after.filter(|_| i == last)];
            let kinks = follow.into_iter().flatten();
            let kinks = kinks.map(|(now, _)| kink(before, now, config));
            let kink = kinks.fold(0.0, f64::max);
            if let Some((_, excess)) = &mut samples[i] {
                excess.over = excess.over.max(kink);
            }
        }
    }
    let phases = all
        .into_iter()
        .map(|samples| samples.into_iter().flatten().unzip());
    let (samples, used): (Vec<_>, Vec<Vec<Excess>>) = phases.unzip();
    (samples, used.into_iter().flatten().collect())
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
