//! Which region each cell belongs to.

use super::moments::Moments;
use crate::extraction::Segmentation;

/// The region of a cell without one.
pub(crate) const NONE: u16 = Segmentation::NONE;

/// What is known of cells that share a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region<M: Moments> {
    pub moments: M,
    pub plane: M::Plane,
}

/// A region, and the indices of its cells in the lattice that it was grown over.
pub(crate) struct Grown<M: Moments> {
    pub region: Region<M>,
    pub cells: Vec<usize>,
}

/// Regions, and the cells of each.
pub(crate) struct Partition<M: Moments> {
    pub regions: Vec<Region<M>>,
    /// Index of the region of each cell, or [`NONE`].
    pub owner: Vec<u16>,
}

impl<M: Moments> Default for Partition<M> {
    fn default() -> Self {
        Self {
            regions: Vec::new(),
            owner: Vec::new(),
        }
    }
}

impl<M: Moments> Partition<M> {
    /// Adds a region of cells that have none. Numbers are 16 bits: of more regions (an image of many
    /// megapixels) the first are kept.
    pub fn add(&mut self, grown: Grown<M>) {
        let number = self.regions.len() as u16;
        if self.regions.len() < usize::from(NONE) {
            grown
                .cells
                .into_iter()
                .for_each(|cell| self.owner[cell] = number);
            self.regions.push(grown.region);
        }
    }

    /// Leaves the regions for which `stays` holds; the cells of the others have none then.
    pub fn retain(&mut self, stays: impl Fn(usize, &Region<M>) -> bool) {
        let left = self.regions.iter().enumerate();
        let left = left.map(|(i, region)| stays(i, region).then_some(*region));
        let own: Vec<u16> = (0..).take(self.regions.len()).collect();
        self.replace(left.collect(), &own);
    }

    /// Puts other regions in the place of those that there are. The cells of one that is no more go to
    /// the one with the smaller index that `into` says; to none where that is its own.
    pub fn replace(&mut self, regions: Vec<Option<Region<M>>>, into: &[u16]) {
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

    /// A number of points, and no plane.
    #[derive(Clone, Copy, Default)]
    struct Count(f64);

    impl Moments for Count {
        type Plane = ();
        fn add(&mut self, other: &Self, weight: f64) {
            self.0 += weight * other.0;
        }
        fn count(&self) -> f64 {
            self.0
        }
        fn plane(&self) -> Option<()> {
            Some(())
        }
        fn mean_square(&self, (): &()) -> f64 {
            0.0
        }
    }

    #[test]
    fn cells_of_a_region_that_is_no_more_go_where_it_went() {
        let region = |n: f64| Region {
            moments: Count(n),
            plane: (),
        };
        let mut partition = Partition {
            regions: [1.0, 2.0, 3.0, 4.0, 5.0].map(region).to_vec(),
            owner: vec![0, 1, 2, 3, 4, NONE],
        };
        // The last goes to the third, which went to the first; the second is dropped.
        let left = [Some(region(9.0)), None, None, Some(region(4.0)), None];
        partition.replace(left.to_vec(), &[0, 1, 0, 3, 2]);
        assert_eq!(partition.owner, [0, NONE, 0, 1, 0, NONE]);
        let sizes: Vec<f64> = partition.regions.iter().map(|r| r.moments.0).collect();
        assert_eq!(sizes, [9.0, 4.0]);
        partition.retain(|_, region| region.moments.0 < 9.0);
        assert_eq!(partition.owner, [NONE, NONE, NONE, 0, NONE, NONE]);
    }
}
