//! The labelled pixels that surely lie on their face: small gaps closed, edges taken off.

use serde::{Deserialize, Serialize};

use super::bits::{Bits, pack};
use super::growth::{CellNoise, Region};
use super::image::InverseImage;
use super::labels::NONE;
use super::links::Links;
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

/// Closes small gaps of the labels along rows, then along columns; returns the pixels still without.
///
/// A gap is closed where it is bounded by the same label on both sides and holds nothing that
/// contradicts the plane: unmeasured pixels and outliers near the plane, never another label.
pub(super) fn close(
    image: &InverseImage,
    regions: &[Region],
    labels: &mut [u16],
    noise: &Noise,
    gap_px: usize,
) -> Bits {
    let width = image.width;
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
    let mut none = Bits::new(width, image.height, |v, words| {
        let line = &labels[v * width..(v + 1) * width];
        pack(line, line, words, |label, _| label == NONE);
    });
    // Along the rows, then down the columns: where a label follows on none, from it back over the
    // unlabelled pixels before it.
    for down in [false, true] {
        // None is before the first column, or row; it is not before what is beyond.
        let after = if down {
            none.clone().shifted_down()
        } else {
            none.clone().shifted_along()
        };
        let step = if down { width } else { 1 };
        after.and(&none.clone().not()).for_each(|u, v| {
            let i = v * width + u;
            let (label, before) = (labels[i], if down { v } else { u });
            let mut steps = 1..=before.min(gap_px + 1);
            let Some(gap) = steps.find(|k| labels[i - k * step] != NONE) else {
                return;
            };
            if labels[i - gap * step] == label && (1..gap).all(|k| agrees(i - k * step, label)) {
                for k in 1..gap {
                    labels[i - k * step] = label;
                    let (u, v) = if down { (u, v - k) } else { (u - k, v) };
                    none.clear(u, v);
                }
            }
        });
    }
    none
}

/// The pixels that surely lie on their face.
///
/// Every face loses its outermost `unseen_px` pixels where it ends at unmeasured ones, and
/// `seen_px` where another surface is beside it (in the maximum norm). Nothing is taken off at the
/// border of the image, where only the view ends. `none` are the pixels without a label.
pub(super) fn erode(
    image: &InverseImage,
    none: Bits,
    links: &Links,
    unseen_px: usize,
    seen_px: usize,
) -> Bits {
    let unmeasured = none.clone().filter(&image.w, |w| w == 0.0);
    let labelled = none.not();
    let seen = links.through(&unmeasured).uniform(seen_px);
    labelled.and(&seen).and(&links.uniform(unseen_px))
}

/// The pixels of the parts that are wider than 2 `neck_px`: eroded, and grown back within what was
/// there. `links` are those of the labels.
pub(super) fn open(sure: Bits, links: &Links, neck_px: usize) -> Bits {
    // The core of a face is what is far from all that is not the face; what is near a core is all
    // of one face.
    let core = sure.eroded(neck_px).and(&links.uniform(neck_px));
    core.dilated(neck_px)
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
        let links = Links::new(&labels, row.len(), 3);
        let none = Bits::new(row.len(), 3, |v, words| {
            let line = &labels[v * row.len()..][..row.len()];
            pack(line, line, words, |label, _| label == NONE);
        });
        let eroded = erode(&image(row.len(), w), none, &links, 1, 2).kept(&labels);
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
        let links = Links::new(&labels, 11, 5);
        let sure = Bits::new(11, 5, |v, words| {
            pack(&labels[v * 11..][..11], &[0; 11], words, |label, _| {
                label != NONE
            });
        });
        let opened = open(sure, &links, 1).kept(&labels);
        for (i, (&before, &after)) in labels.iter().zip(&opened).enumerate() {
            let expected = if i % 11 < 7 { before } else { NONE };
            assert_eq!(after, expected, "pixel {i}");
        }
    }
}
