//! Where one face rises from another: borders that no foot falls off.

use super::bits::Bits;
use super::image::InverseImage;
use super::label_boundaries::LabelBoundaries;
use super::moments::Region;

/// Where two surfaces meet is known to this, px.
const MEETING_PX: f64 = 2.0;

/// The pixels on both sides of a fold, a border where two planes meet and each is before what the other would go
/// on as.
///
/// No pixel there has something of a depth between two surfaces, and none is missing: less than at an edge
/// is to be taken off.
pub(super) fn folds(
    image: &InverseImage,
    regions: &[Region],
    labels: &[u16],
    cuts: &LabelBoundaries,
) -> Bits {
    let (width, (u0, v0)) = (image.width, image.centre);
    let mut folds = Bits::empty(width, image.height);
    for (along, x, y) in [(true, 1, 0), (false, 0, 1)] {
        cuts.toward(along).for_each(|u, v| {
            let plane = |i: usize| Some(regions.get(usize::from(labels[i]))?.plane.0);
            let first = v * width + u;
            let (Some(a), Some(b)) = (plane(first), plane(first + x + y * width)) else {
                return;
            };
            // How far before the first one the second plane is, at the border and a pixel on.
            let apart = b - a;
            let (right, down) = (u as f64 + 0.5 * x as f64, v as f64 + 0.5 * y as f64);
            let here = apart.x * (right - u0) + apart.y * (down - v0) + apart.z;
            let rise = if along { apart.x } else { apart.y };
            if rise > 0.0 && here.abs() <= MEETING_PX * rise {
                folds.fill(v, u, u + 1);
                folds.fill(v + y, u + x, u + x + 1);
            }
        });
    }
    folds
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::moments::{InversePlane, Moments};
    use super::*;
    use crate::sensor::Intrinsics;

    #[test]
    fn a_riser_folds_up_from_its_tread_and_not_down_from_the_next() {
        // Rows of a tread, of the riser behind it and of the tread on that; inverse depth falls up the image on
        // treads, and hardly on the riser.
        let (width, height) = (4, 30);
        let region = |b: f64, c: f64| Region {
            moments: Moments::default(),
            plane: InversePlane(Vector3::new(0.0, b, c)),
        };
        let regions = [
            region(2e-3, 0.5),
            region(1e-4, 0.5 + 1.9e-3 * 5.0),
            region(2e-3, 0.5 + 1.9e-3 * 15.0),
        ];
        let label = |v: usize| {
            if v > 20 {
                0
            } else if v > 5 {
                1
            } else {
                2
            }
        };
        let labels: Vec<u16> = (0..width * height).map(|i| label(i / width)).collect();
        let image = InverseImage {
            width,
            height,
            w: vec![0.5; width * height],
            intrinsics: Intrinsics {
                fx: 500.0,
                fy: 500.0,
                cx: 0.0,
                cy: 0.0,
            },
            centre: (0.0, 15.5),
        };
        let cuts = LabelBoundaries::new(&labels, width, height);
        let folds = folds(&image, &regions, &labels, &cuts);
        let rows: Vec<usize> = (0..height).filter(|v| folds.has(1, *v)).collect();
        assert_eq!(rows, [20, 21]);
    }
}
