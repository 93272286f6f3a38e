//! Phases that are gone through one after the other without a stop, in time.
//!
//! The parameter s goes from k to k + 1 along phase k. Borders are to be on samples: the last law's time τ
//! runs a little slower on each phase, by quintic steps, so that nothing jumps.

use rayon::prelude::*;

use super::smoothing::{Grid, excess, smooth};
use super::{Lean, OVER, Pace, Paced};
use crate::load_shares::LoadShares;
use crate::problem::MotionContext;
use crate::segment::PhaseTrajectory;
use crate::time_scaling::quintic;

/// How often the forces are suited to the law that came of the last ones, and the part of the time from
/// which on that is worth going on.
const PASSES: usize = 6;
const WORTH: f64 = 0.98;
/// How often a law is sought until its means over time are within the limits: while forces are still to be
/// suited to it, and in the end.
const ROUGHLY: usize = 3;
const FINALLY: usize = 8;
/// How often a law is made slower until every sample is within its limits.
const STRETCHES: usize = 10;

/// The least time for a phase from rest to rest, s: before forces suit its law.
pub(crate) fn least_s(context: &MotionContext, phase: &PhaseTrajectory) -> f64 {
    let mut pace = Pace::new(context, phase);
    let rows = pace.places(&[]);
    let rows = rows.iter().map(|place| pace.rows(place)).collect();
    let law = smooth(&Grid::new(vec![rows]), context.config, ROUGHLY);
    law.map_or(0.0, |(law, over)| law.duration_s() * over.max(1.0))
}

/// The samples of the phases, `dt_s` apart, both ends of each included, and by what shares their contacts
/// bear what is needed; nothing where no law is found.
pub(crate) fn samples(
    context: &MotionContext,
    phases: &[&PhaseTrajectory],
) -> Vec<(LoadShares, Vec<Paced>)> {
    let config = context.config;
    let paces = phases.iter().map(|phase| Pace::new(context, phase));
    let mut paces: Vec<Pace> = paces.collect();
    // The fastest law, by forces that suit the one before it.
    let mut best: Option<(f64, Grid, Vec<Vec<Lean>>)> = None;
    let mut leans = vec![Vec::new(); paces.len()];
    for _ in 0..PASSES {
        let places = paces.par_iter_mut().zip(&leans).map(|(pace, leans)| {
            let places = pace.places(leans);
            let rows = places.iter().map(|place| pace.rows(place));
            let rows = rows.collect();
            (places, rows)
        });
        let (places, rows): (Vec<_>, Vec<_>) = places.collect::<Vec<_>>().into_iter().unzip();
        // At rest every row has room, so there is one.
        let grid = Grid::new(rows);
        let Some((law, _)) = smooth(&grid, config, ROUGHLY) else {
            break;
        };
        let time = law.duration_s();
        let before = best.as_ref().map(|(time, ..)| *time);
        if before.is_some_and(|before| time >= before) {
            break;
        }
        let next = paces.par_iter().zip(&places).enumerate();
        let next = next.map(|(k, (pace, places))| {
            let pieces = (places.len() - 1) as f64;
            let lean = places.iter().enumerate().map(|(i, place)| {
                let [_, rate, bend] = law.at(law.time_s(k as f64 + i as f64 / pieces));
                pace.lean(place, rate, bend)
            });
            lean.collect()
        });
        let next = next.collect();
        best = Some((time, grid, std::mem::replace(&mut leans, next)));
        if before.is_some_and(|before| time > WORTH * before) {
            break;
        }
    }
    let last = best.and_then(|(_, grid, leans)| Some((smooth(&grid, config, FINALLY)?, leans)));
    let Some(((mut law, mut over), leans)) = last else {
        return Vec::new();
    };
    let mut samples = Vec::new();
    for tried in 0..STRETCHES {
        // Samples of other times meet sharp places of the path elsewhere: every try goes farther than what
        // the last one's samples say.
        law = law.slower(1.0 + (over - 1.0).max(0.0) * tried.max(1) as f64);
        let time = |k: usize| match k {
            0 => 0.0,
            k if k == phases.len() => law.duration_s(),
            k => law.time_s(k as f64),
        };
        let borders: Vec<f64> = (0..=phases.len()).map(time).collect();
        let all = paces.par_iter_mut().zip(&leans).enumerate();
        let all = all.map(|(k, (pace, leans))| {
            let mut over = 0.0_f64;
            let states = stepped([borders[k], borders[k + 1]], config.dt_s);
            let paced = states.iter().map(|[tau, slower, change]| {
                let [s, rate, bend] = law.at(*tau);
                let (rate, bend) = (rate * slower, bend * slower * slower + rate * change);
                let place = pace.place((s - k as f64).clamp(0.0, 1.0), leans);
                over = over.max(excess(pace.rows(&place).iter().copied(), rate, bend));
                pace.paced(&place, rate, bend)
            });
            (paced.collect(), over)
        });
        let (paced, overs): (Vec<Vec<Paced>>, Vec<f64>) =
            all.collect::<Vec<_>>().into_iter().unzip();
        samples = paced;
        over = overs.into_iter().fold(0.0, f64::max);
        if over <= 1.0 + OVER {
            break;
        }
    }
    // What stays outside the limits is no law for several phases; of one alone it is written, and refused.
    if over > 1.0 + OVER && phases.len() > 1 {
        return Vec::new();
    }
    let shares = paces.into_iter().map(|pace| pace.shares);
    shares.zip(samples).collect()
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
