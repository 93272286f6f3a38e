//! A face → its outline with holes and the convex polygons that cover it.

use std::sync::Arc;

use nalgebra::{
    Isometry3, Point2, Point3, Rotation2, Rotation3, Translation3, UnitQuaternion, Vector3,
};
use surfaces::{ConvexPolygon, Edge, EdgeView, Fit};

use super::chart::Chart;
use super::contour;
use super::cover::cover;
use super::edges::{Edges, Seen};
use super::face::Face;
use super::image::InverseImage;
use super::plane::Plane;
use super::spread::Spread;
use crate::config::Config;
use crate::face::Known;
use crate::inset::EDGE_SIGMA_PX;
use crate::scan::tangent_frame;
use crate::sensor::Noise;

/// Notches of an outline no deeper than this are noise of the edge and filled, px.
const NOTCH_PX: f64 = 1.5;
/// Bulges no higher than this are cut off, px, and than 3 % of the face's mean width.
const BULGE_PX: f64 = 2.0;

/// An edge of the outline may reach this far into a piece, in mean pixels.
const SLACK_PX: f64 = 0.3;

/// One convex polygon of a face, in its frame.
#[allow(non_snake_case)]
pub(super) struct Piece {
    /// Index of the face's plane.
    pub label: u16,
    /// Pose of S in V: origin at the polygon's centroid, z_S toward the sensor.
    pub X_VS: Isometry3<f64>,
    /// The polygon in S, m.
    pub polygon: ConvexPolygon,
    /// Rings of the whole face in S, m.
    pub outline: Vec<Vec<[f64; 2]>>,
    /// What ends the face at each edge of each ring.
    pub edges: Arc<Edges>,
    /// Covariance of the plane in S.
    pub covariance: Option<[[f64; 3]; 3]>,
}

/// The convex pieces that cover a face.
///
/// The outline is found and simplified on the pixels, where the uncertainty of an edge has one
/// size; the face's edges were taken back before, so pieces of one face meet without a seam. What ends
/// the face beyond is looked up `around` it.
#[allow(non_snake_case)]
pub(super) fn pieces(
    image: &InverseImage,
    face: &Face,
    around: &Seen,
    plane: &Plane,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    config: &Config,
) -> (Vec<Piece>, Option<surfaces::Face>) {
    let area: f64 = face
        .runs
        .iter()
        .map(|&(v, a, b)| {
            let middle = f64::from(a + b - 1) / 2.0;
            f64::from(b - a) * plane.pixel_area(image, middle, f64::from(v))
        })
        .sum();
    if area < config.area_min_m2 {
        return (Vec::new(), None);
    }
    // Coordinates of the plane that depend on the sensor only, so that its pose moves the pieces
    // and does not change them.
    let chart = Chart::new(image, plane);

    // The outline on the plane, covered by convex pieces.
    let on_pixels = contour::rings(face, NOTCH_PX, BULGE_PX);
    let mut rings = Vec::with_capacity(on_pixels.len());
    for ring in &on_pixels {
        let mut on_plane = Vec::with_capacity(ring.len());
        on_plane.extend(ring.iter().map_while(|p| Some(chart.at(p.x, p.y)?.0)));
        if on_plane.len() < ring.len() {
            return (Vec::new(), None);
        }
        rings.push(on_plane);
    }
    let pixels: f64 = face.runs.iter().map(|(_, a, b)| f64::from(b - a)).sum();
    let slack_m = SLACK_PX * (area / pixels).sqrt();
    let covering = cover(&rings, slack_m, config);

    // Tangents as the world has them; each piece with its origin at its centroid.
    let R_VW = X_WV.rotation.inverse();
    let (forward, up) = (R_VW * Vector3::x(), R_VW * Vector3::z());
    let R_VS = Rotation3::from_matrix_unchecked(tangent_frame(&-plane.normal, &forward, &up));
    let R_SP = R_VS.inverse() * chart.R_VP;
    let turn = Rotation2::from_matrix_unchecked(R_SP.matrix().fixed_view::<2, 2>(0, 0).into());
    let edges = Arc::new(Edges::new(around, face.label, &on_pixels));
    let spread = Spread::new(face, pixels, plane, &chart, noise);
    let mut pieces = Vec::new();
    for piece in covering {
        let c = piece.centroid().coords;
        let corners: Vec<_> = piece.0.iter().map(|v| turn * (v - c)).collect();
        let Ok(polygon) = ConvexPolygon::hull(&corners) else {
            continue;
        };
        let origin = chart.foot + chart.R_VP * c.push(0.0);
        let X_VS = Isometry3::from_parts(
            Translation3::from(origin),
            UnitQuaternion::from_rotation_matrix(&R_VS),
        );
        let ring = |ring: &Vec<Point2<f64>>| {
            ring.iter()
                .map(|p| (turn * (p - c)).coords.into())
                .collect()
        };
        pieces.push(Piece {
            label: face.label,
            X_VS,
            outline: rings.iter().map(ring).collect(),
            edges: edges.clone(),
            covariance: spread.covariance(&Point2::from(c), &turn, noise),
            polygon,
        });
    }
    // The face as a whole, its tangents those of the world.
    let X_VP = Isometry3::from_parts(
        Translation3::from(chart.foot.coords),
        UnitQuaternion::from_rotation_matrix(&R_VS),
    );
    let turned = |ring: &Vec<Point2<f64>>| ring.iter().map(|p| turn * p).collect();
    let turned: Vec<Vec<Point2<f64>>> = rings.iter().map(turned).collect();
    let edge = |ring: usize, i: usize| Edge {
        kind: edges.kinds[ring][i],
        inside_rad: edges.inside_rad[ring][i],
        view: Some(0),
        ..Edge::default()
    };
    let known = Known {
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
    let whole = crate::face::face(&turned, edge, &(X_WV * X_VP), known, |origin| {
        spread.covariance(&(turn.inverse() * origin), &turn, noise)
    });
    (pieces, whole)
}
