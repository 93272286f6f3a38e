//! Cells at the border of two regions go to the plane that fits them better.
//!
//! A region that grows first takes what its plane still explains: the foot of a ramp runs out onto
//! the floor, and what it took there tilts its plane, which then explains more. Each exchange makes
//! both planes truer, and is followed by another until there is none.

use super::lattice::Lattice;
use super::moments::Moments;
use super::partition::{NONE, Partition};
use super::slivers::grown_over;

/// A border moves by one cell a sweep; few move by more than this.
const SWEEPS: usize = 24;

/// Gives cells of regions to neighbours that fit them better, refits the planes and goes on around the cells
/// that moved, as long as there are any; where two regions are `apart`, the smaller index first.
pub(super) fn refine<L: Lattice>(
    lattice: &L,
    partition: &mut Partition<L::Moments>,
    apart: impl Fn(&(u16, u16)) -> bool,
) {
    let Partition { regions, owner } = partition;
    let mut frontier = lattice.frontier(owner);
    let mut changed = vec![false; regions.len()];
    let mut next = Vec::new();
    for _ in 0..SWEEPS {
        changed.fill(false);
        next.clear();
        for &i in &frontier {
            let i = i as usize;
            let cell = &lattice.cells()[i];
            let own = owner[i];
            // Without a neighbour that fits better it stays where it is.
            let square = |region: u16| cell.mean_square(&regions[usize::from(region)].plane);
            let mut best = (None, own);
            for other in lattice.beside(i).map(|k| owner[k]) {
                let pair = (own.min(other), own.max(other));
                if other != NONE && other != own && other != best.1 && apart(&pair) {
                    let least = *best.0.get_or_insert_with(|| square(own));
                    let misfit = square(other);
                    if misfit < least {
                        best = (Some(misfit), other);
                    }
                }
            }
            let (Some(misfit), to) = best else { continue };
            let (from, to) = (usize::from(own), usize::from(to));
            if from == to || misfit > grown_over(lattice, cell, &regions[to].plane) {
                continue;
            }
            owner[i] = to as u16;
            regions[from].moments.add(cell, -1.0);
            regions[to].moments.add(cell, 1.0);
            (changed[from], changed[to]) = (true, true);
            next.push(i as u32);
            next.extend(
                lattice
                    .beside(i)
                    .filter(|k| owner[*k] != NONE)
                    .map(|k| k as u32),
            );
        }
        if !changed.contains(&true) {
            break;
        }
        for (region, _) in regions.iter_mut().zip(&changed).filter(|(_, c)| **c) {
            region.plane = region.moments.plane().unwrap_or(region.plane);
        }
        next.sort_unstable();
        next.dedup();
        std::mem::swap(&mut frontier, &mut next);
    }
    // What has no cell left is no region.
    partition.retain(|_, region| region.moments.count() >= 1.0);
}
