//! Convex polygons in a surface's plane: the shape of everything that can be stood on.
//!
//! Vertices run counter-clockwise about the outward normal, so the interior is on the left of
//! every edge and the polygon is an intersection of half planes,
//!
//!   { p : n_l · p ≤ b_l, l = 0 … m−1 }.

mod clip;
mod grow;
mod hull;
mod inset;
mod simplify;
#[cfg(test)]
pub(crate) mod tests;
mod validate;

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::Error;
pub(crate) use clip::{centroid, clean_ring, clip_ring, ring_area};
pub(crate) use validate::check_width;

/// Two vertices nearer than this are the same point, m.
///
/// An edge must be long enough for its direction to mean something: with coordinates of some
/// metres in `f64` (rounding about 1e-15 m) and in files with six decimals, a micrometre is.
pub const VERTEX_SEPARATION_M: f64 = 1e-6;

/// A vertex this near to the line through its neighbours is on it, up to rounding, m.
const FLAT_M: f64 = 1e-9;

/// Half of the plane: { p : n · p ≤ b }.
///
/// `n` is a unit vector that points out of the half plane; `b` is in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// Unit outward normal n.
    pub n: Vector2<f64>,
    /// Offset b, m.
    pub b: f64,
}

impl HalfPlane {
    /// The half plane on the left of the line from `a` to `b`, which must differ.
    #[inline]
    pub fn left_of(a: &Point2<f64>, b: &Point2<f64>) -> Self {
        let edge = b - a;
        let n = Vector2::new(edge.y, -edge.x) / edge.norm();
        Self {
            n,
            b: n.dot(&a.coords),
        }
    }

    /// The half plane on the other side of the same line.
    pub fn flipped(&self) -> Self {
        Self {
            n: -self.n,
            b: -self.b,
        }
    }

    /// n · p − b: the distance of `p` from the boundary line, positive outside, m.
    #[inline]
    pub fn value(&self, p: &Point2<f64>) -> f64 {
        self.n.dot(&p.coords) - self.b
    }
}

/// A convex polygon with counter-clockwise vertices, in m; valid by construction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct ConvexPolygon {
    vertices: Vec<Point2<f64>>,
}

impl ConvexPolygon {
    /// The polygon with the given vertices, refused unless it is convex and counter-clockwise.
    ///
    /// A vertex may lie on the line through its neighbours.
    /// # Errors
    /// [`Error::Shape`] naming the vertex at fault: fewer than 3, one beyond the world or at the place of another
    /// (nearer than [`VERTEX_SEPARATION_M`]), all on one line, clockwise, not convex, crossing themselves.
    pub fn new(vertices: Vec<Point2<f64>>) -> Result<Self, Error> {
        validate::check(&vertices)?;
        Ok(Self { vertices })
    }

    /// The polygon that a cleaned ring gives, if it still has an area.
    pub(crate) fn from_ring(ring: Vec<Point2<f64>>) -> Option<Self> {
        Self::new(clean_ring(ring, FLAT_M)).ok()
    }

    /// The vertices, counter-clockwise, in m.
    pub fn vertices(&self) -> &[Point2<f64>] {
        &self.vertices
    }

    /// The edges as pairs of consecutive vertices, the closing edge last.
    pub fn edges(&self) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next)
    }

    /// The area, m².
    pub fn area(&self) -> f64 {
        ring_area(&self.vertices)
    }

    /// The centroid of the area, m.
    pub fn centroid(&self) -> Point2<f64> {
        centroid(self.edges().map(|(a, b)| [a, b]))
    }

    /// One half plane an edge, in the order of [`Self::edges`]; the polygon is their intersection.
    pub fn half_planes(&self) -> Vec<HalfPlane> {
        self.edges()
            .map(|(a, b)| HalfPlane::left_of(a, b))
            .collect()
    }

    /// Whether `p` is on the inner side of every edge, up to `tol` in m.
    pub fn contains(&self, p: &Point2<f64>, tol: f64) -> bool {
        self.edges()
            .all(|(a, b)| HalfPlane::left_of(a, b).value(p) <= tol)
    }

    /// The Euclidean distance of `p` from the boundary: positive outside, negative inside, m.
    pub fn signed_distance(&self, p: &Point2<f64>) -> f64 {
        let distance = self
            .edges()
            .map(|(a, b)| {
                let edge = b - a;
                let along = (edge.dot(&(p - a)) / edge.norm_squared()).clamp(0.0, 1.0);
                (p - (a + edge * along)).norm()
            })
            .fold(f64::INFINITY, f64::min);
        if self.contains(p, 0.0) {
            -distance
        } else {
            distance
        }
    }

    /// The largest distance from `centre` to a vertex, m.
    pub fn radius_about(&self, centre: &Point2<f64>) -> f64 {
        self.vertices
            .iter()
            .map(|v| (v - centre).norm())
            .fold(0.0, f64::max)
    }
}

impl TryFrom<Vec<[f64; 2]>> for ConvexPolygon {
    type Error = Error;

    fn try_from(vertices: Vec<[f64; 2]>) -> Result<Self, Error> {
        Self::new(vertices.into_iter().map(Point2::from).collect())
    }
}

impl From<ConvexPolygon> for Vec<[f64; 2]> {
    fn from(polygon: ConvexPolygon) -> Self {
        polygon.vertices.iter().map(|v| [v.x, v.y]).collect()
    }
}
