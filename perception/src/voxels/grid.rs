//! Points in voxels of several sizes, found by hashing.

use std::ops::Range;

use nalgebra::Vector3;

use super::moments::Moments;

/// A place in a table that holds nothing.
pub(super) const NONE: u32 = u32::MAX;

/// Offset that keeps the coordinates of voxels positive: 21 bits each.
const HALF: i64 = 1 << 20;

/// Places of a table at first.
const TABLE_MIN: usize = 1 << 12;

/// From a voxel's coordinates to its number, by open addressing. Numbers are given in the order of
/// insertion and looked up only, so nothing depends on the order of the table.
struct Index {
    slots: Vec<(u64, u32)>,
    shift: u32,
    count: u32,
}

impl Index {
    /// A table of so many places, a power of two.
    fn new(size: usize) -> Self {
        Self {
            slots: vec![(0, NONE); size],
            shift: 64 - size.ilog2(),
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

    /// The number of a voxel; the next one for a new voxel.
    fn insert(&mut self, key: u64) -> u32 {
        let slot = self.slot(key);
        if self.slots[slot].1 != NONE {
            return self.slots[slot].1;
        }
        let number = self.count;
        self.slots[slot] = (key, number);
        self.count += 1;
        if 2 * self.count as usize > self.slots.len() {
            // Room for the voxels there are, not for one a point: most points share theirs.
            let mut larger = Self::new(2 * self.slots.len());
            for &(key, number) in self.slots.iter().filter(|(_, number)| *number != NONE) {
                let slot = larger.slot(key);
                larger.slots[slot] = (key, number);
            }
            self.slots = larger.slots;
            self.shift = larger.shift;
        }
        number
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
    /// The points in order, those after each other that share their smallest voxel together, and its number.
    pub runs: Vec<(Range<u32>, u32)>,
}

/// A key of 21 bits an axis, z first.
fn packed([x, y, z]: [i64; 3]) -> u64 {
    ((z as u64) << 42) | ((y as u64) << 21) | x as u64
}

/// The key of the voxel of a point, in sides of a voxel.
fn key(p: &Vector3<f64>) -> u64 {
    // In the lowest bits of 2⁵² + n is n: to convert takes much longer.
    let (least, most) = (1.0 - HALF as f64, HALF as f64 - 2.0);
    let place = p.map(|c| c.floor().clamp(least, most) + (HALF as f64 + (1_u64 << 52) as f64));
    packed(
        place
            .map(|c| (c.to_bits() & (2 * HALF as u64 - 1)) as i64)
            .into(),
    )
}

fn unpacked(key: u64) -> [i64; 3] {
    [key, key >> 21, key >> 42].map(|bits| (bits & ((1 << 21) - 1)) as i64)
}

impl Grid {
    /// The voxels of the points about the origin.
    pub fn new(
        mut points: impl Iterator<Item = Vector3<f64>> + Clone,
        leaf_m: f64,
        levels: usize,
    ) -> Self {
        let count = levels.max(1);
        let per_m = 1.0 / leaf_m;
        let of_point: Vec<u64> = points.clone().map(|p| key(&(p * per_m))).collect();
        let mut index = Index::new(TABLE_MIN);
        let (mut cells, mut keys) = (Vec::<Moments>::new(), Vec::new());
        let (mut runs, mut start) = (Vec::new(), 0);
        for alike in of_point.chunk_by(u64::eq) {
            let number = index.insert(alike[0]);
            if number as usize == cells.len() {
                cells.push(Moments::default());
                keys.push(alike[0]);
            }
            let mut moments = cells[number as usize];
            let its = points.by_ref().take(alike.len());
            its.for_each(|p| moments.push(&p, 1.0));
            cells[number as usize] = moments;
            let end = start + alike.len() as u32;
            runs.push((start..end, number));
            start = end;
        }
        // Each size from the one before.
        let mut levels = Vec::with_capacity(count);
        let mut side_m = leaf_m;
        let mut all_keys = Vec::with_capacity(count);
        for _ in 1..count {
            let (mut upper, mut upper_keys) = (Vec::new(), Vec::new());
            let mut parents = Vec::with_capacity(keys.len());
            let mut upper_index = Index::new(TABLE_MIN);
            for (key, cell) in keys.iter().zip(&cells) {
                let key = packed(unpacked(*key).map(|c| c >> 1));
                let number = upper_index.insert(key);
                if number as usize == upper.len() {
                    upper.push(Moments::default());
                    upper_keys.push(key);
                }
                upper[number as usize].add(cell, 1.0);
                parents.push(number);
            }
            levels.push(Level {
                side_m,
                cells,
                parents,
                around: Vec::new(),
            });
            all_keys.push(keys);
            (cells, keys, index) = (upper, upper_keys, upper_index);
            side_m *= 2.0;
        }
        // The largest are looked up; of the others their parents tell which are around.
        let around = looked_up(&keys, &index);
        levels.push(Level {
            side_m,
            cells,
            parents: Vec::new(),
            around,
        });
        for (i, keys) in all_keys.iter().enumerate().rev() {
            levels[i].around = among_children(keys, &levels[i].parents, &levels[i + 1].around);
        }
        Self { levels, runs }
    }
}

/// The 26 voxels around one, as offsets along the axes, x first.
fn offsets() -> impl Iterator<Item = [i64; 3]> {
    let all = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9].map(|d| d - 1));
    all.filter(|offset| *offset != [0; 3])
}

/// The voxels around each, by their keys.
fn looked_up(keys: &[u64], index: &Index) -> Vec<[u32; 26]> {
    let around = |key: &u64| {
        let [x, y, z] = unpacked(*key);
        let mut around = [NONE; 26];
        for (found, [dx, dy, dz]) in around.iter_mut().zip(offsets()) {
            *found = index.get(packed([x + dx, y + dy, z + dz]));
        }
        around
    };
    keys.iter().map(around).collect()
}

/// The voxels around each: children of its parent, or of the voxels around that.
fn among_children(keys: &[u64], parents: &[u32], upper: &[[u32; 26]]) -> Vec<[u32; 26]> {
    let eighth = |[x, y, z]: [i64; 3]| (x & 1 | (y & 1) << 1 | (z & 1) << 2) as usize;
    // Of each voxel of the size above its eighths; one more has none.
    let mut children = vec![[NONE; 8]; upper.len() + 1];
    for ((number, key), &parent) in (0..).zip(keys).zip(parents) {
        children[parent as usize][eighth(unpacked(*key))] = number;
    }
    // For a voxel that is a certain eighth: in which one around the parent, which eighth; in the parent
    // itself the last.
    let places: [[(usize, usize); 26]; 8] = std::array::from_fn(|own| {
        let mut places = [(0, 0); 26];
        for (place, offset) in places.iter_mut().zip(offsets()) {
            let at: [i64; 3] = std::array::from_fn(|k| (own as i64 >> k & 1) + offset[k]);
            let parent = at.map(|c| c >> 1);
            let number = offsets().position(|offset| offset == parent);
            *place = (number.unwrap_or(26), eighth(at));
        }
        places
    });
    let around = |(key, &parent): (&u64, &u32)| {
        let mut near = [&children[parent as usize]; 27];
        for (near, &number) in near.iter_mut().zip(&upper[parent as usize]) {
            *near = &children[(number as usize).min(upper.len())];
        }
        let mut around = [NONE; 26];
        for (around, &(number, eighth)) in around.iter_mut().zip(&places[eighth(unpacked(*key))]) {
            *around = near[number][eighth];
        }
        around
    };
    keys.iter().zip(parents).map(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_as_the_table_grows() {
        let mut index = Index::new(TABLE_MIN);
        let keys: Vec<u64> = (1..4 * TABLE_MIN as u64).map(|k| (k * k) << 9).collect();
        for _ in 0..2 {
            let numbers = keys.iter().map(|key| index.insert(*key));
            assert!(numbers.eq(0..keys.len() as u32));
        }
        assert!(
            keys.iter()
                .map(|key| index.get(*key))
                .eq(0..keys.len() as u32)
        );
        assert_eq!(index.get(3), NONE);
        assert!(2 * keys.len() <= index.slots.len());
    }

    #[test]
    fn keys_are_of_the_integers_below() {
        let far = HALF as f64;
        for x in [
            -1e9,
            -far,
            -2.5,
            -2.0,
            -0.0,
            0.3,
            7.0,
            7.999,
            far - 2.0,
            far,
            1e300,
        ] {
            let expected = ((x.floor() as i64).saturating_add(HALF)).clamp(1, 2 * HALF - 2);
            for (p, at) in [
                ([x, 0.5, -0.5], 0),
                ([0.5, x, -0.5], 1),
                ([0.5, -0.5, x], 2),
            ] {
                assert_eq!(unpacked(key(&p.into()))[at], expected, "{x}");
            }
        }
    }

    #[test]
    fn every_point_is_in_one_voxel_of_every_size_and_all_around_it_are_found() {
        let points: Vec<Vector3<f64>> = (0..500)
            .map(|i| {
                let t = f64::from(i);
                Vector3::new((t * 0.37).sin(), (t * 0.73).cos(), 0.3 * (t * 0.11).sin())
            })
            .collect();
        let grid = Grid::new(points.iter().copied(), 0.05, 4);
        assert_eq!(grid.levels.len(), 4);
        for level in &grid.levels {
            let n: f64 = level.cells.iter().map(|c| c.n).sum();
            assert_eq!(n, 500.0);
            let place = |cell: &Moments| cell.mean().map(|c| (c / level.side_m).floor());
            for (i, around) in level.around.iter().enumerate() {
                let own = place(&level.cells[i]);
                let beside = |cell: &Moments| (place(cell) - own).amax() == 1.0;
                let cells = (0..).zip(&level.cells);
                let expected = cells.filter(|(_, cell)| beside(cell)).map(|(k, _)| k);
                let expected: Vec<u32> = expected.collect();
                let mut found: Vec<u32> = around.iter().copied().filter(|k| *k != NONE).collect();
                found.sort_unstable();
                assert_eq!(found, expected);
                // Each where it is: the other way it is in the place opposite.
                for (k, &other) in around.iter().enumerate().filter(|(_, k)| **k != NONE) {
                    assert_eq!(level.around[other as usize][25 - k], i as u32);
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
