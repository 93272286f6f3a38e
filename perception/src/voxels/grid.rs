//! Points in voxels of several sizes, found by hashing.

use nalgebra::Vector3;

use super::moments::Moments;

/// A place in a table that holds nothing.
pub(super) const NONE: u32 = u32::MAX;

/// Offset that keeps the coordinates of voxels positive: 21 bits each.
const HALF: i64 = 1 << 20;

/// From a voxel's coordinates to its number, by open addressing. Numbers are given in the order of
/// insertion and looked up only, so nothing depends on the order of the table.
struct Index {
    slots: Vec<(u64, u32)>,
    shift: u32,
    count: u32,
}

impl Index {
    /// A table for so many voxels at most.
    fn new(most: usize) -> Self {
        let bits = usize::BITS - (2 * most.max(8)).leading_zeros();
        Self {
            slots: vec![(0, NONE); 1 << bits],
            shift: 64 - bits,
            count: 0,
        }
    }

    /// The slot of a key, or the empty one that it would take.
    fn slot(&self, key: u64) -> usize {
        // Fibonacci hashing: the high bits of the product with 2⁶⁴/φ.
        let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift) as usize;
        while self.slots[at].1 != NONE && self.slots[at].0 != key {
            at = (at + 1) & (self.slots.len() - 1);
        }
        at
    }

    fn get(&self, key: u64) -> u32 {
        self.slots[self.slot(key)].1
    }

    fn insert(&mut self, key: u64) -> u32 {
        let slot = self.slot(key);
        if self.slots[slot].1 == NONE {
            self.slots[slot] = (key, self.count);
            self.count += 1;
        }
        self.slots[slot].1
    }
}

/// Voxels of one size.
pub(super) struct Level {
    /// Side, m.
    pub side_m: f64,
    /// Moments of each voxel's points.
    pub cells: Vec<Moments>,
    /// Number of the voxel of the next level in which each lies; empty at the last.
    pub parents: Vec<u32>,
    /// The (up to 26) voxels around each, [`NONE`] where there is none.
    pub around: Vec<[u32; 26]>,
}

/// Voxels of sides h, 2h, 4h …, and the smallest one of every point.
pub(super) struct Grid {
    /// The smallest first.
    pub levels: Vec<Level>,
    /// Number of each point's smallest voxel.
    pub of_point: Vec<u32>,
}

/// A key of 21 bits an axis, z first.
fn packed([x, y, z]: [i64; 3]) -> u64 {
    ((z as u64) << 42) | ((y as u64) << 21) | x as u64
}

fn unpacked(key: u64) -> [i64; 3] {
    [key, key >> 21, key >> 42].map(|bits| (bits & ((1 << 21) - 1)) as i64)
}

impl Grid {
    /// The voxels of the points about the origin.
    pub fn new(points: &[Vector3<f64>], leaf_m: f64, levels: usize) -> Self {
        let mut index = Index::new(points.len());
        let mut cells: Vec<Moments> = Vec::new();
        let mut keys = Vec::new();
        let per_m = 1.0 / leaf_m;
        let of_point = points
            .iter()
            .map(|p| {
                let place = [p.x, p.y, p.z].map(|c| {
                    let cell = (c * per_m).floor() as i64 + HALF;
                    cell.clamp(1, 2 * HALF - 2)
                });
                let key = packed(place);
                let number = index.insert(key);
                if number as usize == cells.len() {
                    cells.push(Moments::default());
                    keys.push(key);
                }
                cells[number as usize].push(p, 1.0);
                number
            })
            .collect();
        let mut grid = Self {
            levels: Vec::new(),
            of_point,
        };
        let mut side_m = leaf_m;
        for level in 0..levels.max(1) {
            let around = around(&keys, &index);
            let last = level + 1 == levels.max(1);
            let (mut upper, mut upper_keys) = (Vec::new(), Vec::new());
            let mut parents = Vec::new();
            let mut upper_index = Index::new(if last { 1 } else { keys.len() });
            if !last {
                for (key, cell) in keys.iter().zip(&cells) {
                    let key = packed(unpacked(*key).map(|c| c >> 1));
                    let number = upper_index.insert(key);
                    if number as usize == upper.len() {
                        upper.push(Moments::default());
                        upper_keys.push(key);
                    }
                    upper[number as usize].add(cell);
                    parents.push(number);
                }
            }
            grid.levels.push(Level {
                side_m,
                cells,
                parents,
                around,
            });
            (cells, keys, index) = (upper, upper_keys, upper_index);
            side_m *= 2.0;
        }
        grid
    }
}

/// The voxels around each.
fn around(keys: &[u64], index: &Index) -> Vec<[u32; 26]> {
    keys.iter()
        .map(|&key| {
            let [x, y, z] = unpacked(key);
            let mut found = [NONE; 26];
            let mut k = 0;
            for dz in -1..=1 {
                for dy in -1..=1 {
                    for dx in -1..=1 {
                        if (dx, dy, dz) != (0, 0, 0) {
                            found[k] = index.get(packed([x + dx, y + dy, z + dz]));
                            k += 1;
                        }
                    }
                }
            }
            found
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_in_one_voxel_of_every_size_and_neighbours_are_mutual() {
        let points: Vec<Vector3<f64>> = (0..500)
            .map(|i| {
                let t = f64::from(i);
                Vector3::new((t * 0.37).sin(), (t * 0.73).cos(), 0.3 * (t * 0.11).sin())
            })
            .collect();
        let grid = Grid::new(&points, 0.05, 4);
        assert_eq!(grid.levels.len(), 4);
        for level in &grid.levels {
            let n: f64 = level.cells.iter().map(|c| c.n).sum();
            assert_eq!(n, 500.0);
            for (i, around) in level.around.iter().enumerate() {
                for &k in around.iter().filter(|k| **k != NONE) {
                    assert!(level.around[k as usize].contains(&(i as u32)));
                    let apart = level.cells[i].mean() - level.cells[k as usize].mean();
                    assert!(apart.amax() <= 2.0 * level.side_m + 1e-9);
                }
            }
        }
        for pair in grid.levels.windows(2) {
            for (cell, &parent) in pair[0].cells.iter().zip(&pair[0].parents) {
                let apart = cell.mean() - pair[1].cells[parent as usize].mean();
                assert!(apart.amax() <= pair[1].side_m);
            }
        }
    }
}
