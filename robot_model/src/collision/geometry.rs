//! The convex shapes that a link may have.

use nalgebra::{Point3, Vector3};

use super::hull::Hull;
use crate::GREATEST_M;

/// A convex shape in its own frame G: lengths along z_G, everything centred at G's origin but
/// the hull, whose vertices lie where they lie.
#[derive(Clone, Debug)]
pub enum ShapeGeometry {
    /// A ball.
    Sphere {
        /// Radius; m.
        radius_m: f64,
    },
    /// Everything within a radius of a segment along z_G.
    Capsule {
        /// Half of the segment's length, caps not included; m.
        half_length_m: f64,
        /// Radius; m.
        radius_m: f64,
    },
    /// A solid cylinder along z_G.
    Cylinder {
        /// Half of its length; m.
        half_length_m: f64,
        /// Radius; m.
        radius_m: f64,
    },
    /// A solid box.
    Box {
        /// Half extents along G's axes; m.
        half_extents_m: Vector3<f64>,
    },
    /// The convex hull of a point set, and everything within its [`Hull::shortfall_m`].
    ConvexHull(Hull),
}

impl ShapeGeometry {
    /// Why the dimensions are none of a solid, if so.
    pub fn flaw(&self) -> Option<String> {
        let positive = |name: &str, value: f64| {
            let fine = value > 0.0 && value <= GREATEST_M;
            (!fine)
                .then(|| format!("{name} is {value}, not a positive length up to {GREATEST_M} m"))
        };
        match self {
            ShapeGeometry::Sphere { radius_m } => positive("radius", *radius_m),
            ShapeGeometry::Capsule {
                half_length_m,
                radius_m,
            }
            | ShapeGeometry::Cylinder {
                half_length_m,
                radius_m,
            } => positive("radius", *radius_m).or_else(|| positive("length", 2.0 * half_length_m)),
            ShapeGeometry::Box { half_extents_m } => half_extents_m
                .iter()
                .find_map(|half| positive("size", 2.0 * half)),
            ShapeGeometry::ConvexHull(_) => None,
        }
    }

    /// The radius by which [`Self::core_support`]'s core is inflated.
    pub(crate) fn margin_m(&self) -> f64 {
        match self {
            ShapeGeometry::Sphere { radius_m } | ShapeGeometry::Capsule { radius_m, .. } => {
                *radius_m
            }
            ShapeGeometry::ConvexHull(hull) => hull.shortfall_m(),
            _ => 0.0,
        }
    }

    /// Half length of the core where it is a point (0) or a segment along z_G.
    pub(crate) fn segment_half_m(&self) -> Option<f64> {
        match self {
            ShapeGeometry::Sphere { .. } => Some(0.0),
            ShapeGeometry::Capsule { half_length_m, .. } => Some(*half_length_m),
            _ => None,
        }
    }

    /// The point of the shape's core (itself, without the rounding radius) farthest along `d`.
    pub(crate) fn core_support(&self, d: &Vector3<f64>) -> Point3<f64> {
        match self {
            ShapeGeometry::Sphere { .. } => Point3::origin(),
            ShapeGeometry::Capsule { half_length_m, .. } => {
                Point3::new(0.0, 0.0, half_length_m.copysign(d.z))
            }
            ShapeGeometry::Cylinder {
                half_length_m,
                radius_m,
            } => {
                let across = d.x.hypot(d.y);
                let scale = if across > 0.0 { radius_m / across } else { 0.0 };
                Point3::new(d.x * scale, d.y * scale, half_length_m.copysign(d.z))
            }
            ShapeGeometry::Box { half_extents_m } => half_extents_m
                .zip_map(d, |half, along| half.copysign(along))
                .into(),
            ShapeGeometry::ConvexHull(hull) => hull.support(d),
        }
    }

    /// The point of the shape farthest along `d` (need not be unit), in G.
    pub fn support(&self, d: &Vector3<f64>) -> Point3<f64> {
        let core = self.core_support(d);
        let margin = self.margin_m();
        match d.try_normalize(0.0) {
            Some(unit) if margin > 0.0 => core + unit * margin,
            _ => core,
        }
    }

    /// The corners of a box or hull in G; empty for the round shapes.
    pub fn vertices(&self) -> Vec<Point3<f64>> {
        match self {
            ShapeGeometry::Box { half_extents_m: h } => (0..8)
                .map(|corner| {
                    let sign = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
                    Point3::new(sign(1) * h.x, sign(2) * h.y, sign(4) * h.z)
                })
                .collect(),
            ShapeGeometry::ConvexHull(hull) => hull.vertices().to_vec(),
            _ => Vec::new(),
        }
    }

    /// Centre and half extents of the bounding box along G's axes.
    pub fn bounds(&self) -> (Point3<f64>, Vector3<f64>) {
        let extreme = |sign: f64| {
            Vector3::from_fn(|axis, _| self.support(&(Vector3::ith(axis, 1.0) * sign)).coords[axis])
        };
        let (high, low) = (extreme(1.0), extreme(-1.0));
        (((high + low) / 2.0).into(), (high - low) / 2.0)
    }
}
