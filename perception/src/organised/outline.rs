//! A face's pixels → the face: its rings on the plane, what ends it at every edge, its covariance.

use nalgebra::{
    Isometry3, Point2, Point3, Rotation2, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use surfaces::{Edge, EdgeView, Error, FACE_AREA_MIN_M2, Fit};

use super::chart::Chart;
use super::contour;
use super::edges::{Edges, Seen};
use super::face::Face;
use super::image::InverseImage;
use super::plane::Plane;
use super::spread::Spread;
use crate::face::Known;
use crate::scan::tangent_frame;
use crate::sensor::Noise;

/// Notches of an outline no deeper than this are noise of the edge and filled, px.
const NOTCH_PX: f64 = 1.5;
/// Bulges no higher than this are cut off, px, and than 3 % of the face's mean width.
const BULGE_PX: f64 = 2.0;
/// Parts of these with which an outline that crosses itself is found again: where a face is narrower than a notch and
/// a bulge together, its two sides may go past each other. The last leave the pixels as they are.
const FINER: [f64; 4] = [1.0, 0.5, 0.25, 0.0];
/// Standard deviation of an edge's place in an image, px: that of a pixel is about .8 [nguyen2012], and an edge is
/// the median of several. Outlines of images lie inside the true edges already, by what was taken off and what dropped
/// out there.
const EDGE_SIGMA_PX: f64 = 0.5;

/// The face of connected pixels of a plane, seen from `X_WV`; `None` where it is too small or a pixel wide.
///
/// The outline is found and simplified on the pixels, where the uncertainty of an edge has one size.
/// What ends the face beyond is looked up `around` it.
///
/// # Errors
/// As [`crate::face::face`].
pub(super) fn face(
    image: &InverseImage,
    pixels: &Face,
    around: &Seen,
    (plane, chart, spread): &(&Plane, Chart, Spread),
    noise: &Noise,
    X_WV: &Isometry3<f64>,
) -> Option<Result<surfaces::Face, Error>> {
    let of_run = |&(v, a, b): &(u32, u32, u32)| {
        let middle = f64::from(a + b - 1) / 2.0;
        f64::from(b - a) * plane.pixel_area(image, middle, f64::from(v))
    };
    let area_m2: f64 = pixels.runs.iter().map(of_run).sum();
    if area_m2 < FACE_AREA_MIN_M2 {
        return None;
    }
    // 1. The plane's frame, its tangents those of the world. The chart depends on the sensor only,
    // so that its pose moves the face and does not change it.
    let R_VW = X_WV.rotation.inverse();
    let (forward, up) = (R_VW * Vector3::x(), R_VW * Vector3::z());
    let R_VS = Rotation3::from_matrix_unchecked(tangent_frame(&-plane.normal, &forward, &up));
    let R_SP = R_VS.inverse() * chart.R_VP;
    let turn = Rotation2::from_matrix_unchecked(R_SP.matrix().fixed_view::<2, 2>(0, 0).into());
    let on_plane = |p: &Point2<f64>| Some(turn * chart.at(p.x, p.y)?.0);
    let X_VS = Isometry3::from_parts(
        Translation3::from(chart.foot.coords),
        UnitQuaternion::from_rotation_matrix(&R_VS),
    );

    // 2. How well the plane is known.
    let known = Known {
        plane: pixels.label,
        fit: Fit {
            points: plane.inliers,
            rms_m: plane.rms_m,
        },
        view: EdgeView {
            eye_W: Point3::from(X_WV.translation.vector),
            sigma_rad: EDGE_SIGMA_PX / image.intrinsics.fx,
            plane_covariance: None,
        },
    };
    let covariance =
        |origin: &Point2<f64>| spread.covariance(&(turn.inverse() * origin), &turn, noise);

    // 3. Rings on the pixels, what ends the face at their edges, and the rings on the plane.
    let found = |part: f64| {
        let on_pixels = contour::rings(pixels, part * NOTCH_PX, part * BULGE_PX);
        // What is one pixel wide has no room between the pixels' centres.
        if on_pixels.is_empty() {
            return None;
        }
        let edges = Edges::new(around, pixels.label, &on_pixels);
        let rings: Vec<Vec<Point2<f64>>> = (on_pixels.iter())
            .map(|ring| ring.iter().map(on_plane).collect())
            .collect::<Option<_>>()?;
        let edge = |ring: usize, i: usize| Edge {
            kind: edges.kinds[ring][i],
            inside_rad: edges.inside_rad[ring][i],
            view: Some(0),
            ..Edge::default()
        };
        let X_WS = X_WV * X_VS;
        Some(crate::face::face(&rings, edge, &X_WS, &known, covariance))
    };
    let mut refused = None;
    for face in FINER.into_iter().filter_map(found) {
        if face.is_ok() {
            return Some(face);
        }
        refused.get_or_insert(face);
    }
    refused
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::moments::InversePlane;
    use crate::sensor::Intrinsics;
    use crate::{DepthImage, Sensor};

    /// What is left of a part of a row or column beside a fold, say.
    #[test]
    fn a_pixel_wide_is_no_face() {
        let (width, height) = (64, 48);
        let (fx, fy, cx, cy) = (60.0, 60.0, 31.5, 23.5);
        let depth = DepthImage {
            width,
            height,
            z_m: vec![2.0; width * height],
            intrinsics: Intrinsics { fx, fy, cx, cy },
        };
        let noise = &Sensor::named("xtion").unwrap().noise;
        let (image, ..) = InverseImage::new(&depth, 10.0, Vec::new());
        let plane = Plane {
            normal: Vector3::z(),
            distance: 2.0,
            inverse: InversePlane(Vector3::new(0.0, 0.0, 0.5)),
            inliers: width * height,
            rms_m: 0.001,
        };
        let (labels, planes) = (vec![0; width * height], [Some(plane)]);
        let around = Seen::new(&depth, &image, &labels, &planes, noise);
        let found = |rows: std::ops::Range<u32>| {
            let runs = rows.map(|v| (v, 8, 56)).collect();
            let pixels = Face { label: 0, runs };
            let chart = Chart::new(&image, &plane);
            let spread = Spread::new(&[&pixels], &plane, &chart, noise);
            let known = (&plane, chart, spread);
            face(
                &image,
                &pixels,
                &around,
                &known,
                noise,
                &Isometry3::identity(),
            )
        };
        assert!(found(20..21).is_none());
        assert!(found(20..26).unwrap().is_ok());
    }
}
