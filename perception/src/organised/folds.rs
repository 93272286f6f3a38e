//! Where two faces meet: borders at which nothing is mixed, hidden or missing.

use super::image::InverseImage;
use super::label_boundaries::LabelBoundaries;
use super::moments::{InversePlane, Region};
use crate::sensor::Noise;

/// Planes meet at a border where that is within so many pixels of their common line. Pixels go to the nearest plane, so
/// that a fold's border is that line; what ends before something farther away is as far from it as it is high.
const MEETING_PX: f64 = 1.0;
/// The slowly varying error moves the line by no more than this, px, as at a riser seen over a tread at a flat angle: the foot of a ramp
/// is no such line.
const MOVED_PX: f64 = 0.5;

/// The borders but for folds, where the planes of both sides meet.
pub(super) fn without_folds(
    image: &InverseImage,
    regions: &[Region],
    labels: &[u16],
    cuts: &LabelBoundaries,
    noise: &Noise,
) -> LabelBoundaries {
    let mut edges = cuts.clone();
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
            let rise = apart.x.hypot(apart.y);
            if here.abs() <= MEETING_PX * rise && slow <= MOVED_PX * rise {
                edges.clear(along, u, v);
            }
        });
    }
    edges
}
