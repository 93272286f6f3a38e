//! The part of a face that is surely there, from what is known of its plane and its edges.
//!
//! A plane error (θ_x, θ_y, z) with the covariance Σ moves the plane's point p by
//!
//!   δ(p) = g · (θ_x, θ_y, z),   g = (y, −x, 1),   σ(p)² = gᵀ Σ g
//!
//! along the normal. An edge was seen along the rays to it. With the ray d (in F, d_z < 0) to a point
//! of it, a plane that is δ too high is met δ / d_z further along the ray, and the edge with outward
//! normal n moves in the plane by n · d_xy δ / d_z. The independent error of finding the edge in the
//! image, an angle σ_α, moves it by u σ_α. With k standard deviations, a further error f and the angle
//! ε by which the ring lies inside the true edge already:
//!
//!   σ_e = |n · d_xy / d_z| σ(p),   u = |d| |d × e| / |d_z|   (e the edge's direction),
//!   inset_e = max(0, √((k σ_e)² + (k u σ_α)² + f²) − u ε),   the largest of both ends and the middle.
//!
//! The border of the view is where it is: σ_α = ε = 0. Where another face rises nothing falls, and what keeps clear of
//! that face keeps clear of the edge: σ_e = 0 too.

use nalgebra::{Point2, Point3, Vector2};

use super::{EdgeView, Face};
use crate::covariance::sigma_at;
use crate::outline::Outline;
use crate::{Edge, EdgeKind};

/// An eye nearer to the plane than this sees nothing of its edges, m.
const EYE_MIN_M: f64 = 1e-3;

impl Face {
    /// The distance by which each edge may be nearer than it seems, m, ring by ring, with `k_sigma`
    /// standard deviations of what is known of plane and edges.
    pub fn edge_insets_m(&self, k_sigma: f64) -> Vec<Vec<f64>> {
        let of_edge = |(edge, ends): (&Edge, [&Point2<f64>; 2])| {
            let view = edge.view.and_then(|view| self.views.get(view));
            view.map_or(edge.further_m, |view| {
                self.inset_m(edge, ends, view, k_sigma)
            })
        };
        let rings = self.region.rings().iter();
        rings
            .map(|ring| ring.segments().map(of_edge).collect())
            .collect()
    }

    /// The inset of an edge between two vertices in a view, m.
    fn inset_m(&self, edge: &Edge, [a, b]: [&Point2<f64>; 2], view: &EdgeView, k: f64) -> f64 {
        let eye = self.X_WF.inverse_transform_point(&view.eye_W);
        let covariance = (view.plane_covariance.as_ref()).or(self.plane_covariance.as_ref());
        let along = (b - a).normalize();
        let at = |p: Point2<f64>| {
            let ray = Point3::new(p.x, p.y, 0.0) - Point3::new(eye.x, eye.y, eye.z.max(EYE_MIN_M));
            let slide = (along.y * ray.x - along.x * ray.y) / ray.z;
            let plane_m = k * slide.abs() * covariance.map_or(0.0, |c| sigma_at(c, &p));
            let per_rad = ray.norm() * ray.cross(&along.push(0.0)).norm() / -ray.z;
            let (image_m, inside_m) = match edge.kind {
                EdgeKind::FieldOfView | EdgeKind::Fold => (0.0, 0.0),
                _ => (k * view.sigma_rad * per_rad, edge.inside_rad * per_rad),
            };
            let plane_m = match edge.kind {
                EdgeKind::Fold => 0.0,
                _ => plane_m,
            };
            plane_m.hypot(image_m).hypot(edge.further_m) - inside_m
        };
        [*a, nalgebra::center(a, b), *b]
            .map(at)
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// The part of the region that is farther from every edge than that may be nearer than it seems
    /// ([`Self::edge_insets_m`]) plus `further_m`: one part or several, or none.
    ///
    /// Frames: in F, m.
    pub fn inset_region(&self, k_sigma: f64, further_m: f64) -> Outline {
        let mut insets_m = self.edge_insets_m(k_sigma);
        insets_m.iter_mut().flatten().for_each(|d| *d += further_m);
        if let ([distances_m], Some(convex)) = (&insets_m[..], self.region.as_convex()) {
            let inner = convex.inset_edges(distances_m);
            return inner.map_or_else(Outline::default, |inner| Outline::from_polygon(&inner));
        }
        let strips = (self.region.segments())
            .zip(insets_m.iter().flatten())
            .filter(|(_, d_m)| **d_m > 0.0)
            .map(|((_, ends), d_m)| strip(ends, *d_m));
        Outline::from(&self.region).minus_all(strips)
    }
}

/// An octagon's half at either end: a ring around all points within `d_m` of the segment, counter-
/// clockwise, nowhere farther from it than 1.09 `d_m`.
fn strip([a, b]: [&Point2<f64>; 2], d_m: f64) -> Vec<Point2<f64>> {
    let along = (b - a).normalize();
    let left = Vector2::new(-along.y, along.x);
    // Corners of a regular octagon around a circle of radius 1.
    let tip = std::f64::consts::FRAC_PI_8.tan();
    let corners = [[tip, -1.0], [1.0, -tip], [1.0, tip], [tip, 1.0]];
    let at = |end: &Point2<f64>, turn: f64, [x, y]: [f64; 2]| {
        end + (along * x + left * y) * (turn * d_m)
    };
    let of_end = |(end, turn)| corners.map(|corner| at(end, turn, corner));
    [(b, 1.0), (a, -1.0)].into_iter().flat_map(of_end).collect()
}

#[cfg(test)]
pub(crate) mod tests;
