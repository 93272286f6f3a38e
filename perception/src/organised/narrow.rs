//! Faces that are narrower than a block of cells: legs, rails, bars.

use super::growth::{Grown, Growth};
use super::labels::{NONE, limit};
use super::partition::Partition;
use super::seed::Shape;
use crate::sensor::Noise;

/// The regions that grow from strips over the cells that are left beside those `known`, and stand out.
///
/// A narrow face beside a larger one, the front of a board, say, cannot be told from the noise of
/// that one's edge: what the plane beside it may claim as well is no face of its own.
pub(super) fn found(growth: &mut Growth, known: &Partition, noise: &Noise) -> Vec<Grown> {
    let (grid, length) = (growth.grid, growth.config.strip_cells);
    let along = Shape {
        cols: length,
        rows: 1,
    };
    let down = Shape {
        cols: 1,
        rows: length,
    };
    let mut narrow = growth.regions(&[along, down], growth.config.strip_pixels_min);
    let claimed = |&cell: &usize| {
        let moments = &grid.cells[cell];
        let limit = limit(moments.mean(), noise);
        let beside = grid.beside(cell).map(|k| known.owner[k]);
        let mut beside = beside.iter().filter(|o| **o != NONE);
        beside.any(|o| moments.mean_square(&known.regions[usize::from(*o)].plane) < limit)
    };
    narrow.retain(|region| {
        let count = region.cells.iter().filter(|cell| claimed(cell)).count();
        2 * count < region.cells.len()
    });
    narrow
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::growth::GrowthConfig;
    use crate::organised::image::tests::grid_of;
    use crate::sensor::Sensor;

    /// Of an image of depths the regions that grow from blocks, and how many narrow ones are found.
    fn regions(z: impl Fn(usize, usize) -> f64) -> (Partition, usize) {
        let noise = Sensor::named("xtion").unwrap().noise;
        let config = GrowthConfig::default();
        let grid = grid_of(z);
        let mut growth = Growth::new(&grid, |_| true, &noise, &config);
        let mut known = Partition::new(&grid);
        let blocks = growth.regions(&[Shape::BLOCK], config.pixels_min);
        blocks.into_iter().for_each(|block| known.add(block));
        let narrow = found(&mut growth, &known, &noise).len();
        (known, narrow)
    }

    #[test]
    fn a_leg_before_a_wall_is_a_face() {
        // 7 px wide, 0.5 m before the wall.
        let leg = |u: usize, _: usize| if (80..87).contains(&u) { 1.5 } else { 2.0 };
        let (known, narrow) = regions(leg);
        assert_eq!((known.regions.len(), narrow), (2, 1));
    }

    #[test]
    fn the_front_of_a_board_is_a_part_of_its_edge() {
        // A board seen at 45°, its front 10 px (3 cm) high, and a wall behind.
        let depth = |v: usize| 882.0 / (v as f64 + 440.0);
        let front = |with_board: bool| {
            move |_: usize, v: usize| match v {
                40..80 if with_board => depth(v),
                80..90 => depth(79),
                _ => 3.0,
            }
        };
        let (known, narrow) = regions(front(true));
        assert_eq!((known.regions.len(), narrow), (3, 0));
        // The board has not grown over it, and by itself it is a face.
        assert_eq!(known.owner[21 * 40 + 20], NONE);
        assert_eq!(regions(front(false)).1, 1);
    }
}
