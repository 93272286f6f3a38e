//! Regions that the planes around them explain.

use super::cell::CellNoise;
use super::growth::{GrowthConfig, Region};
use super::image::Grid;
use super::labels::NONE;
use super::partition::Partition;
use crate::sensor::Noise;

/// Drops the regions of fewer than `claimed_pixels_max` pixels that do not stand out: those of which
/// half of the cells at least lie on planes of the regions beside theirs, as planar cells that these
/// could have grown over.
///
/// A sliver along the crease of two faces cannot be told from the noise of the faces that meet there.
/// The limit is that of growth, not the wider one of pixels: a plate of 2 cm on a floor is to stay.
pub(super) fn drop_claimed(
    grid: &Grid,
    partition: &mut Partition,
    noise: &Noise,
    config: &GrowthConfig,
) {
    let Partition { regions, owner } = &*partition;
    let is_small = |region: &Region| region.moments.n < config.claimed_pixels_max as f64;
    let small: Vec<bool> = regions.iter().map(is_small).collect();
    let is_small = |own: u16| small.get(usize::from(own)) == Some(&true);
    let cells = (0..).zip(owner.iter().copied());
    let cells: Vec<(usize, u16)> = cells.filter(|(_, own)| is_small(*own)).collect();
    let mut around: Vec<Vec<u16>> = vec![Vec::new(); regions.len()];
    for &(cell, own) in &cells {
        let around = &mut around[usize::from(own)];
        for other in grid.beside(cell).map(|k| owner[k]) {
            if other != NONE && other != own && !around.contains(&other) {
                around.push(other);
            }
        }
    }
    // How many more cells of each are claimed than are not.
    let mut excess = vec![0_i32; regions.len()];
    for (cell, own) in cells {
        let moments = &grid.cells[cell];
        let noise = CellNoise::at(noise, moments.mean());
        let limit = config.planar(&noise) + config.misfit(&noise);
        let explains = |o: &u16| moments.mean_square(&regions[usize::from(*o)].plane) < limit;
        let is_claimed = around[usize::from(own)].iter().any(explains);
        excess[usize::from(own)] += if is_claimed { 1 } else { -1 };
    }
    partition.retain(|i, _| !small[i] || excess[i] < 0);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::growth::Growth;
    use crate::organised::image::tests::grid_of;
    use crate::organised::seed::Shape;
    use crate::sensor::Sensor;

    /// Regions of an image of depths: all that grow, and those that stand out.
    fn regions(z: impl Fn(usize, usize) -> f64) -> (usize, usize) {
        let noise = Sensor::named("xtion").unwrap().noise;
        let config = GrowthConfig::default();
        let grid = grid_of(z);
        let mut growth = Growth::new(&grid, |_| true, &noise, &config);
        let mut partition = Partition::new(&grid);
        let blocks = growth.regions(&[Shape::BLOCK], config.pixels_min);
        blocks.into_iter().for_each(|grown| partition.add(grown));
        let all = partition.regions.len();
        drop_claimed(&grid, &mut partition, &noise, &config);
        (all, partition.regions.len())
    }

    #[test]
    fn a_small_plate_stands_out_where_cells_do() {
        // A plate before a wall, nearer by so much of inverse depth.
        let plate = |by: f64| {
            move |u: usize, v: usize| {
                let is_plate = (60..88).contains(&u) && (40..68).contains(&v);
                1.0 / (0.5 + if is_plate { by } else { 0.0 })
            }
        };
        let noise = CellNoise::at(&Sensor::named("xtion").unwrap().noise, 0.5);
        let config = GrowthConfig::default();
        let refused = config.misfit(&noise).sqrt();
        let stands_out = (config.planar(&noise) + config.misfit(&noise)).sqrt();
        assert_eq!(regions(plate(0.9 * refused)), (1, 1));
        assert_eq!(regions(plate(0.5 * (refused + stands_out))), (2, 1));
        assert_eq!(regions(plate(1.1 * stands_out)), (2, 2));
    }
}
