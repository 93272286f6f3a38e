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
    let mut small: Vec<bool> = regions.iter().map(is_small).collect();
    // No region is not a small one.
    small.push(false);
    let is_small = |own: u16| small[usize::from(own).min(regions.len())];
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
    let stays = |i: usize| !small[i] || excess[i] < 0;
    if !(0..regions.len()).all(stays) {
        let left = (0..).zip(regions);
        let left = left.map(|(i, region)| stays(i).then_some(*region));
        let own: Vec<u16> = (0..).take(regions.len()).collect();
        partition.replace(left.collect(), &own);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::growth::Growth;
    use crate::organised::image::InverseImage;
    use crate::organised::seed::Shape;
    use crate::scan::{DepthImage, Intrinsics};
    use crate::sensor::Sensor;

    /// Regions of an image of depths: all that grow, and those that stand out.
    fn regions(z: impl Fn(usize, usize) -> f64) -> (usize, usize) {
        let (width, height) = (160, 120);
        let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let depth = DepthImage {
            width,
            height,
            z_m: pixels.map(|(u, v)| z(u, v) as f32).collect(),
            intrinsics: Intrinsics {
                fx: 525.0,
                fy: 525.0,
                cx: 80.0,
                cy: 60.0,
            },
        };
        let noise = Sensor::named("xtion").unwrap().noise;
        let config = GrowthConfig::default();
        let (image, ..) = InverseImage::new(&depth, 10.0, Vec::new());
        let (grid, _) = Grid::both(&image, Default::default());
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
