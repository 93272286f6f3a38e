//! What a segmentation asks of the cells that it works on: image cells or voxels.

use std::cmp::Ordering;

use super::moments::Moments;
use super::partition::Partition;

pub(crate) type PlaneOf<L> = <<L as Lattice>::Moments as Moments>::Plane;

/// The pairs of neighbouring cells of two regions: of the first, of the second.
pub(crate) type Border = Vec<[u32; 2]>;

/// What regions grow from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    /// A block of cells, in which every face but a thin one holds.
    Block,
    /// Cells in a row: legs, rails, fronts of boards.
    Strip,
}

/// Cells that a region may begin with. The flattest are the least; equal ones by their place.
pub(crate) type Seed = u64;

/// A seed of a score, which is not negative, at a place: the bits of such numbers are in their order.
pub(crate) fn seed_of(score: f32, place: usize) -> Seed {
    u64::from(score.to_bits()) << 32 | place as u64
}

/// Cells of additive moments with neighbours, all of one size.
pub(crate) trait Lattice {
    type Moments: Moments;
    /// What growth keeps of a cell that takes part.
    type Cell;
    /// A plane as cells are tested against it.
    type Test;
    /// Whether regions of larger cells go on over the cells of this size beside them: where larger cells
    /// straddle two faces, those are left open.
    const RESUMES: bool;

    /// The moments of every cell.
    fn cells(&self) -> &[Self::Moments];
    /// The cells that touch one; where there is none, the cell itself may stand for it.
    fn beside(&self, cell: usize) -> impl Iterator<Item = usize>;
    /// The regions of these cells, given those of the cells of the next larger size.
    fn inherit_owners(&self, coarse: &Self, owner: &[u16]) -> Vec<u16>;
    /// (k σ)² + (m κ)² of residuals where some points are: σ is the sensor's noise, κ its slowly varying
    /// error.
    fn variance(&self, at: &Self::Moments, plane: &PlaneOf<Self>, k: f64, m: f64) -> f64;
    /// Largest mean square of a planar cell about its own plane.
    fn planar(&self, at: &Self::Moments, plane: &PlaneOf<Self>) -> f64;

    /// A cell for growth; `None` where it takes no part.
    fn cell(&self, cell: usize) -> Option<Self::Cell>;
    /// Whether a cell takes no part because too little of it was measured.
    fn is_hole(&self, cell: usize) -> bool;
    fn test(&self, plane: &PlaneOf<Self>) -> Self::Test;
    /// Whether a cell's misfit to a plane, beyond its own noise, is within the limit of growth.
    fn fits(&self, number: usize, cell: &Self::Cell, plane: &Self::Test) -> bool;
    /// Places of a shape whose cells are open (not `shut`) and fit one plane, in no order. `of` gives a
    /// cell that is open.
    fn seeds<'a>(
        &self,
        shape: Shape,
        of: impl Fn(usize) -> &'a Self::Cell,
        shut: &[bool],
    ) -> Vec<Seed>
    where
        Self::Cell: 'a;
    /// Puts the cells of a seed of a shape in place of others; `false` where too few of them are open.
    fn open_cells<'a>(
        &self,
        shape: Shape,
        seed: Seed,
        of: impl Fn(usize) -> &'a Self::Cell,
        shut: &[bool],
        cells: &mut Vec<usize>,
    ) -> bool
    where
        Self::Cell: 'a;
    /// Whether a region of a shape is large enough to be one.
    fn is_region(&self, shape: Shape, moments: &Self::Moments, cells: usize) -> bool;

    /// The common borders of all regions, by both, the smaller index first.
    fn borders(&self, partition: &Partition<Self::Moments>) -> Vec<((u16, u16), Border)>;
    /// The cells beside another region's, ascending.
    fn frontier(&self, owner: &[u16]) -> Vec<u32>;
    /// The mean step of the residuals across a border, and the square of its limit, with `m` for the
    /// slowly varying error; `None` where nothing tells it.
    fn step(&self, border: &Border, plane: &PlaneOf<Self>, m: f64) -> Option<(f64, f64)>;
    /// Whether a region is smaller than the waves of the slowly varying error: all of it may lie on a
    /// crest.
    fn within_a_wave(&self, region: &Self::Moments) -> bool;
    /// The mean square of the distances of a region's points from their middle, as the sensor sees them, in
    /// units of the square of the length over which the slowly varying error varies; infinite where that
    /// is not known.
    fn waves(&self, region: &Self::Moments) -> f64;
    /// Whether a region is so small that it must stand out from those around it.
    fn is_sliver(&self, region: &Self::Moments) -> bool;
    /// Whether a region is large enough to tell its plane from what hides a part of it.
    fn tells_plane(&self, region: &Self::Moments) -> bool;

    /// The cells as the sensor saw them.
    fn view(&self) -> View;
    /// Whether what is in a cell is surely nearer than a plane (less), so that it hides it, or surely beyond; `None` of
    /// an empty one.
    fn side(&self, cell: usize, plane: &PlaneOf<Self>) -> Option<Ordering>;
}

/// A picture of cells, row by row.
pub(crate) struct View {
    pub cols: usize,
    pub rows: usize,
    /// The cell that each place shows, [`View::NOTHING`] for none; `None` where place and cell have the
    /// same number.
    pub cell: Option<Vec<u32>>,
}

impl View {
    pub const NOTHING: u32 = u32::MAX;

    /// The cell that a place shows.
    #[inline]
    pub fn at(&self, place: usize) -> Option<usize> {
        match &self.cell {
            None => Some(place),
            Some(cells) => Some(cells[place])
                .filter(|c| *c != Self::NOTHING)
                .map(|c| c as usize),
        }
    }
}
