//! Merging of neighbouring regions that one plane explains.

use std::collections::BTreeSet;

use super::lattice::{Border, Lattice};
use super::moments::Moments;
use super::partition::{Partition, Region};

/// Both misfits to the joint plane stay below √((k σ)² + (m κ)²): this is k.
pub(super) const MISFIT_SIGMAS: f64 = 0.5;
/// The m of [`MISFIT_SIGMAS`], and the same for regions smaller than the error's waves: all of one may lie on a
/// crest.
const MISFIT_SYSTEMATICS: f64 = 2.5;
const MISFIT_SYSTEMATICS_SMALL: f64 = 4.0;
/// Regions that together are smaller than its waves the error hardly bends: m is at most a + b t for both of
/// [`Lattice::waves`] t. Of an error with the correlation exp(−r²/4s²) a plane leaves 0.4 κ t in the root mean square;
/// a is for what the regions' own planes are off by noise.
const BEND: (f64, f64) = (0.5, 0.65);
/// The mean step across the common border stays below this many κ (and 2 σ of the mean): the slowly
/// varying error bends a plane but does not break it.
const STEP_SYSTEMATICS: f64 = 1.8;
/// A step is at most this many times the larger misfit: the joint plane of two patches of a size lies a
/// quarter of the step between them off each, in the mean; what is far more is an error of the cells
/// there, at the edge of what hides the rest.
const STEP_OF_MISFIT: f64 = 5.0;

/// Two regions with a common border, the one with the smaller index first.
struct Pair {
    regions: (u16, u16),
    border: Border,
    /// Misfit in units of its limit; none where that is above it.
    score: Option<f64>,
}

impl Pair {
    fn has(&self, region: u16) -> bool {
        self.regions.0 == region || self.regions.1 == region
    }
}

/// Merges regions that are beside each other, the best pair first, only where *both* keep a small misfit under the joint plane and the surface does
/// not step at their border.
pub(super) fn merge<L: Lattice>(lattice: &L, partition: &mut Partition<L::Moments>) {
    let mut regions: Vec<Option<Region<L::Moments>>> =
        partition.regions.iter().copied().map(Some).collect();
    let score = |regions: &[Option<Region<L::Moments>>], (i, j): (u16, u16), border: &Border| {
        let of = |k: u16| regions[usize::from(k)].as_ref();
        misfit(lattice, of(i)?, of(j)?, border)
    };
    let borders = lattice.borders(partition).into_iter();
    let scored = |(pair, border)| Pair {
        regions: pair,
        score: score(&regions, pair, &border),
        border,
    };
    let mut pairs: Vec<Pair> = borders.map(scored).collect();
    let mut into: Vec<u16> = (0..).take(regions.len()).collect();
    loop {
        let scores = pairs.iter().filter_map(|p| Some((p.score?, p.regions)));
        let best = scores.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let Some((_, (i, j))) = best else { break };
        into[usize::from(j)] = i;
        let gone = regions[usize::from(j)].take();
        if let (Some(kept), Some(gone)) = (regions[usize::from(i)].as_mut(), gone) {
            kept.moments.add(&gone.moments, 1.0);
            kept.plane = kept.moments.plane().unwrap_or(kept.plane);
        }
        // Borders of j become borders of i; only the scores of i's change.
        pairs.retain(|pair| pair.regions != (i, j));
        for mut pair in pairs.extract_if(.., |pair| pair.has(j)).collect::<Vec<_>>() {
            let (first, second) = pair.regions;
            let other = if first == j { second } else { first };
            if (first == j) != (i < other) {
                pair.border.iter_mut().for_each(|cells| cells.reverse());
            }
            pair.regions = (i.min(other), i.max(other));
            match pairs.iter_mut().find(|known| known.regions == pair.regions) {
                Some(known) => known.border.append(&mut pair.border),
                None => pairs.push(pair),
            }
        }
        for pair in pairs.iter_mut().filter(|pair| pair.has(i)) {
            pair.score = score(&regions, pair.regions, &pair.border);
        }
    }
    partition.replace(regions, &into);
}

/// The regions beside each other that no one plane explains, the smaller index first.
pub(super) fn apart<L: Lattice>(
    lattice: &L,
    partition: &Partition<L::Moments>,
) -> BTreeSet<(u16, u16)> {
    let of = |k: u16| &partition.regions[usize::from(k)];
    let borders = lattice.borders(partition).into_iter();
    let apart =
        borders.filter(|((i, j), border)| misfit(lattice, of(*i), of(*j), border).is_none());
    apart.map(|(pair, _)| pair).collect()
}

/// Largest of both misfits to the joint plane and the step at the border, each in units of its
/// limit; `None` where it is above that, or no plane is the plane of both.
fn misfit<L: Lattice>(
    lattice: &L,
    a: &Region<L::Moments>,
    b: &Region<L::Moments>,
    border: &Border,
) -> Option<f64> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    let bend = BEND.0 + BEND.1 * lattice.waves(&joint);
    // Misfits beyond the regions' own, and in units of their limits.
    let one = |Region {
                   moments,
                   plane: own,
               }: &Region<L::Moments>| {
        let excess = moments.mean_square(&plane) - moments.mean_square(own);
        let excess = excess.max(0.0).sqrt();
        let systematics = if lattice.within_a_wave(moments) {
            MISFIT_SYSTEMATICS_SMALL
        } else {
            MISFIT_SYSTEMATICS
        };
        let limit = lattice.variance(moments, &plane, MISFIT_SIGMAS, systematics.min(bend));
        (excess, excess / limit.sqrt())
    };
    let (of_a, of_b) = (one(a), one(b));
    let worst = of_a.1.max(of_b.1);
    if worst > 1.0 {
        return None;
    }
    let (step, limit) = lattice.step(border, &plane, STEP_SYSTEMATICS)?;
    let step = step.abs().min(STEP_OF_MISFIT * of_a.0.max(of_b.0));
    let score = worst.max(step / limit.sqrt());
    (score <= 1.0).then_some(score)
}
