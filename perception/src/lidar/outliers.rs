//! Isolated points, by the mean distance to their neighbours.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

use super::rings::Rings;
use crate::Error;

/// Neighbours m that a point's mean distance is taken over.
pub(super) const NEIGHBOURS: usize = 30;
/// Points farther than κ standard deviations above the mean are isolated.
const KAPPA: f64 = 2.0;

/// Which points are not isolated. `plain` leaves distances as they are, as [meng] has it.
///
///   D_i ≤ μ + κ σ,   D_i the mean distance to m neighbours (over the range r_i), μ and σ its mean
///   and standard deviation over all points
///
/// Source: [meng] Eq. 9; deviation: normalised by range. With the plain distance a sweep of a real
/// VLP-16 loses nothing nearer than 2 m and everything beyond 10 m.
pub(super) fn inliers(mean_distances: &[f32], ranges: &[f32], plain: bool) -> Vec<bool> {
    let scaled: Vec<f32> = if plain {
        mean_distances.to_vec()
    } else {
        let pairs = mean_distances.iter().zip(ranges);
        pairs.map(|(d, r)| d / r).collect()
    };
    let finite = || {
        scaled
            .iter()
            .filter(|d| d.is_finite())
            .map(|d| f64::from(*d))
    };
    let n = finite().count().max(1) as f64;
    let mean = finite().sum::<f64>() / n;
    let variance = finite().map(|d| (d - mean).powi(2)).sum::<f64>() / n;
    let bound = (mean + KAPPA * variance.sqrt()) as f32;
    scaled.iter().map(|d| *d <= bound).collect()
}

/// Rings beside a point's own in which neighbours are looked for.
const RINGS_BESIDE: usize = 1;

/// The mean distance of every point to the m nearest of those around it on the rings, m.
///
/// Looked at are the m nearest in azimuth on its own ring and as many again, in two halves, on the
/// rings above and below: beams are an order of magnitude denser along a ring than across, so that
/// the nearest points are among these.
pub(super) fn ring_mean_distances(rings: &Rings, neighbours: usize) -> Vec<f32> {
    let mut means = vec![f32::INFINITY; rings.len()];
    // Half as many on either side, and a few more across.
    let own = neighbours + 1;
    let beside = neighbours / 2 + 3;
    let mut squared: Vec<f32> = Vec::with_capacity(own + 2 * RINGS_BESIDE * beside);
    for ring in 0..rings.count() {
        let (from, to) = (rings.starts[ring], rings.starts[ring + 1]);
        if from == to {
            continue;
        }
        let around =
            ring.saturating_sub(RINGS_BESIDE)..=(ring + RINGS_BESIDE).min(rings.count() - 1);
        let others: Vec<(usize, usize, Vec<u32>)> = around
            .filter(|&other| other != ring && rings.starts[other] < rings.starts[other + 1])
            .map(|other| {
                let (f, t) = (rings.starts[other], rings.starts[other + 1]);
                (f, t, rings.places_in(other, ring))
            })
            .collect();
        for i in from..to {
            squared.clear();
            window(rings, i, i, (from, to), own, &mut squared);
            for (f, t, places) in &others {
                window(
                    rings,
                    i,
                    places[i - from] as usize,
                    (*f, *t),
                    beside,
                    &mut squared,
                );
            }
            means[i] = mean_of_least(&mut squared, neighbours);
        }
    }
    means
}

/// Appends the squared distances of point `i` from the `count` points about `place` in a ring, itself
/// left out.
fn window(
    rings: &Rings,
    i: usize,
    place: usize,
    (from, to): (usize, usize),
    count: usize,
    squared: &mut Vec<f32>,
) {
    let count = count.min(to - from);
    let low = place as isize - (count / 2) as isize;
    let (x, y, z) = (rings.x[i], rings.y[i], rings.z[i]);
    let mut add = |a: usize, b: usize| {
        let near = rings.x[a..b].iter().zip(&rings.y[a..b]).zip(&rings.z[a..b]);
        squared.extend(near.map(|((px, py), pz)| {
            let (dx, dy, dz) = (px - x, py - y, pz - z);
            dx * dx + dy * dy + dz * dz
        }));
    };
    if rings.closed {
        // Round the end of the ring and on at its beginning.
        let n = to - from;
        let first = (low - from as isize).rem_euclid(n as isize) as usize;
        let run = count.min(n - first);
        add(from + first, from + first + run);
        add(from, from + count - run);
    } else {
        let first = low.clamp(from as isize, (to - count) as isize) as usize;
        add(first, first + count);
    }
}

/// The mean of the square roots of the least `count` values but the point itself at distance 0.
fn mean_of_least(squared: &mut [f32], count: usize) -> f32 {
    // The point itself is among them, at zero.
    let take = (count + 1).min(squared.len());
    if take < 2 {
        return f32::INFINITY;
    }
    if take < squared.len() {
        squared.select_nth_unstable_by(take - 1, f32::total_cmp);
    }
    let sum: f32 = squared[..take].iter().map(|d| d.sqrt()).sum();
    sum / (take - 1) as f32
}

/// The mean distance of every point to its m nearest neighbours, m: by a search tree.
///
/// # Errors
/// [`Error::Neighbours`] when the tree refuses the points.
pub(super) fn tree_mean_distances(
    points: &[[f32; 3]],
    neighbours: usize,
) -> Result<Vec<f32>, Error> {
    // Itself and m others.
    let Some(count) = NonZero::new((neighbours + 1).min(points.len())) else {
        return Ok(Vec::new());
    };
    let flat: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
    let tree =
        ImmutableKdTree::<f64, 3>::new_from_slice(&flat).map_err(|source| Error::Neighbours {
            source: Box::new(source),
        })?;
    let mean = |p: &[f64; 3]| {
        let found = tree
            .query(p)
            .nearest_n::<SquaredEuclidean<f64>>(count)
            .execute();
        let sum: f64 = found.iter().map(|item| item.distance.sqrt()).sum();
        if count.get() < 2 {
            f32::INFINITY
        } else {
            (sum / (count.get() - 1) as f64) as f32
        }
    };
    Ok(flat.iter().map(mean).collect())
}
