//! Cells at the border of two regions go to the plane that fits them better.
//!
//! A region that grows first takes what its plane still explains: the foot of a ramp runs out onto
//! the floor, and what it took there tilts its plane, which then explains more. Each exchange makes
//! both planes truer, and is followed by another until there is none.

use super::bits::{Bits, on_left};
use super::cell::CellNoise;
use super::growth::GrowthConfig;
use super::image::Grid;
use super::labels::NONE;
use super::partition::Partition;
use super::words::pack;
use crate::sensor::Noise;

/// A border moves by one cell a sweep; few move by more than this.
const SWEEPS: usize = 24;

/// Gives cells of regions to side neighbours whose planes fit them better, refits the planes and goes
/// on around the cells that moved, as long as there are any.
pub(super) fn exchange(
    grid: &Grid,
    partition: &mut Partition,
    noise: &Noise,
    config: &GrowthConfig,
) {
    let Partition { regions, owner } = partition;
    let mut border = border(owner, grid.cols, grid.rows);
    let mut changed = vec![false; regions.len()];
    for _ in 0..SWEEPS {
        changed.fill(false);
        let mut next = Bits::empty(grid.cols, grid.rows);
        border.for_each(|x, y| {
            let i = y * grid.cols + x;
            let cell = &grid.cells[i];
            let own = owner[i];
            let beside = grid.beside(i);
            // Without a neighbour that fits better it stays where it is.
            let square = |region: u16| cell.mean_square(&regions[usize::from(region)].plane);
            let mut best = (None, own);
            for other in beside.map(|k| owner[k]) {
                if other != NONE && other != own && other != best.1 {
                    let least = *best.0.get_or_insert_with(|| square(own));
                    let misfit = square(other);
                    if misfit < least {
                        best = (Some(misfit), other);
                    }
                }
            }
            let (Some(misfit), to) = best else { return };
            let noise = CellNoise::at(noise, cell.mean());
            if to == own || misfit > config.planar(&noise) + config.misfit(&noise) {
                return;
            }
            owner[i] = to;
            let (from, to) = (usize::from(own), usize::from(to));
            regions[from].moments.add(cell, -1.0);
            regions[to].moments.add(cell, 1.0);
            (changed[from], changed[to]) = (true, true);
            next.set(x, y);
            for k in beside.into_iter().filter(|k| owner[*k] != NONE) {
                let (x, y) = grid.place(k);
                next.set(x, y);
            }
        });
        if !changed.contains(&true) {
            break;
        }
        for (region, _) in regions.iter_mut().zip(&changed).filter(|(_, c)| **c) {
            region.plane = region.moments.plane().unwrap_or(region.plane);
        }
        border = next;
    }
    // What has no cell left is no region.
    partition.retain(|_, region| region.moments.n >= 1.0);
}

/// The cells beside another region's.
fn border(owner: &[u16], cols: usize, rows: usize) -> Bits {
    let differ = |a: u16, b: u16| (a != b) & (a != NONE) & (b != NONE);
    let line = |y: usize| &owner[y * cols..][..cols];
    let right = Bits::new(cols, rows, |y, words| {
        pack(line(y), &line(y)[1.min(cols)..], words, differ);
    });
    let below = Bits::new(cols, rows, |y, words| {
        if y + 1 < rows {
            pack(line(y), line(y + 1), words, differ);
        }
    });
    Bits::around([&right, &below], |[right, below]| {
        right[1][1] | on_left(right[1]) | below[0][1] | below[1][1]
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::growth::{Grown, Region};
    use crate::organised::image::InverseImage;
    use crate::organised::moments::Moments;
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
        let (grid, _) = Grid::both(&image, Default::default());
        let mut partition = Partition::new(&grid);
        for columns in [0..16, 16..24] {
            let cells: Vec<usize> = (0..grid.cells.len())
                .filter(|i| columns.contains(&(i % grid.cols)))
                .collect();
            let mut moments = Moments::default();
            cells.iter().for_each(|&i| moments.add(&grid.cells[i], 1.0));
            let plane = moments.plane().unwrap();
            let region = Region { moments, plane };
            partition.add(Grown { region, cells });
        }
        let noise = Sensor::named("xtion").unwrap().noise;
        exchange(&grid, &mut partition, &noise, &GrowthConfig::default());
        let columns = |r: u16| {
            let cells = (0..grid.cells.len()).filter(|i| partition.owner[*i] == r);
            let columns = cells.map(|i| i % grid.cols);
            (columns.clone().min().unwrap(), columns.max().unwrap())
        };
        assert_eq!((columns(0), columns(1)), ((0, 11), (12, 23)));
        let first = &partition.regions[0];
        assert!(first.plane.0.x.abs() < 1e-6, "{first:?}");
    }
}
