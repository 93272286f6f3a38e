//! Convex bodies that distances are measured between.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Matrix4, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::SupportMap;

use crate::posture::column;

/// A convex body in a frame of its own: points, with all that is within a radius of each across an
/// axis, inflated by another radius.
pub(crate) struct Solid {
    points: Vec<Vector3<f64>>,
    axis: Vector3<f64>,
    disc: f64,
    radius: f64,
    centre: Vector3<f64>,
    reach: f64,
}

impl Solid {
    /// The hull of points inflated by a radius: a ball of one, a capsule of two; m.
    pub fn hull(points: impl IntoIterator<Item = Vector3<f64>>, radius: f64) -> Self {
        Self::new(points, &Vector3::z(), 0.0, radius)
    }

    /// The hull of points, with all that is within a radius of it across a unit axis: a cylinder of
    /// two; m.
    pub fn widened(
        points: impl IntoIterator<Item = Vector3<f64>>,
        axis: &Vector3<f64>,
        radius: f64,
    ) -> Self {
        Self::new(points, axis, radius, 0.0)
    }

    fn new(
        points: impl IntoIterator<Item = Vector3<f64>>,
        axis: &Vector3<f64>,
        disc: f64,
        radius: f64,
    ) -> Self {
        let points: Vec<Vector3<f64>> = points.into_iter().collect();
        let (low, high) = extremes(points.iter().copied());
        let centre = match points.is_empty() {
            true => Vector3::zeros(),
            false => (low + high) / 2.0,
        };
        let far = |p: &Vector3<f64>| {
            let along = (p - centre).dot(axis);
            let across = ((p - centre) - axis * along).norm() + disc;
            along.hypot(across)
        };
        let reach = points.iter().map(far).fold(0.0, f64::max) + radius;
        let axis = *axis;
        Self {
            points,
            axis,
            disc,
            radius,
            centre,
            reach,
        }
    }

    /// What of the body is farther than a length, m, from a point along the direction from there to the body's middle;
    /// nothing where it has none.
    pub fn beyond(&self, from: &Vector3<f64>, farther_m: f64) -> Option<Self> {
        let along = (self.centre - from).try_normalize(0.0)?;
        let least_m = farther_m + self.disc + self.radius;
        let points = over(&self.points, |p| (p - from).dot(&along) - least_m);
        let rest = Self::new(points, &self.axis, self.disc, self.radius);
        (!rest.points.is_empty()).then_some(rest)
    }

    /// The body where the pose of its frame puts it.
    pub fn at(&self, X: &Matrix4<f64>) -> Placed<'_> {
        Placed {
            solid: self,
            turn: X.fixed_view::<3, 3>(0, 0).into_owned(),
            origin: column(X, 3),
        }
    }

    /// The body where it is.
    pub fn here(&self) -> Placed<'_> {
        self.at(&Matrix4::identity())
    }

    /// Centre and radius of a ball that holds the body, in its frame, m.
    pub fn ball(&self) -> Ball {
        (self.centre, self.reach)
    }

    /// A point of the core that is farthest along a direction, in the body's frame.
    fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let mut best = Vector3::zeros();
        let mut most = f64::NEG_INFINITY;
        for p in &self.points {
            let along = p.dot(direction);
            if along > most {
                (best, most) = (*p, along);
            }
        }
        if self.disc == 0.0 {
            return best;
        }
        // Along the axis, what is left across it is rounding, and not even across it.
        let across = direction - self.axis * self.axis.dot(direction);
        if across.norm() > 1e-9 * direction.norm() {
            best += across.normalize() * self.disc;
        }
        best
    }
}

/// Points whose hull is what of the hull of points has a height, which is affine, that is not negative.
pub(crate) fn over(
    points: &[Vector3<f64>],
    height: impl Fn(&Vector3<f64>) -> f64,
) -> Vec<Vector3<f64>> {
    let heights = points.iter().map(|p| (*p, height(p)));
    let (high, low): (Vec<_>, Vec<_>) = heights.partition(|(_, height)| *height >= 0.0);
    let cut = high.iter().flat_map(|(p, above)| {
        let down = low.iter();
        down.map(move |(q, below)| p + (q - p) * (above / (above - below)))
    });
    cut.chain(high.iter().map(|(p, _)| *p)).collect()
}

/// A convex body in W.
pub(crate) struct Placed<'a> {
    solid: &'a Solid,
    turn: Matrix3<f64>,
    origin: Vector3<f64>,
}

impl Placed<'_> {
    /// What its core is inflated by, m.
    pub fn radius(&self) -> f64 {
        self.solid.radius
    }

    /// A point of the core that is farthest along a direction, in W.
    pub fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.turn * self.solid.farthest(&self.turn.tr_mul(direction)) + self.origin
    }

    /// How far a point of the body is at most from where it was in another place, m.
    pub fn moved_from(&self, other: &Placed) -> f64 {
        let turned = (self.turn - other.turn).norm() * FRAC_1_SQRT_2;
        (self.ball().0 - other.ball().0).norm() + turned * self.solid.reach
    }

    /// Centre and radius of a ball that holds the body, m.
    pub fn ball(&self) -> Ball {
        (
            self.turn * self.solid.centre + self.origin,
            self.solid.reach,
        )
    }
}

impl SupportMap for Placed<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        vector(&self.farthest(&Vector3::new(direction.x, direction.y, direction.z)))
    }
}

/// Centre and radius of a ball around a body, m.
pub(crate) type Ball = (Vector3<f64>, f64);

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// The lowest and the highest corner of the box along the axes around points.
pub(crate) fn extremes(points: impl Iterator<Item = Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let far = Vector3::repeat(f64::INFINITY);
    points.fold((far, -far), |(low, high), p| (low.inf(&p), high.sup(&p)))
}
