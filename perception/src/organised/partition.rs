//! Which region each small cell belongs to.

use super::growth::{Grown, Region};
use super::image::Grid;
use super::labels::NONE;

/// Regions, and the cells of each.
pub(super) struct Partition {
    pub regions: Vec<Region>,
    /// Index of the region of each cell of the grid, or [`NONE`].
    pub owner: Vec<u16>,
}

impl Partition {
    /// Of a grid's cells, without a region.
    pub fn new(grid: &Grid) -> Self {
        Self {
            regions: Vec::new(),
            owner: vec![NONE; grid.cells.len()],
        }
    }

    /// Adds a region of cells that have none. Numbers are 16 bits: of more regions (an image of many
    /// megapixels) the first are kept.
    pub fn add(&mut self, grown: Grown) {
        self.add_of(grown.region, grown.cells.into_iter());
    }

    /// The same of cells on the grid of those twice as large.
    pub fn add_large(&mut self, grown: Grown, large: &Grid, small: &Grid) {
        let parts = grown.cells.into_iter().flat_map(|i| {
            let (x, y) = large.place(i);
            let corner = 2 * y * small.cols + 2 * x;
            let below = corner + small.cols;
            [corner, corner + 1, below, below + 1]
        });
        self.add_of(grown.region, parts);
    }

    fn add_of(&mut self, region: Region, cells: impl Iterator<Item = usize>) {
        let number = self.regions.len() as u16;
        if self.regions.len() < usize::from(NONE) {
            cells.for_each(|cell| self.owner[cell] = number);
            self.regions.push(region);
        }
    }

    /// Leaves the regions for which `stays` holds; the cells of the others have none then.
    pub fn retain(&mut self, stays: impl Fn(usize, &Region) -> bool) {
        let left = self.regions.iter().enumerate();
        let left = left.map(|(i, region)| stays(i, region).then_some(*region));
        let own: Vec<u16> = (0..).take(self.regions.len()).collect();
        self.replace(left.collect(), &own);
    }

    /// Puts other regions in the place of those that there are. The cells of one that is no more go to
    /// the one with the smaller index that `into` says; to none where that is its own.
    pub fn replace(&mut self, regions: Vec<Option<Region>>, into: &[u16]) {
        let mut numbers = vec![NONE; regions.len()];
        self.regions.clear();
        for (i, region) in regions.into_iter().enumerate() {
            if let Some(region) = region {
                numbers[i] = self.regions.len() as u16;
                self.regions.push(region);
            } else {
                numbers[i] = numbers[usize::from(into[i])];
            }
        }
        if self.regions.len() == numbers.len() {
            return;
        }
        for owner in &mut self.owner {
            *owner = numbers.get(usize::from(*owner)).copied().unwrap_or(NONE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::organised::moments::{InversePlane, Moments};

    #[test]
    fn cells_of_a_region_that_is_no_more_go_where_it_went() {
        let region = |n: f64| Region {
            moments: Moments {
                n,
                ..Moments::default()
            },
            plane: InversePlane(nalgebra::Vector3::zeros()),
        };
        let mut partition = Partition {
            regions: [1.0, 2.0, 3.0, 4.0, 5.0].map(region).to_vec(),
            owner: vec![0, 1, 2, 3, 4, NONE],
        };
        // The last goes to the third, which went to the first; the second is dropped.
        let left = [Some(region(9.0)), None, None, Some(region(4.0)), None];
        partition.replace(left.to_vec(), &[0, 1, 0, 3, 2]);
        assert_eq!(partition.owner, [0, NONE, 0, 1, 0, NONE]);
        let sizes: Vec<f64> = partition.regions.iter().map(|r| r.moments.n).collect();
        assert_eq!(sizes, [9.0, 4.0]);
        partition.retain(|_, region| region.moments.n < 9.0);
        assert_eq!(partition.owner, [NONE, NONE, NONE, 0, NONE, NONE]);
    }
}
