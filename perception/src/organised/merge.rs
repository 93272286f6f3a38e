//! Merging of neighbouring regions that one plane explains.

use serde::{Deserialize, Serialize};

use super::borders::{Border, Sums, borders};
use super::cell::CellNoise;
use super::growth::Region;
use super::image::Grid;
use super::moments::Moments;
use super::partition::Partition;
use crate::Error;
use crate::error::within;
use crate::sensor::Noise;

/// When two regions are one plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MergeConfig {
    /// Both misfits to the joint plane stay below √((k σ)² + (m κ w)²): this is k.
    pub misfit_sigmas: f64,
    /// The m of [`Self::misfit_sigmas`], in units of the sensor's systematic error κ.
    pub misfit_systematics: f64,
    /// The same m for regions smaller than the error's waves: all of one may lie on a crest.
    pub misfit_systematics_small: f64,
    /// The same m for regions apart, where what is between them hides the plane.
    pub misfit_systematics_hidden: f64,
    /// The mean step across the common border stays below this many κ w (and 2 σ of the mean):
    /// the slowly varying error bends a plane but does not break it.
    pub step_systematics: f64,
}

impl Default for MergeConfig {
    fn default() -> Self {
        Self {
            misfit_sigmas: 0.5,
            misfit_systematics: 2.5,
            misfit_systematics_small: 4.0,
            misfit_systematics_hidden: 2.0,
            step_systematics: 1.8,
        }
    }
}

impl MergeConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let range = "must be in [0, 100]";
        for (key, value) in [
            ("misfit_sigmas", self.misfit_sigmas),
            ("misfit_systematics", self.misfit_systematics),
            ("misfit_systematics_small", self.misfit_systematics_small),
            ("misfit_systematics_hidden", self.misfit_systematics_hidden),
            ("step_systematics", self.step_systematics),
        ] {
            within(key, value, 0.0, 100.0, range)?;
        }
        Ok(())
    }
}

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

/// Merges regions (of cells of the small grid) that lie within three cells of each other, the best
/// pair first, only where *both* keep a small misfit under the joint plane and the surface does
/// not step at their border.
pub(super) fn merge(grid: &Grid, partition: &mut Partition, noise: &Noise, config: &MergeConfig) {
    let mut regions: Vec<Option<Region>> = partition.regions.iter().copied().map(Some).collect();
    let score = |regions: &[Option<Region>], (i, j): (u16, u16), border: &Border| {
        let of = |k: u16| regions[usize::from(k)].as_ref();
        misfit(of(i)?, of(j)?, border, grid, noise, config)
    };
    let borders = borders(grid, partition).into_iter();
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

/// Largest of both misfits to the joint plane and the step at the border, each in units of its
/// limit; `None` where it is above that, or no plane is the plane of both.
fn misfit(
    a: &Region,
    b: &Region,
    border: &Border,
    grid: &Grid,
    noise: &Noise,
    config: &MergeConfig,
) -> Option<f64> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    // Misfits beyond the regions' own, 1/m, and in units of their limits.
    let small = 4.0 * std::f64::consts::PI * noise.systematic_scale_px.powi(2);
    let one = |region: &Region| {
        let m: &Moments = &region.moments;
        let excess = m.mean_square(&plane) - m.mean_square(&region.plane);
        let systematics = if m.n < small {
            config.misfit_systematics_small
        } else {
            config.misfit_systematics
        };
        let local = CellNoise::at(noise, m.mean());
        let excess = excess.max(0.0).sqrt();
        (
            excess,
            excess / local.square(config.misfit_sigmas, systematics).sqrt(),
        )
    };
    let (of_a, of_b) = (one(a), one(b));
    let worst = of_a.1.max(of_b.1);
    if worst > 1.0 {
        return None;
    }
    // Mean difference of the residuals of the cells on either side of the border. The joint plane
    // of two patches of a size lies a quarter of the step between them off each, in the mean: what
    // is far more is an error of the cells there, at the edge of what hides the rest.
    let border = Sums::new(grid, border)?;
    let count = border.pairs;
    let step = (border.w - plane.0.x * border.u - plane.0.y * border.v) / count;
    let step = step.abs().min(STEP_OF_MISFIT * of_a.0.max(of_b.0));
    let alike = 4.0 * std::f64::consts::PI * noise.correlation_px.powi(2);
    let pixels = (grid.size * grid.size) as f64;
    let sigmas = 2.0 * (alike / (count * pixels)).min(1.0).sqrt();
    let limit = CellNoise::at(noise, border.level / count).square(sigmas, config.step_systematics);
    let score = worst.max(step / limit.sqrt());
    (score <= 1.0).then_some(score)
}

/// A step is at most this many times the larger misfit.
const STEP_OF_MISFIT: f64 = 5.0;
