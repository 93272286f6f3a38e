//! Shrinking a polygon, and the largest circle in it.

use nalgebra::Point2;

use super::ConvexPolygon;

impl ConvexPolygon {
    /// The points at least `d_m` inside every edge; None when there is no area left.
    ///
    ///   { p : n_l · p ≤ b_l − d }
    ///
    /// `d_m` in m, not negative: a negative or non-finite distance gives None.
    pub fn inset(&self, d_m: f64) -> Option<Self> {
        self.inset_edges(&vec![d_m; self.vertices.len()])
    }

    /// As [`Self::inset`], with a distance of its own for each edge, in the order of the edges.
    ///
    /// None also when the number of distances is not the number of edges.
    pub fn inset_edges(&self, distances_m: &[f64]) -> Option<Self> {
        let allowed = |d: &f64| *d >= 0.0 && d.is_finite();
        if distances_m.len() != self.vertices.len() || !distances_m.iter().all(allowed) {
            return None;
        }
        let mut half_planes = self.half_planes();
        for (half_plane, d) in half_planes.iter_mut().zip(distances_m) {
            half_plane.b -= d;
        }
        self.clip_all(&half_planes)
    }

    /// Centre and radius of a largest circle in the polygon, m.
    ///
    /// Found by bisection on the inset: the inset is empty beyond the radius.
    pub fn inscribed_circle(&self) -> (Point2<f64>, f64) {
        // No inset survives half of the width across any edge, hence not the largest extent.
        let mut empty = self.radius_about(&self.vertices[0]);
        let mut radius = 0.0;
        let mut core = self.clone();
        while empty - radius > 1e-9 * empty {
            let middle = 0.5 * (empty + radius);
            match self.inset(middle) {
                Some(smaller) => (radius, core) = (middle, smaller),
                None => empty = middle,
            }
        }
        let centre = core.centroid();
        let radius = self
            .half_planes()
            .iter()
            .map(|h| -h.value(&centre))
            .fold(f64::INFINITY, f64::min);
        (centre, radius)
    }
}
