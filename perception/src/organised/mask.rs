//! The labelled pixels that surely lie on their face: small gaps closed, edges taken off.

use super::bits::Bits;
use super::cell::{CellNoise, unevenness};
use super::image::InverseImage;
use super::label_boundaries::LabelBoundaries;
use super::moments::Region;
use super::words::between;
use crate::segmentation::NONE;
use crate::sensor::Noise;

/// Longest run of unmeasured pixels between two of one face that is closed, px.
const GAP_PX: usize = 4;
/// How far edges are taken back at least, px: where a face ends at unmeasured pixels drop-outs have taken some of it
/// already, and where its plane meets another one nothing is mixed.
const EDGE_PX: usize = 1;
/// How far edges are taken back where another surface is beside a face that it does not meet, px.
pub(super) const EDGE_SEEN_PX: usize = 2;
/// Parts narrower than twice this and one pixel are taken off, px.
const NECK_PX: usize = 2;

/// The square of the distance from a plane beyond which a pixel of inverse depth `w` surely is not on it,
/// 1/m²: (5σ)² + (3κw)², κ with the plane's [`unevenness`].
pub(super) fn surely_off(w: f64, uneven: f64, noise: &Noise) -> f64 {
    CellNoise::at(noise, w, uneven).square(5.0, 3.0)
}

/// Closes small gaps of the labels along rows, then along columns; returns the pixels still without,
/// and which of them were not measured.
///
/// A gap is closed where it is bounded by the same label on both sides and holds nothing that
/// contradicts the plane: unmeasured pixels and outliers near the plane, never another label. So is one in
/// which the planes of both sides meet, where all of it was measured near them: folds are round.
pub(super) fn close(
    image: &InverseImage,
    regions: &[Region],
    labels: &mut [u16],
    noise: &Noise,
) -> (Bits, Bits) {
    let (width, lens) = (image.width, image.lens());
    let mut none = Bits::of(labels, width, |label| label == NONE);
    let uneven = |region: &Region| unevenness(&lens, &region.plane, noise);
    let uneven: Vec<f64> = regions.iter().map(uneven).collect();
    // Along the rows, then down the columns. A gap ends at pixels with a label: to close it changes no
    // other one.
    for (down, step) in [(false, 1), (true, width)] {
        starts(&none, GAP_PX, down).for_each(|u, v| {
            let first = v * width + u;
            let label = labels[first - step];
            // A shorter gap ends before the image does. All are looked at: where to stop could not be
            // foreseen.
            let last = labels.len() - 1;
            let open = |(gap, all): (usize, bool), k: usize| {
                let all = all & (labels[(first + k * step).min(last)] == NONE);
                (gap + usize::from(all), all)
            };
            let (gap, _) = (1..GAP_PX).fold((1, true), open);
            let other = labels[first + gap * step];
            // The planes before and after the gap, from its first pixel on, and how far they allow a pixel to be off.
            let from = |label: u16| {
                let label = usize::from(label);
                let plane = &regions[label].plane;
                let (x, y) = (u as f64 - image.centre.0, v as f64 - image.centre.1);
                let slope = if down { plane.0.y } else { plane.0.x };
                let own = plane.at(x, y);
                (own, slope, surely_off(own, uneven[label], noise))
            };
            let before = from(label);
            let after = if other == label { before } else { from(other) };
            let apart = |k: f64| after.0 - before.0 + k * (after.1 - before.1);
            if apart(-1.0) * apart(gap as f64) > 0.0 {
                return;
            }
            // A pixel goes to the plane that is nearest to it; at a fold it has to be measured.
            let to = |k: usize| {
                let w = f64::from(image.w[first + k * step]);
                let square =
                    |(own, slope, _): (f64, f64, f64)| (own + k as f64 * slope - w).powi(2);
                let (its, nearest) = if square(after) < square(before) {
                    (other, after)
                } else {
                    (label, before)
                };
                let fits = if w > 0.0 {
                    square(nearest) <= nearest.2
                } else {
                    other == label
                };
                fits.then_some(its)
            };
            if (0..gap).all(|k| to(k).is_some()) {
                for k in 0..gap {
                    labels[first + k * step] = to(k).unwrap_or(label);
                    let (u, v) = if down { (u, v + k) } else { (u + k, v) };
                    none.clear(u, v);
                }
            }
        });
    }
    let unmeasured = none.clone().filter(&image.w, |w| w == 0.0);
    (none, unmeasured)
}

/// The first pixels of the gaps along the rows, or down the columns, that are no longer than `most`
/// pixels and not at the image's border.
fn starts(none: &Bits, most: usize, down: bool) -> Bits {
    // Those with a label so near ahead that have none, after one with a label.
    if down {
        return Bits::new(none.width, none.height, |v, starts| {
            let Some(above) = v.checked_sub(1) else {
                return;
            };
            for below in (v + 1..none.height).take(most) {
                let near = starts.iter_mut().zip(none.row(below));
                near.for_each(|(start, none)| *start |= !none);
            }
            for ((start, none), above) in starts.iter_mut().zip(none.row(v)).zip(none.row(above)) {
                *start &= none & !above;
            }
        });
    }
    let mut labelled = Vec::new();
    Bits::new(none.width, none.height, |v, starts| {
        let row = (0..).zip(none.row(v));
        labelled.clear();
        labelled.extend(row.map(|(i, none_of)| !none_of & between(0, none.width, i)));
        labelled.push(0);
        for k in 1..=most {
            let ahead = starts.iter_mut().zip(labelled.array_windows());
            ahead.for_each(|(start, [word, after])| {
                *start |= word >> (k - 1) >> 1 | after << (64 - k);
            });
        }
        let mut before = 0;
        for ((start, none), labelled) in starts.iter_mut().zip(none.row(v)).zip(&labelled) {
            *start &= none & (labelled << 1 | before >> 63);
            before = *labelled;
        }
    })
}

/// The pixels that surely lie on their face.
///
/// At its `edges` every face loses its outermost [`EDGE_PX`] pixels, and at those of them that are `steps`
/// [`EDGE_SEEN_PX`] where another surface is beside it (in the maximum norm). Nothing is taken off at folds, nor at the
/// border of the image, where only the view ends. `none` are the pixels without a label, of which some are
/// `unmeasured`.
pub(super) fn erode(
    none: &Bits,
    unmeasured: &Bits,
    edges: &LabelBoundaries,
    steps: &LabelBoundaries,
) -> Bits {
    let seen = steps.near(EDGE_SEEN_PX, Some(unmeasured));
    let all = edges.near(EDGE_PX, None);
    Bits::around([&seen, &all, none], |[seen, all, none]| {
        !(seen[1][1] | all[1][1] | none[1][1])
    })
}

/// The pixels of the parts that are wider than 2 [`NECK_PX`]: eroded, and grown back within what was
/// there. Beyond a fold it is the other face's, which is as sure.
pub(super) fn open(sure: Bits) -> Bits {
    // What is near the core of a face, far from all that is not sure, is all of that face.
    sure.eroded(NECK_PX).dilated(NECK_PX)
}

#[cfg(test)]
mod tests {
    use super::super::bits::tests::kept;
    use super::*;

    #[test]
    fn gaps_start_after_a_label_and_end_before_one() {
        for (width, height) in [(5, 3), (64, 4), (70, 90), (130, 9)] {
            // Runs of all lengths, over the ends of words and rows.
            let is_none = |u: usize, v: usize| (u * u / 7 + v * v / 5 + u * v / 3) % 9 < 6;
            let none: Vec<bool> = (0..width * height)
                .map(|i| is_none(i % width, i / width))
                .collect();
            let none = Bits::of(&none, width, |is| is);
            for (most, down) in [0, 1, 4, 64]
                .into_iter()
                .flat_map(|m| [(m, false), (m, true)])
            {
                let got = starts(&none, most, down);
                for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
                    let (at, count) = if down { (v, height) } else { (u, width) };
                    let is_none = |k: usize| if down { is_none(u, k) } else { is_none(k, v) };
                    let end = (at..count).find(|k| !is_none(*k));
                    let expected = at > 0
                        && !is_none(at - 1)
                        && end.is_some_and(|end| (1..=most).contains(&(end - at)));
                    assert_eq!(
                        got.has(u, v),
                        expected,
                        "({u}, {v}) of {width}, {most}, {down}"
                    );
                }
            }
        }
    }

    #[test]
    fn erosion_takes_most_off_at_a_surface_less_in_the_air_and_at_a_crease_and_none_at_the_border_nor_at_a_fold()
     {
        // Face, gap without depth, face, another face, then a surface without a plane.
        let row = "aaaa..bbbbbbcccc??";
        let picture = row.repeat(3);
        let labels: Vec<u16> = picture
            .bytes()
            .map(|b| match b {
                b'a'..=b'c' => u16::from(b - b'a'),
                _ => NONE,
            })
            .collect();
        let none = Bits::of(&labels, row.len(), |label| label == NONE);
        let unmeasured = Bits::of(picture.as_bytes(), row.len(), |b| b == b'.');
        for (crease, fold, expected) in [
            (false, false, "aaa....bbb........"),
            (true, false, "aaa....bbbb..c...."),
            (true, true, "aaa....bbbbbcc...."),
        ] {
            let [mut edges, mut steps] =
                [(); 2].map(|()| LabelBoundaries::new(&labels, row.len(), 3));
            for (is, borders) in [(fold, &mut edges), (crease, &mut steps)] {
                (0..3)
                    .filter(|_| is)
                    .for_each(|v| borders.clear(true, 11, v));
            }
            let eroded = kept(&erode(&none, &unmeasured, &edges, &steps), &labels);
            let got = eroded.iter().map(|&label| match label {
                NONE => '.',
                label => char::from(b'a' + label as u8),
            });
            assert_eq!(got.collect::<String>(), expected.repeat(3));
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
        let sure = Bits::of(&labels, 11, |label| label != NONE);
        let opened = kept(&open(sure), &labels);
        for (i, (&before, &after)) in labels.iter().zip(&opened).enumerate() {
            let expected = if i % 11 < 7 { before } else { NONE };
            assert_eq!(after, expected, "pixel {i}");
        }
    }
}
