//! The labelled pixels that surely lie on their face: small gaps closed, edges taken off.

use serde::{Deserialize, Serialize};

use super::growth::{CellNoise, Region};
use super::image::InverseImage;
use super::labels::NONE;
use crate::Error;
use crate::error::within;
use crate::sensor::Noise;

/// How the labels become faces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaskConfig {
    /// Longest run of unmeasured pixels between two of one face that is closed, px.
    pub gap_px: usize,
    /// k σ_edge: how far every edge is taken back, px.
    pub edge_px: usize,
}

impl Default for MaskConfig {
    fn default() -> Self {
        Self {
            gap_px: 4,
            edge_px: 2,
        }
    }
}

impl MaskConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        within(
            "gap_px",
            self.gap_px as f64,
            0.0,
            64.0,
            "must be in [0, 64] px",
        )?;
        within(
            "edge_px",
            self.edge_px as f64,
            0.0,
            64.0,
            "must be in [0, 64] px",
        )
    }
}

/// The labels with small gaps closed along rows, then along columns.
///
/// A gap is closed where it is bounded by the same label on both sides and holds nothing that
/// contradicts the plane: unmeasured pixels and outliers near the plane, never another label.
pub(super) fn close(
    image: &InverseImage,
    regions: &[Region],
    labels: &mut [u16],
    noise: &Noise,
    gap_px: usize,
) {
    let (width, height) = (image.width, image.height);
    let agrees = |i: usize, label: u16| {
        let w = f64::from(image.w[i]);
        if w <= 0.0 {
            return true;
        }
        let (x, y) = (
            (i % width) as f64 - image.centre.0,
            (i / width) as f64 - image.centre.1,
        );
        let e = regions[usize::from(label)].plane.at(x, y) - w;
        e * e <= CellNoise::at(noise, w).square(5.0, 3.0)
    };
    let mut run = |start: usize, step: usize, count: usize| {
        // Index and label of the last labelled pixel of this row or column.
        let mut last: Option<(usize, u16)> = None;
        for k in 0..count {
            let label = labels[start + k * step];
            if label == NONE {
                continue;
            }
            if let Some((from, before)) = last
                && before == label
                && k - from > 1
                && k - from <= gap_px + 1
                && (from + 1..k).all(|j| agrees(start + j * step, label))
            {
                (from + 1..k).for_each(|j| labels[start + j * step] = label);
            }
            last = Some((k, label));
        }
    };
    (0..height).for_each(|v| run(v * width, 1, width));
    (0..width).for_each(|u| run(u, width, height));
}

/// The labels that are left when every face loses its outermost `edge_px` pixels (in the maximum
/// norm); a face also ends at the border of the image.
pub(super) fn erode(labels: &[u16], width: usize, height: usize, edge_px: usize) -> Vec<u16> {
    // Along rows, then along columns: a pixel stays if the 2 r + 1 around it are alike.
    let mut rows = vec![NONE; labels.len()];
    for v in 0..height {
        let line = &labels[v * width..(v + 1) * width];
        erode_line(line, &mut rows[v * width..(v + 1) * width], edge_px);
    }
    let mut eroded = vec![NONE; labels.len()];
    // Length of the run of equal labels that ends above (including) the current row.
    let mut runs = vec![0_usize; width];
    let mut last = vec![NONE; width];
    for v in 0..height {
        for u in 0..width {
            let label = rows[v * width + u];
            runs[u] = if label == last[u] { runs[u] + 1 } else { 1 };
            last[u] = label;
            if label != NONE && runs[u] > 2 * edge_px {
                eroded[(v - edge_px) * width + u] = label;
            }
        }
    }
    eroded
}

fn erode_line(line: &[u16], out: &mut [u16], r: usize) {
    let mut run = 0;
    let mut last = NONE;
    for (u, &label) in line.iter().enumerate() {
        run = if label == last { run + 1 } else { 1 };
        last = label;
        if label != NONE && run > 2 * r {
            out[u - r] = label;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erosion_takes_the_edge_off_every_face_and_the_border() {
        // Two faces side by side, 8 × 6 pixels.
        let (width, height) = (8, 6);
        let labels: Vec<u16> = (0..48).map(|i| u16::from(i % width >= 4)).collect();
        let eroded = erode(&labels, width, height, 1);
        let expected = |u: usize, v: usize| {
            let inside = (1..5).contains(&v) && matches!(u, 1 | 2 | 5 | 6);
            if inside { u16::from(u >= 4) } else { NONE }
        };
        for v in 0..height {
            for u in 0..width {
                assert_eq!(eroded[v * width + u], expected(u, v), "{u} {v}");
            }
        }
        assert_eq!(erode(&labels, width, height, 0), labels);
    }
}
