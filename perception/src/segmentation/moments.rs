//! What is summed up over points to fit planes to them.

/// Sums over points that a least-squares plane needs. Those of disjoint sets add: no other pass over the
/// points is needed to fit the plane of a union, or to ask how well any plane fits it.
pub(crate) trait Moments: Copy + Default {
    /// A plane, in the coordinates that residuals are taken in.
    type Plane: Copy;
    /// Adds another set, each of its points counted `weight` times.
    fn add(&mut self, other: &Self, weight: f64);
    /// Number of points.
    fn count(&self) -> f64;
    /// The least-squares plane; `None` where the points do not span one.
    fn plane(&self) -> Option<Self::Plane>;
    /// Mean square of the points' residuals from a plane.
    fn mean_square(&self, plane: &Self::Plane) -> f64;
}
