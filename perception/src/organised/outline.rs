//! A face → its outline with holes and the convex polygons that cover it.

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use surfaces::ConvexPolygon;

use super::contour;
use super::cover::{CoverConfig, cover};
use super::face::{Face, Raster};
use super::image::InverseImage;
use super::plane::{self, Plane};
use crate::Error;
use crate::error::within;
use crate::scan::tangent_frame;
use crate::sensor::Noise;

/// From faces to outlines and convex polygons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutlineConfig {
    /// How far a simplified outline may leave the traced one, px.
    pub tolerance_px: f64,
    /// Notches of an outline no deeper than this are noise of the edge, px.
    pub notch_px: f64,
    /// The cover of a face by convex pieces.
    pub cover: CoverConfig,
}

impl Default for OutlineConfig {
    fn default() -> Self {
        Self {
            tolerance_px: 1.0,
            notch_px: 1.5,
            cover: CoverConfig::default(),
        }
    }
}

impl OutlineConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        within(
            "tolerance_px",
            self.tolerance_px,
            0.0,
            64.0,
            "must be in [0, 64] px",
        )?;
        within(
            "notch_px",
            self.notch_px,
            0.0,
            64.0,
            "must be in [0, 64] px",
        )?;
        self.cover.check()
    }
}

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
    /// Covariance of the plane in S.
    pub covariance: Option<[[f64; 3]; 3]>,
}

/// The convex pieces that cover a face.
///
/// The outline is found and simplified on the pixels, where the uncertainty of an edge has one
/// size; the face's edges were taken back before, so pieces of one face meet without a seam.
#[allow(non_snake_case)]
pub(super) fn pieces(
    image: &InverseImage,
    face: &Face,
    plane: &Plane,
    noise: &Noise,
    X_WV: &Isometry3<f64>,
    config: &OutlineConfig,
) -> Vec<Piece> {
    let area: f64 = face
        .runs
        .iter()
        .map(|&(v, a, b)| {
            let middle = f64::from(a + b - 1) / 2.0;
            f64::from(b - a) * plane.pixel_area(image, middle, f64::from(v))
        })
        .sum();
    if area < config.cover.area_min_m2 {
        return Vec::new();
    }
    let Some(raster) = Raster::new(face) else {
        return Vec::new();
    };
    let R_VS = frame(plane, X_WV);
    let foot = Point3::from(plane.normal * plane.distance);
    let in_S = |p: &Point2<f64>| {
        let q = R_VS.inverse() * (plane.point(image, p.x, p.y)? - foot);
        Some(Point2::new(q.x, q.y))
    };

    // The outline on the plane, covered by convex pieces.
    let rings = contour::rings(&raster, config.tolerance_px, config.notch_px);
    let rings: Option<Vec<Vec<_>>> = rings
        .iter()
        .map(|ring| ring.iter().map(in_S).collect())
        .collect();
    let Some(rings) = rings else {
        return Vec::new();
    };
    let pixel_m = (area
        / face
            .runs
            .iter()
            .map(|(_, a, b)| f64::from(b - a))
            .sum::<f64>())
    .sqrt();
    let covering = cover(&rings, 0.3 * pixel_m, &config.cover);

    // Each piece with the origin of its frame at its centroid.
    let chunks = chunks(face);
    let mut pieces = Vec::new();
    for piece in covering {
        let c = piece.centroid().coords;
        let moved = piece.vertices().iter().map(|v| v - c).collect();
        let Ok(polygon) = ConvexPolygon::new(moved) else {
            continue;
        };
        let origin = foot + R_VS * Vector3::new(c.x, c.y, 0.0);
        let X_VS = Isometry3::from_parts(
            Translation3::from(origin),
            UnitQuaternion::from_rotation_matrix(&R_VS),
        );
        let ring = |ring: &Vec<Point2<f64>>| ring.iter().map(|p| (p - c).coords.into()).collect();
        pieces.push(Piece {
            label: face.label,
            X_VS,
            outline: rings.iter().map(ring).collect(),
            covariance: plane::covariance(image, &chunks, plane, &origin, &R_VS, noise),
            polygon,
        });
    }
    pieces
}

/// Orientation of S in V: z_S toward the sensor.
#[allow(non_snake_case)]
fn frame(plane: &Plane, X_WV: &Isometry3<f64>) -> Rotation3<f64> {
    let R_VW = X_WV.rotation.inverse();
    let columns = tangent_frame(
        &-plane.normal,
        &(R_VW * Vector3::x()),
        &(R_VW * Vector3::z()),
    );
    Rotation3::from_matrix_unchecked(columns)
}

/// Middle and number of pixels of pieces of the face's runs.
fn chunks(face: &Face) -> Vec<(f64, f64, f64)> {
    let mut chunks = Vec::new();
    for &(v, a, b) in face.runs.iter().step_by(4) {
        let mut u = a;
        while u < b {
            let end = (u + 16).min(b);
            let n = f64::from(end - u);
            // Every fourth row stands for four.
            chunks.push((f64::from(u) + (n - 1.0) / 2.0, f64::from(v), 4.0 * n));
            u = end;
        }
    }
    chunks
}
