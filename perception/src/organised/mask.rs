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
    /// How far edges are taken back where a face ends at unmeasured pixels (an edge in the air:
    /// the drop-outs have taken some of it), px.
    pub edge_unseen_px: usize,
    /// How far edges are taken back where a face meets another surface, px.
    pub edge_seen_px: usize,
    /// Pixels within two cells of another face are left out where the two planes agree to this
    /// many κ z: the border between two planes at a small angle is anywhere.
    pub doubt_systematics: f64,
    /// Parts narrower than twice this and one pixel are taken off, px.
    pub neck_px: usize,
}

impl Default for MaskConfig {
    fn default() -> Self {
        Self {
            gap_px: 4,
            edge_unseen_px: 1,
            edge_seen_px: 2,
            doubt_systematics: 1.0,
            neck_px: 2,
        }
    }
}

impl MaskConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        within(
            "doubt_systematics",
            self.doubt_systematics,
            0.0,
            100.0,
            "must be in [0, 100]",
        )?;
        for (key, value) in [
            ("gap_px", self.gap_px),
            ("edge_unseen_px", self.edge_unseen_px),
            ("edge_seen_px", self.edge_seen_px),
            ("neck_px", self.neck_px),
        ] {
            within(key, value as f64, 0.0, 64.0, "must be in [0, 64] px")?;
        }
        Ok(())
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

/// The labels that surely lie on their face.
///
/// Every face loses its outermost `unseen_px` pixels where it ends at unmeasured ones, and
/// `seen_px` where it ends at another surface (in the maximum norm). Nothing is taken off at the
/// border of the image, where only the view ends.
pub(super) fn erode(
    image: &InverseImage,
    labels: &[u16],
    unseen_px: usize,
    seen_px: usize,
) -> Vec<u16> {
    let (width, height) = (image.width, image.height);
    // What a pixel is to its neighbours: its label; a mix of its own for what has none.
    let solid = |label: u16| if label == NONE { MIXED } else { label };
    let measured: Vec<u16> = labels
        .iter()
        .zip(&image.w)
        .map(|(&label, &w)| {
            if label == NONE && w == 0.0 {
                OPEN
            } else {
                solid(label)
            }
        })
        .collect();
    let all: Vec<u16> = labels.iter().map(|&label| solid(label)).collect();
    let far = joined(&measured, width, height, seen_px);
    let near = joined(&all, width, height, unseen_px);
    let both = far.iter().zip(&near);
    labels
        .iter()
        .zip(both)
        .map(|(&l, (&f, &n))| if f == l && n == l { l } else { NONE })
        .collect()
}

/// No label: joins with any other to that one.
pub(super) const OPEN: u16 = u16::MAX - 1;
/// Two labels, or a surface that has none: joins with any other to itself.
pub(super) const MIXED: u16 = u16::MAX;

/// What the pixels within `r` of each pixel (in the maximum norm) have in common: nothing
/// ([`OPEN`]), one label, or more than one ([`MIXED`]).
pub(super) fn joined(labels: &[u16], width: usize, height: usize, r: usize) -> Vec<u16> {
    let mut rows = labels.to_vec();
    for (line, from) in rows
        .chunks_exact_mut(width.max(1))
        .zip(labels.chunks_exact(width.max(1)))
    {
        for d in 1..=r.min(width.saturating_sub(1)) {
            join_all(&mut line[d..], &from[..width - d]);
            join_all(&mut line[..width - d], &from[d..]);
        }
    }
    let mut all = rows.clone();
    for d in 1..=r.min(height.saturating_sub(1)) {
        let (d, n) = (d * width, all.len());
        join_all(&mut all[d..], &rows[..n - d]);
        join_all(&mut all[..n - d], &rows[d..]);
    }
    all
}

fn join_all(to: &mut [u16], from: &[u16]) {
    for (a, &b) in to.iter_mut().zip(from) {
        let either = if *a == OPEN { b } else { *a };
        *a = if *a == b || *a == OPEN || b == OPEN {
            either
        } else {
            MIXED
        };
    }
}

/// The labels without the parts that are no wider than 2 `neck_px`: eroded, and grown back within
/// what was there.
pub(super) fn open(labels: &[u16], width: usize, height: usize, neck_px: usize) -> Vec<u16> {
    // NONE is MIXED, so that the core of a face is what is far from all that is not the face.
    let core: Vec<u16> = joined(labels, width, height, neck_px)
        .into_iter()
        .map(|label| if label == MIXED { OPEN } else { label })
        .collect();
    // Cores of two faces are more than 2 `neck_px` apart, so no pixel is near two of them.
    let grown = joined(&core, width, height, neck_px);
    labels
        .iter()
        .zip(grown)
        .map(|(&l, g)| if l == g { l } else { NONE })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Intrinsics;

    fn image(width: usize, w: Vec<f32>) -> InverseImage {
        let height = w.len() / width;
        let intrinsics = Intrinsics {
            fx: 100.0,
            fy: 100.0,
            cx: 0.0,
            cy: 0.0,
        };
        InverseImage {
            width,
            height,
            w,
            intrinsics,
            centre: (0.0, 0.0),
        }
    }

    #[test]
    fn erosion_takes_more_off_at_a_surface_than_in_the_air_and_none_at_the_border() {
        // Face, gap without depth, face, then a surface without a plane.
        let row = "aaaa..bbbbbb??";
        let picture = row.repeat(3);
        let labels: Vec<u16> = picture
            .bytes()
            .map(|b| match b {
                b'a' => 0,
                b'b' => 1,
                _ => NONE,
            })
            .collect();
        let w = picture
            .bytes()
            .map(|b| if b == b'.' { 0.0 } else { 1.0 })
            .collect();
        let eroded = erode(&image(row.len(), w), &labels, 1, 2);
        let expected = "aaa....bbb....".repeat(3);
        for (i, (&label, want)) in eroded.iter().zip(expected.bytes()).enumerate() {
            let got = match label {
                0 => b'a',
                1 => b'b',
                _ => b'.',
            };
            assert_eq!(got, want, "pixel {i}");
        }
    }

    #[test]
    fn opening_removes_a_neck_and_keeps_the_corners() {
        let picture = [
            "#######....",
            "###########",
            "#######....",
            "#######....",
            "#######....",
        ];
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 3 } else { NONE }))
            .collect();
        let opened = open(&labels, 11, 5, 1);
        for (i, (&before, &after)) in labels.iter().zip(&opened).enumerate() {
            let expected = if i % 11 < 7 { before } else { NONE };
            assert_eq!(after, expected, "pixel {i}");
        }
    }
}
