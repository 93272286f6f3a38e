//! Convex bodies that surely cover what may stand behind a face.
//!
//! What a robot may touch lies surely on the face: its edges are taken back. For collisions the
//! opposite must hold: bodies that surely cover the face. So each convex piece of a scanned face's
//! region is widened by what its edges may be off, and extruded against the normal.
//!
//! `brossette2013` extrudes each surface by a few centimetres. A distance algorithm that finds a link
//! past the middle of so thin a body pushes it out at the far side; nothing is known of what is hidden
//! behind a face, so its body goes on there along the rays that saw it ([`crate::unseen`]), down to a plane parallel
//! to the face: then it is the same body into whichever convex parts the region is cut.

use nalgebra::{Point2, Point3};

use crate::cover::{self, cover};
use crate::{ConvexPolygon, Face, HalfPlane, Source};

/// A scanned face may go on beyond its region by this, m.
pub(crate) const EDGE_M: f64 = 0.005;
/// What is this near to a body touches it and does not end it, m: the noise of neighbouring faces,
/// such as the riser under the front edge of a tread.
pub(crate) const TOUCH_M: f64 = 0.02;
/// The least depth of a body whose far side is known, m: it must stay a body.
pub(crate) const DEPTH_MIN_M: f64 = 1e-3;
/// A piece that adds no more than this to those before it is left out, m²; of a body, what that leaves
/// bare is covered by convex parts.
const REST_MAX_M2: f64 = 0.002;
/// What is left bare is widened by this at least, m: it must be a body.
const SLIVER_M: f64 = 5e-5;
/// What is smaller is left bare, m²: what rounding leaves between pieces.
const SPECK_M2: f64 = 1e-8;

impl Face {
    /// The corners of convex bodies that cover what is behind the face, in W, m: prisms behind convex
    /// pieces of its region, `thickness_m` deep, and along the rays that saw it [`Self::depth_m`] deep. None behind
    /// the face of a mesh, which is among the obstacles itself.
    ///
    /// Shapes: of each body the n corners of its front, then the same n moved against the normal, and where it was
    /// seen the n moved along the rays.
    /// Source: `brossette2013` section IV-B, widened by what the edges of a scanned face may be off.
    pub fn bodies_W(&self, thickness_m: f64) -> Vec<Vec<Point3<f64>>> {
        let edge_m = match self.source {
            Source::Mesh => return Vec::new(),
            Source::Scan => EDGE_M,
            Source::File | Source::Robot => 0.0,
        };
        let mut fronts = fronts(self, edge_m);
        let widened: Vec<_> = fronts.iter().map(|front| front.grown(SLIVER_M)).collect();
        let bare = cover::outside(&self.region, &widened, SPECK_M2);
        fronts.extend(bare.iter().map(|part| part.grown(edge_m.max(SLIVER_M))));
        fronts
            .iter()
            .map(|front| self.body_W(front, thickness_m))
            .collect()
    }

    /// The body behind a convex part of the plane, in W.
    fn body_W(&self, front: &ConvexPolygon, thickness_m: f64) -> Vec<Point3<f64>> {
        let Some(view) = self.views.first().filter(|_| self.depth_m > 0.0) else {
            return self.prism_W(front, thickness_m.max(self.depth_m));
        };
        let mut points_W = self.prism_W(front, thickness_m);
        let height_m = self.height_of(&view.eye_W);
        // From behind the plane a view tells nothing of what the face hides.
        if height_m > 0.0 {
            let ratio = (self.depth_m / height_m).min(1.0);
            let corners = points_W[..front.vertices().len()].iter();
            let hidden: Vec<_> = corners.map(|p| p + (p - view.eye_W) * ratio).collect();
            points_W.extend(hidden);
        }
        points_W
    }

    /// The prism behind a convex part of the plane, in W.
    pub(crate) fn prism_W(&self, front: &ConvexPolygon, depth_m: f64) -> Vec<Point3<f64>> {
        let at = |z: f64| {
            let corners = front.vertices().iter();
            corners.map(move |p| self.X_WF * Point3::new(p.x, p.y, z))
        };
        at(0.0).chain(at(-depth_m)).collect()
    }
}

/// The point that is `depth_m` behind another, as seen from the eye.
pub(crate) fn behind_W(p_W: &Point3<f64>, eye_W: &Point3<f64>, depth_m: f64) -> Point3<f64> {
    p_W + (p_W - eye_W).try_normalize(0.0).unwrap_or_default() * depth_m
}

/// Convex polygons that cover a face's region but for specks, each widened by `edge_m`.
pub(crate) fn fronts(face: &Face, edge_m: f64) -> Vec<ConvexPolygon> {
    let mut fronts: Vec<ConvexPolygon> = Vec::new();
    for piece in cover(&face.region, &cover::BODIES).pieces {
        if cover::area_outside(&piece.polygon, &fronts) > REST_MAX_M2 || fronts.is_empty() {
            fronts.push(piece.polygon.grown(edge_m));
        }
    }
    fronts
}

/// The column behind a convex part of a face, without the rim where neighbours touch it.
pub(crate) fn column(piece: &ConvexPolygon) -> ConvexPolygon {
    piece.inset(TOUCH_M).unwrap_or_else(|| piece.clone())
}

/// Whether another face looks the opposite way, to 60°: it may be the far side of the same object.
pub(crate) fn is_far_side(face: &Face, other: &Face) -> bool {
    other.normal_W().dot(&face.normal_W()) < -0.5
}

/// The depth at which the far side of the same object, by its convex parts, ends columns behind a face, where
/// it does, m.
pub(crate) fn far_side_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    parts: &[impl AsRef<[Point2<f64>]>],
) -> Option<f64> {
    // The two sides of a sheet may lie in one plane.
    let entry_m = || entry_m(face, columns, other, parts, -DEPTH_MIN_M);
    let found = is_far_side(face, other).then(entry_m).flatten();
    found.map(|entry_m| entry_m.max(DEPTH_MIN_M))
}

/// The least depth, not less than `from_m`, at which another face, by its convex parts, is in one of the columns
/// behind a face.
fn entry_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    parts: &[impl AsRef<[Point2<f64>]>],
    from_m: f64,
) -> Option<f64> {
    let X_FO = face.X_WF.inverse() * other.X_WF;
    let of_part = |part: &[Point2<f64>]| {
        let at = |p: &Point2<f64>| X_FO * Point3::new(p.x, p.y, 0.0);
        let ring: Vec<Point3<f64>> = part.iter().map(at).collect();
        let ring = clip(&ring, |p| p.z + from_m);
        let depth_m = |column: &ConvexPolygon| {
            let mut ring = ring.clone();
            for HalfPlane { n, b } in column.half_planes() {
                if ring.is_empty() {
                    break;
                }
                ring = clip(&ring, |p| n.dot(&p.xy().coords) - b);
            }
            ring.iter().map(|p| -p.z).reduce(f64::min)
        };
        columns.iter().filter_map(depth_m).reduce(f64::min)
    };
    let found = parts.iter().filter_map(|part| of_part(part.as_ref()));
    found.reduce(f64::min)
}

/// The part of a convex ring in space where a linear function is not positive.
fn clip(ring: &[Point3<f64>], value: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (value_a, value_b) = (value(a), value(b));
        if value_a <= 0.0 {
            kept.push(*a);
        }
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            kept.push(a + (b - a) * (value_a / (value_a - value_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::face::faces;
    use crate::outline::Outline;

    proptest! {
        /// Prisms whose fronts lie in the plane and cover the region widened by what a scanned edge
        /// may be off; nothing of a body is before the plane.
        #[test]
        fn bodies_cover_a_face(face in faces(), thickness in 0.01..0.5, scanned: bool) {
            let mut face = face;
            face.source = if scanned { Source::Scan } else { Source::File };
            let bodies = face.bodies_W(thickness);
            let mut fronts = Outline::default();
            for body in &bodies {
                let (front, back) = body.split_at(body.len() / 2);
                for (p, q) in front.iter().zip(back) {
                    prop_assert!(face.height_of(p).abs() < 1e-9);
                    prop_assert!((q - p + face.normal_W() * thickness).norm() < 1e-9);
                }
                prop_assert!(face.is_behind(body, 1e-9));
                let ring = front.iter().map(|p| face.X_WF.inverse_transform_point(p));
                let ring = ring.map(|p| [p.x, p.y]).collect();
                fronts = fronts.union(&Outline::from_rings(&[ring]));
            }
            let region = Outline::from(&face.region);
            let left = region.minus(&fronts).area();
            prop_assert!(left <= 1e-5 * (1.0 + region.area()), "{left} m² bare");
            if !scanned {
                prop_assert!(fronts.minus(&region).area() < 1e-3 * (1.0 + region.area()));
            }
            face.source = Source::Mesh;
            prop_assert!(face.bodies_W(thickness).is_empty());
        }
    }
}
