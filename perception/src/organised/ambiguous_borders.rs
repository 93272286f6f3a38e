//! Borders that may be anywhere, because the planes on both sides agree.

use super::bits::Bits;
use super::image::{CELL_PX, InverseImage};
use super::labels::CellLabels;
use super::moments::InversePlane;
use super::moments::Region;
use super::neighbourhood::Near;
use super::words::{between, packed};
use crate::segmentation::AMBIGUOUS_SYSTEMATICS;
use crate::sensor::Noise;

/// Takes off the sure pixels those where the plane of a neighbouring region is so close to theirs
/// that the slowly varying error may have drawn the border anywhere between: those within two
/// cells of both regions where both planes agree to [`AMBIGUOUS_SYSTEMATICS`] κ w.
pub(super) fn drop_ambiguous(
    image: &InverseImage,
    regions: &[Region],
    cells: &CellLabels,
    labels: &[u16],
    sure: &mut Bits,
    noise: &Noise,
) {
    let near = Near::all(&cells.0, image.width / CELL_PX, regions.len(), 2);
    let mut shared = Vec::new();
    for (j, b) in near.iter().enumerate() {
        for (i, a) in near[..j].iter().enumerate() {
            // The cells near both.
            shared.clear();
            shared.extend(a.shared(b));
            if shared.is_empty() {
                continue;
            }
            for (own, other) in [(i, j), (j, i)] {
                let ratio = AMBIGUOUS_SYSTEMATICS * noise.systematic_ratio;
                let wedge = Wedge::new(image, &regions[own].plane, &regions[other].plane, ratio);
                for &(y, k, cells) in &shared {
                    drop_in(image, own as u16, labels, &wedge, (y, k, cells), sure);
                }
            }
        }
    }
}

/// The same for the pixels of one region in the cells of a row: of 64 of them, the `k`th such word.
fn drop_in(
    image: &InverseImage,
    own: u16,
    labels: &[u16],
    wedge: &Wedge,
    (y, k, cells): (usize, usize, u64),
    sure: &mut Bits,
) {
    let rows = y * CELL_PX..(y + 1) * CELL_PX;
    let (a, b) = wedge.columns(rows.start, rows.end - 1);
    let cells = cells & between(a / CELL_PX, b.div_ceil(CELL_PX), k);
    // The pixels of 16 cells in a row are one word.
    for part in (0..CELL_PX).filter(|part| cells >> (16 * part) & 0xffff != 0) {
        let (i, columns) = (CELL_PX * k + part, spread(cells >> (16 * part) & 0xffff));
        for v in rows.clone() {
            let (a, b) = wedge.columns(v, v);
            let word = &mut sure.row_mut(v)[i];
            let doubtful = columns & between(a, b, i) & *word;
            if doubtful != 0 {
                let line = &labels[v * image.width..(v + 1) * image.width][64 * i..];
                let line = &line[..line.len().min(64)];
                *word &= !(doubtful & packed(line, line, |label, _| label == own));
            }
        }
    }
}

/// Each of 16 bits four times.
fn spread(bits: u64) -> u64 {
    let bits = (bits | bits << 24) & 0x0000_00ff_0000_00ff;
    let bits = (bits | bits << 12) & 0x000f_000f_000f_000f;
    let bits = (bits | bits << 6) & 0x0303_0303_0303_0303;
    let bits = (bits | bits << 3) & 0x1111_1111_1111_1111;
    bits * 0xf
}

/// The pixels where two planes agree: the differences are linear, so they lie between two lines.
struct Wedge {
    /// p u + q v + r > 0 on both.
    sides: [[f64; 3]; 2],
    width: f64,
}

impl Wedge {
    /// Where `other` is within `ratio` w of w, the inverse depth of `own`.
    fn new(image: &InverseImage, own: &InversePlane, other: &InversePlane, ratio: f64) -> Self {
        let side = |[p, q, r]: [f64; 3]| [p, q, r - p * image.centre.0 - q * image.centre.1];
        let (above, below) = (own.0 * (1.0 + ratio), own.0 * (1.0 - ratio));
        Self {
            sides: [(above - other.0).into(), (other.0 - below).into()].map(side),
            width: image.width as f64,
        }
    }

    /// The columns of a row that it holds, the first and one past the last; of several rows, no fewer
    /// than those of any.
    fn columns(&self, top: usize, bottom: usize) -> (usize, usize) {
        let (mut first, mut last) = (0.0_f64, self.width);
        for [p, q, r] in self.sides {
            let rest = r + (q * top as f64).max(q * bottom as f64);
            let u = -rest / p;
            if p < 0.0 {
                last = last.min(u);
            } else if p > 0.0 {
                first = first.max(u);
            } else if rest <= 0.0 {
                last = 0.0;
            }
        }
        // Between two columns the next one is the first; before the first it is that.
        let next = |u: f64| u as usize + usize::from(u > f64::from(u as u32));
        (next(first.min(self.width)), next(last))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::moments::Moments;
    use super::*;
    use crate::sensor::Intrinsics;
    use crate::sensor::SENSORS;

    #[test]
    fn pixels_near_two_planes_are_dropped_where_these_agree() {
        let (width, height) = (140, 40);
        let (cols, rows) = (width / CELL_PX, height / CELL_PX);
        let image = InverseImage {
            width,
            height,
            w: Vec::new(),
            intrinsics: Intrinsics {
                fx: 100.0,
                fy: 100.0,
                cx: 0.0,
                cy: 0.0,
            },
            centre: (70.0, 20.0),
        };
        // Two planes that meet in a line across the image, and a third one that is far from both.
        let plane = |a, b, c| InversePlane(Vector3::new(a, b, c));
        let planes = [
            plane(1.013e-4, 2.017e-4, 0.5003),
            plane(-2.031e-4, 4.019e-4, 0.5),
            plane(0.0, 0.0, 0.8),
        ];
        let region = |plane| Region {
            moments: Moments::default(),
            plane,
        };
        let regions = planes.map(region);
        let cell = |x: usize, y: usize| match (x, y) {
            (_, 0..4) => 0,
            (0..20, _) => 1,
            _ => 2,
        };
        let cells: Vec<u16> = (0..cols * rows).map(|i| cell(i % cols, i / cols)).collect();
        // Of the pixels every third is the other plane's.
        let label = |u: usize, v: usize| match cell(u / CELL_PX, v / CELL_PX) {
            2 => 2,
            own => own ^ u16::from((u + v).is_multiple_of(3)),
        };
        let at = |i: usize| (i % width, i / width);
        let labels: Vec<u16> = (0..width * height)
            .map(|i| label(at(i).0, at(i).1))
            .collect();
        let noise = &SENSORS[0].noise;
        let mut sure = Bits::empty(width, height).not();
        let found = CellLabels(cells);
        drop_ambiguous(&image, &regions, &found, &labels, &mut sure, noise);
        let near = |label: u16, u: usize, v: usize| {
            let (x, y) = (u / CELL_PX, v / CELL_PX);
            (0..cols * rows).any(|i| {
                let (a, b) = (i % cols, i / cols);
                cell(a, b) == label && a.abs_diff(x) <= 2 && b.abs_diff(y) <= 2
            })
        };
        let mut dropped = 0;
        for (i, &own) in labels.iter().enumerate() {
            let (u, v) = at(i);
            let w = |label: u16| planes[usize::from(label)].at(u as f64 - 70.0, v as f64 - 20.0);
            let doubtful = (0..3).filter(|other| *other != own).any(|other| {
                let limit = AMBIGUOUS_SYSTEMATICS * noise.systematic_ratio * w(own);
                near(own, u, v) && near(other, u, v) && (w(other) - w(own)).abs() < limit
            });
            assert_eq!(sure.has(u, v), !doubtful, "({u}, {v})");
            dropped += usize::from(doubtful);
        }
        assert!((100..2000).contains(&dropped), "{dropped}");
    }
}
