//! Merging of neighbouring regions that one plane explains.

use std::collections::BTreeMap;

use super::grid::{Level, NONE};
use super::growth::{Grown, Region};
use super::tolerance::Tolerance;

/// Both misfits to the joint plane stay below √((k σ)² + (m κ r)²).
const MISFIT_SIGMAS: f64 = 0.5;
const MISFIT_SYSTEMATICS: f64 = 2.5;
/// The mean step across the common border stays below √((k σ)² + (m κ r)²).
const STEP_SIGMAS: f64 = 0.5;
const STEP_SYSTEMATICS: f64 = 1.8;

/// The common border of two regions.
#[derive(Default)]
struct Border {
    /// Voxels on either side, that of the smaller region first.
    cells: Vec<(u32, u32)>,
    /// Misfit in units of its limit; none where that is above it.
    score: Option<f64>,
}

/// Merges regions that touch, the best pair first, where both keep a small misfit under the joint
/// plane and the surface does not step at their border.
pub(super) fn merge(level: &Level, grown: &mut Grown, tolerance: &Tolerance) {
    let mut borders: BTreeMap<(u32, u32), Border> = BTreeMap::new();
    for (i, &a) in grown.owner.iter().enumerate().filter(|(_, a)| **a != NONE) {
        for &k in level.around[i].iter().filter(|k| **k != NONE) {
            let b = grown.owner[k as usize];
            if b != NONE && a < b {
                let border = borders.entry((a, b)).or_default();
                border.cells.push((i as u32, k));
            }
        }
    }
    let score = |grown: &Grown, pair: (u32, u32), border: &Border| {
        misfit(level, grown, pair, &border.cells, tolerance).filter(|score| *score <= 1.0)
    };
    for (&pair, border) in &mut borders {
        border.score = score(grown, pair, border);
    }
    // Where each region went.
    let mut into: Vec<u32> = (0..grown.regions.len() as u32).collect();
    loop {
        let best = borders
            .iter()
            .filter_map(|(pair, border)| Some((border.score?, *pair)))
            .reduce(|a, b| if b.0 < a.0 { b } else { a });
        let Some((_, (a, b))) = best else { break };
        let gone = grown.regions[b as usize].clone();
        let kept: &mut Region = &mut grown.regions[a as usize];
        kept.moments.add(&gone.moments);
        if let Some(fit) = kept.moments.fit() {
            kept.plane = fit.plane;
        }
        into.iter_mut().filter(|r| **r == b).for_each(|r| *r = a);
        // Borders of b become borders of a.
        let has = |pair: &(u32, u32), region: u32| pair.0 == region || pair.1 == region;
        let moved: Vec<_> = borders.extract_if(.., |pair, _| has(pair, b)).collect();
        for ((p, q), border) in moved {
            let other = if p == b { q } else { p };
            if other != a {
                let swap = (p == b) != (a < other);
                let turned = border
                    .cells
                    .into_iter()
                    .map(|(i, k)| if swap { (k, i) } else { (i, k) });
                borders
                    .entry((a.min(other), a.max(other)))
                    .or_default()
                    .cells
                    .extend(turned);
            }
        }
        // Of those that are left, only the scores of a's have changed.
        for (&pair, border) in borders.iter_mut().filter(|(pair, _)| has(pair, a)) {
            border.score = score(grown, pair, border);
        }
    }
    for r in grown.owner.iter_mut().filter(|r| **r != NONE) {
        *r = into[*r as usize];
    }
}

/// Largest of both misfits to the joint plane and the step at the border, in units of their limits.
fn misfit(
    level: &Level,
    grown: &Grown,
    (a, b): (u32, u32),
    border: &[(u32, u32)],
    tolerance: &Tolerance,
) -> Option<f64> {
    let (a, b) = (&grown.regions[a as usize], &grown.regions[b as usize]);
    let mut joint = a.moments;
    joint.add(&b.moments);
    let plane = joint.fit()?.plane;
    let one = |region: &Region| {
        let excess = region.moments.mean_square(&plane) - region.moments.mean_square(&region.plane);
        let at = region.moments.mean();
        excess.max(0.0).sqrt() / tolerance.at(&at, &plane, MISFIT_SIGMAS, MISFIT_SYSTEMATICS)
    };
    let height = |i: u32| plane.height(&level.cells[i as usize].mean());
    let count = border.len().max(1) as f64;
    let step: f64 = border.iter().map(|&(i, k)| height(i) - height(k)).sum();
    let at = level.cells[border.first()?.0 as usize].mean();
    let limit = tolerance.at(&at, &plane, STEP_SIGMAS, STEP_SYSTEMATICS);
    Some(one(a).max(one(b)).max((step / count).abs() / limit))
}
