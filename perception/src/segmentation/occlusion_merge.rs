//! Regions that one plane carries on behind what hides it.
//!
//! A floor goes on behind a ramp that stands on it, a wall behind a table. Regions apart are one
//! plane where one explains both and what is seen between them is in front of it.

use super::between::{Lines, ends};
use super::lattice::{Lattice, PlaneOf, View};
use super::merge::MISFIT_SIGMAS;
use super::moments::Moments;
use super::partition::{Partition, Region};

/// Both misfits to the joint plane stay below √((k σ)² + (m κ)²): this is m. Regions apart have no common border that
/// would show a step.
const MISFIT_SYSTEMATICS: f64 = 1.5;
/// One of both at least has so many [`Lattice::waves`]: nearly any two smaller regions have a plane in common,
/// the tops of blocks far apart too.
const WAVES_MIN: f64 = 0.5;

/// Merges regions that do not touch, the best pair first, where both keep a misfit below √((k σ)² + (m κ)²)
/// and most rows and columns of the view that hold both have the plane hidden between them.
///
/// Two regions smaller than the error's waves come last: nearly any two such patches have a plane in common, a
/// tread and a strip of the floor far behind it too.
pub(super) fn merge<L: Lattice>(lattice: &L, view: &View, partition: &mut Partition<L::Moments>) {
    let regions = partition.regions.iter().copied().map(Some);
    let mut regions: Vec<Option<Region<L::Moments>>> = regions.collect();
    let mut into: Vec<u16> = (0..).take(regions.len()).collect();
    let of_pair = |regions: &[Option<Region<L::Moments>>], (i, j): (usize, usize)| {
        let large = |k: usize| {
            regions[k]
                .as_ref()
                .filter(|r| lattice.tells_plane(&r.moments))
        };
        let (a, b) = (large(i)?, large(j)?);
        let (score, plane) = misfit(lattice, a, b)?;
        let told = [a, b]
            .iter()
            .any(|r| lattice.waves(&r.moments) >= WAVES_MIN);
        let last = [a, b].iter().all(|r| lattice.within_a_wave(&r.moments));
        (told && score < 1.0).then_some((score + f64::from(u8::from(last)), plane, (i, j)))
    };
    let pairs = (0..regions.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    let mut pairs: Vec<_> = pairs.filter_map(|pair| of_pair(&regions, pair)).collect();
    if pairs.is_empty() {
        return;
    }
    let mut ends = ends(view, &partition.owner, regions.len());
    while let Some(best) = (0..pairs.len()).min_by(|a, b| pairs[*a].0.total_cmp(&pairs[*b].0)) {
        let (_, plane, (i, j)) = pairs.remove(best);
        let lines = Lines::new(lattice, view, [&ends[i], &ends[j]], &plane);
        if lines.hidden <= lines.through + lines.other {
            // Not for what lies between them; merging others does not change that.
            continue;
        }
        into[j] = i as u16;
        let gone = std::mem::take(&mut ends[j]);
        ends[i].add(&gone);
        if let (Some(gone), Some(kept)) = (regions[j].take(), regions[i].as_mut()) {
            kept.moments.add(&gone.moments, 1.0);
            kept.plane = plane;
        }
        // Region i is another one now.
        pairs.retain(|(_, _, pair)| ![pair.0, pair.1].iter().any(|k| [i, j].contains(k)));
        let others = (0..regions.len()).filter(|k| *k != i);
        pairs.extend(others.filter_map(|k| of_pair(&regions, (i.min(k), i.max(k)))));
    }
    partition.replace(regions, &into);
}

/// The larger misfit to the joint plane in units of its limit, and that plane.
fn misfit<L: Lattice>(
    lattice: &L,
    a: &Region<L::Moments>,
    b: &Region<L::Moments>,
) -> Option<(f64, PlaneOf<L>)> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    let one = |region: &Region<L::Moments>| {
        let m = &region.moments;
        let excess = m.mean_square(&plane) - m.mean_square(&region.plane);
        excess / lattice.variance(m, &plane, MISFIT_SIGMAS, MISFIT_SYSTEMATICS)
    };
    let worst = one(a).max(one(b));
    worst.is_finite().then_some((worst.max(0.0), plane))
}
