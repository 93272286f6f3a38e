//! Cells at the border of two regions go to the plane that fits them better.
//!
//! A region that grows first takes what its plane still explains: the foot of a ramp runs out onto
//! the floor, and what it took there tilts its plane, which then explains more. Each exchange makes
//! both planes truer, and is followed by another until there is none.

use super::cell::CellNoise;
use super::growth::{FREE, GrowthConfig, Region, owners};
use super::image::Grid;
use crate::sensor::Noise;

/// A border moves by one cell a sweep; few move by more than this.
const SWEEPS: usize = 24;

/// Gives cells of regions (on the grid) to side neighbours whose planes fit them better, refits the
/// planes and goes on around the cells that moved, as long as there are any.
pub(super) fn exchange(
    grid: &Grid,
    mut regions: Vec<Region>,
    noise: &Noise,
    config: &GrowthConfig,
) -> Vec<Region> {
    let mut owner = owners(grid, &regions);
    // Cells beside another region's.
    let mut border = Vec::new();
    let differ = |a: u32, b: u32| (a != b) & (a != FREE) & (b != FREE);
    for (here, y) in owner.chunks_exact(grid.cols.max(1)).zip(0..) {
        let start = y * grid.cols;
        for (pair, i) in here.windows(2).zip(start..) {
            if differ(pair[0], pair[1]) {
                border.extend([i, i + 1]);
            }
        }
        let below = owner.get(start + grid.cols..).unwrap_or_default();
        for ((a, b), i) in here.iter().zip(below).zip(start..) {
            if differ(*a, *b) {
                border.extend([i, i + grid.cols]);
            }
        }
    }
    let mut changed = vec![false; regions.len()];
    for _ in 0..SWEEPS {
        border.sort_unstable();
        border.dedup();
        changed.fill(false);
        let mut next = Vec::new();
        for &i in &border {
            let cell = &grid.cells[i];
            let own = owner[i];
            // Without a neighbour that fits better it stays where it is.
            let mut best = (cell.mean_square(&regions[own as usize].plane), own);
            for other in grid.beside(i).map(|k| owner[k]) {
                if other != FREE && other != own && other != best.1 {
                    let misfit = cell.mean_square(&regions[other as usize].plane);
                    best = if misfit < best.0 {
                        (misfit, other)
                    } else {
                        best
                    };
                }
            }
            let noise = CellNoise::at(noise, cell.mean());
            if best.1 == own || best.0 > config.planar(&noise) + config.misfit(&noise) {
                continue;
            }
            owner[i] = best.1;
            regions[own as usize].moments.add(cell, -1.0);
            regions[best.1 as usize].moments.add(cell, 1.0);
            (changed[own as usize], changed[best.1 as usize]) = (true, true);
            next.push(i);
            next.extend(grid.beside(i).iter().filter(|k| owner[**k] != FREE));
        }
        if !changed.contains(&true) {
            break;
        }
        for (region, _) in regions.iter_mut().zip(&changed).filter(|(_, c)| **c) {
            region.plane = region.moments.plane().unwrap_or(region.plane);
        }
        border = next;
    }
    regions.iter_mut().for_each(|region| region.cells.clear());
    for (i, &o) in owner.iter().enumerate().filter(|(_, o)| **o != FREE) {
        regions[o as usize].cells.push(i);
    }
    regions.retain(|region| !region.cells.is_empty());
    regions
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::image::InverseImage;
    use crate::scan::Intrinsics;
    use crate::sensor::Sensor;

    #[test]
    fn a_border_moves_to_where_the_planes_meet() {
        // Two planes that meet between columns 11 and 12 of the cells; the first has taken four
        // columns too many.
        let (width, height) = (96, 48);
        let w = |u: usize| 0.5 + 0.001 * (u as f64 - 48.0).max(0.0);
        let pixels = (0..height).flat_map(|_| 0..width);
        let image = InverseImage {
            width,
            height,
            w: pixels.map(|u| w(u) as f32).collect(),
            intrinsics: Intrinsics {
                fx: 525.0,
                fy: 525.0,
                cx: 48.0,
                cy: 24.0,
            },
            centre: (48.0, 24.0),
        };
        let grid = Grid::new(&image, Vec::new());
        let region = |columns: std::ops::Range<usize>| {
            let cells: Vec<usize> = (0..grid.cells.len())
                .filter(|i| columns.contains(&(i % grid.cols)))
                .collect();
            let mut moments = crate::organised::moments::Moments::default();
            cells.iter().for_each(|&i| moments.add(&grid.cells[i], 1.0));
            Region {
                moments,
                plane: moments.plane().unwrap(),
                cells,
            }
        };
        let noise = Sensor::named("xtion").unwrap().noise;
        let regions = vec![region(0..16), region(16..24)];
        let exchanged = exchange(&grid, regions, &noise, &GrowthConfig::default());
        let columns = |r: usize| {
            let columns = exchanged[r].cells.iter().map(|i| i % grid.cols);
            (columns.clone().min().unwrap(), columns.max().unwrap())
        };
        assert_eq!((columns(0), columns(1)), ((0, 11), (12, 23)));
        assert!(exchanged[0].plane.0.x.abs() < 1e-6, "{:?}", exchanged[0]);
    }
}
