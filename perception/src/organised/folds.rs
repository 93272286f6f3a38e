//! Where two faces meet: borders at which nothing is mixed, hidden or missing.

use super::image::InverseImage;
use super::label_boundaries::LabelBoundaries;
use super::moments::{InversePlane, Region};
use crate::sensor::Noise;

/// Planes meet at a border where that is within so many pixels of their common line, and the slowly varying error moves
/// that by no more than so many.
struct Meeting {
    apart_px: f64,
    moved_px: f64,
}

/// Pixels go to the nearest plane, so that a fold's border is the planes' line; what ends before something farther away
/// is as far from it as it is high. At a riser seen over a tread at a flat angle, and at the foot of a ramp, the line is
/// not known so well.
const FOLD: Meeting = Meeting {
    apart_px: 1.0,
    moved_px: 0.5,
};
/// Where planes meet at a flatter angle, or one of them is short, their labels fray within the noise. Nothing is mixed,
/// hidden or missing there either.
const CREASE: Meeting = Meeting {
    apart_px: 4.0,
    moved_px: 2.0,
};

/// The borders that are no folds, and those of them that are no creases.
pub(super) fn without_folds(
    image: &InverseImage,
    regions: &[Region],
    labels: &[u16],
    cuts: &LabelBoundaries,
    noise: &Noise,
) -> [LabelBoundaries; 2] {
    let [mut edges, mut steps] = [cuts.clone(), cuts.clone()];
    for along in [true, false] {
        let (x, y) = if along { (1, 0) } else { (0, 1) };
        cuts.toward(along).for_each(|u, v| {
            let plane = |i: usize| Some(regions.get(usize::from(labels[i]))?.plane.0);
            let first = v * image.width + u;
            let (Some(a), Some(b)) = (plane(first), plane(first + x + y * image.width)) else {
                return;
            };
            let apart = b - a;
            let right = u as f64 + 0.5 * x as f64 - image.centre.0;
            let down = v as f64 + 0.5 * y as f64 - image.centre.1;
            let here = apart.x * right + apart.y * down + apart.z;
            let slow = noise.systematic_ratio * InversePlane(a).at(right, down);
            // Squares: there are many borders.
            let rise = apart.x * apart.x + apart.y * apart.y;
            let within = |off: f64, px: f64| off * off <= px * px * rise;
            let meet = |at: Meeting| within(here, at.apart_px) && within(slow, at.moved_px);
            if meet(CREASE) {
                steps.clear(along, u, v);
                if meet(FOLD) {
                    edges.clear(along, u, v);
                }
            }
        });
    }
    [edges, steps]
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::moments::Moments;
    use super::*;
    use crate::sensor::{Intrinsics, SENSORS};

    #[test]
    fn a_border_is_a_fold_a_crease_or_a_step_by_where_the_planes_meet_and_how_well_that_is_known() {
        let (width, height, border) = (64, 4, 30);
        let noise = &SENSORS[0].noise;
        let w = 0.5;
        // Planes that meet some pixels right of the border, which the slow error moves by so many pixels.
        let kept = |meet_px: f64, moved_px: f64| {
            let rise = noise.systematic_ratio * w / moved_px;
            let plane = |rise: f64| InversePlane(Vector3::new(rise, 0.0, w - rise * meet_px));
            let region = |rise: f64| Region {
                moments: Moments::default(),
                plane: plane(rise),
            };
            let image = InverseImage {
                width,
                height,
                w: vec![w as f32; width * height],
                intrinsics: Intrinsics {
                    fx: 500.0,
                    fy: 500.0,
                    cx: 0.0,
                    cy: 0.0,
                },
                centre: (border as f64 - 0.5, 0.0),
            };
            let label = |i: usize| u16::from(i % width >= border);
            let labels: Vec<u16> = (0..width * height).map(label).collect();
            let cuts = LabelBoundaries::new(&labels, width, height);
            let regions = [region(0.0), region(rise)];
            without_folds(&image, &regions, &labels, &cuts, noise)
                .map(|borders| borders.toward(true).count() == height)
        };
        for (meet_px, moved_px, expected) in [
            (0.5, 0.4, [false, false]),
            (2.0, 0.4, [true, false]),
            (0.5, 0.8, [true, false]),
            (-3.5, 1.5, [true, false]),
            (5.0, 0.4, [true, true]),
            (0.5, 3.0, [true, true]),
        ] {
            assert_eq!(kept(meet_px, moved_px), expected, "{meet_px}, {moved_px}");
        }
    }
}
