//! Faces that are thinner than a block of cells: legs, rails, bars.

use super::ON_PLANE;
use super::growth::Growth;
use super::lattice::{Lattice, Shape};
use super::moments::Moments;
use super::partition::{Grown, NONE, Partition};

/// The regions that grow from strips over the cells that are left beside those `known`, and stand out.
///
/// A thin face beside a larger one, the front of a board, say, cannot be told from the noise of that
/// one's edge: what the plane beside it may claim as well is no face of its own.
pub(super) fn found<L: Lattice>(
    growth: &mut Growth<L>,
    known: &Partition<L::Moments>,
) -> Vec<Grown<L::Moments>> {
    let lattice = growth.lattice;
    let mut thin = growth.regions(Shape::Strip);
    let is_claimed = |&cell: &usize| {
        let moments = &lattice.cells()[cell];
        let mut beside = lattice
            .beside(cell)
            .map(|k| known.owner[k])
            .filter(|o| *o != NONE);
        beside.any(|o| {
            let plane = &known.regions[usize::from(o)].plane;
            let (k, m) = ON_PLANE;
            moments.mean_square(plane) < lattice.variance(moments, plane, k, m)
        })
    };
    thin.retain(|region| {
        let count = region.cells.iter().filter(|cell| is_claimed(cell)).count();
        2 * count < region.cells.len()
    });
    thin
}
