//! Small regions that the planes around them explain.

use super::MISFIT;
use super::lattice::{Lattice, PlaneOf};
use super::moments::Moments;
use super::partition::{NONE, Partition};

/// Drops the small regions that do not stand out: those of which half of the cells at least lie on planes
/// of the regions beside theirs, as planar cells that these could have grown over.
///
/// A sliver along the crease of two faces cannot be told from the noise of the faces that meet there. Only larger
/// regions explain one: two pieces of a small face would drop each other.
/// The limit is that of growth, not the wider one of points: a plate of 2 cm on a floor is to stay.
pub(crate) fn drop_slivers<L: Lattice>(lattice: &L, partition: &mut Partition<L::Moments>) {
    let Partition { regions, owner } = &*partition;
    let small = regions
        .iter()
        .map(|region| lattice.is_sliver(&region.moments));
    let small: Vec<bool> = small.collect();
    let is_small = |own: u16| small.get(usize::from(own)) == Some(&true);
    let size = |own: u16| (regions[usize::from(own)].moments.count(), own);
    let cells = (0..).zip(owner.iter().copied());
    let cells: Vec<(usize, u16)> = cells.filter(|(_, own)| is_small(*own)).collect();
    let mut around: Vec<Vec<u16>> = vec![Vec::new(); regions.len()];
    for &(cell, own) in &cells {
        let around = &mut around[usize::from(own)];
        for other in lattice.beside(cell).map(|k| owner[k]) {
            if other != NONE && size(other) > size(own) && !around.contains(&other) {
                around.push(other);
            }
        }
    }
    // How many more cells of each are claimed than are not.
    let mut excess = vec![0_i32; regions.len()];
    for (cell, own) in cells {
        let moments = &lattice.cells()[cell];
        let explains = |o: &u16| {
            let plane = &regions[usize::from(*o)].plane;
            moments.mean_square(plane) < grown_over(lattice, moments, plane)
        };
        let is_claimed = around[usize::from(own)].iter().any(explains);
        excess[usize::from(own)] += if is_claimed { 1 } else { -1 };
    }
    partition.retain(|i, _| !small[i] || excess[i] < 0);
}

/// The mean square about a plane up to which a planar cell could have been grown over.
pub(super) fn grown_over<L: Lattice>(lattice: &L, cell: &L::Moments, plane: &PlaneOf<L>) -> f64 {
    lattice.planar(cell, plane) + lattice.variance(cell, plane, MISFIT.0, MISFIT.1)
}
