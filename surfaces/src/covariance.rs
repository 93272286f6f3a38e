//! How far the uncertainty of a fitted plane moves its edges.
//!
//! The plane's errors (θ_x, θ_y, z) are small rotations about x_S and y_S and an offset along
//! z_S; they move the plane's point (x, y) along the normal by
//!
//!   δ(x, y) = θ_x y − θ_y x + z = g · (θ_x, θ_y, z),    g = (y, −x, 1),    σ² = gᵀ Σ g.
//!
//! An edge was seen along the rays to it. With the ray d (in S, d_z < 0) to a point of it, a plane that
//! is δ too high is met δ / d_z further along the ray, and the edge with outward normal n moves in the
//! plane by n · d_xy δ / d_z. The independent error of finding the edge in the image, an angle σ_α, moves
//! it by u σ_α. With k standard deviations, less the gap g to the outline and the angle ε by which that
//! lies inside the true edge already:
//!
//!   σ_l = |n_l · d_xy / d_z| σ(p),   u = |d| |d × e_l| / |d_z|   (e_l the edge's direction),
//!   inset_l = max(0, k √(σ_l² + (u σ_α)²) − u ε − g),   the largest of both ends and the middle.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Vector3};

use crate::{ConvexPolygon, EdgeKind, Error, Surface, edge};

/// Standard deviation along the normal at the plane's point `p`, m.
///
/// `covariance` of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
pub fn sigma_at(covariance: &[[f64; 3]; 3], p: &Point2<f64>) -> f64 {
    let sigma = Matrix3::from_fn(|i, j| covariance[i][j]);
    let g = Vector3::new(p.y, -p.x, 1.0);
    // Rounding can take the form below zero where the plane is known exactly.
    g.dot(&(sigma * g)).max(0.0).sqrt()
}

/// The covariance of the same plane in a frame whose origin is at `p` of the first, the axes alike.
pub fn carried(covariance: &[[f64; 3]; 3], p: &nalgebra::Vector2<f64>) -> [[f64; 3]; 3] {
    let sigma = Matrix3::from_fn(|i, j| covariance[i][j]);
    let carry = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, p.y, -p.x, 1.0);
    rows(&(carry * sigma * carry.transpose()))
}

/// The rows of a covariance, made symmetric to the last bit.
pub(crate) fn rows(sigma: &Matrix3<f64>) -> [[f64; 3]; 3] {
    let mean = |i, j| 0.5 * (sigma[(i, j)] + sigma[(j, i)]);
    std::array::from_fn(|i| std::array::from_fn(|j| mean(i, j)))
}

/// A plane as it looks from a frame C near it: (θ_x, θ_y, z) that would bring C's plane z = 0 onto
/// it, and their covariance. `None` where the plane leans by more than 60° in C.
///
///   Σ_C = T Σ_S Tᵀ,   T: the rotations turn with the axes, z is taken at C's origin
///
/// Frames: S on the plane with the covariance `sigma` of (rotation about x_S, about y_S, offset along
/// z_S): rad, rad, m.
#[allow(non_snake_case)]
pub fn plane_in(
    X_CS: &Isometry3<f64>,
    sigma: &Matrix3<f64>,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let n = X_CS.rotation * Vector3::z();
    if n.z < 0.5 {
        return None;
    }
    let origin = X_CS.translation.vector;
    let x = Vector3::new(-n.y / n.z, n.x / n.z, n.dot(&origin) / n.z);
    let (ex, ey) = (X_CS.rotation * Vector3::x(), X_CS.rotation * Vector3::y());
    let to_C = X_CS.rotation.inverse() * -origin;
    let carry = Matrix3::new(
        ex.x, ey.x, 0.0, //
        ex.y, ey.y, 0.0, //
        to_C.y, -to_C.x, 1.0,
    );
    let carried = carry * sigma * carry.transpose();
    Some((x, (carried + carried.transpose()) * 0.5))
}

/// The largest standard deviation along the normal anywhere on the polygon, m.
///
/// The variance is a convex function of the point, so a vertex has the largest.
pub fn sigma_max(covariance: &[[f64; 3]; 3], polygon: &ConvexPolygon) -> f64 {
    let at = |p| sigma_at(covariance, p);
    polygon.vertices().iter().map(at).fold(0.0, f64::max)
}

/// How the edges of a face were seen.
#[allow(non_snake_case)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeView<'a> {
    /// Where the sensor was, in W, m; on the free side of the surface.
    pub eye_W: Point3<f64>,
    /// Number k of standard deviations to keep off the edges.
    pub k: f64,
    /// Standard deviation σ_α of an edge's place in the image, as an angle, rad. Edges that the border
    /// of the view cuts have none: the border is where it is.
    pub sigma_rad: f64,
    /// Angle ε by which each edge of each ring of the outline lies inside the true one, rad, negative
    /// outside; zero where there is none. At edges that the view's border cuts it does not count.
    pub inside_rad: &'a [Vec<f64>],
    /// A further error of an edge's place, k standard deviations of it, m.
    pub further_m: f64,
}

/// Of the outline along an edge of a polygon the worst part of this size is left out: jags of it.
const JAGS: f64 = 0.25;

/// The distance by which each edge of the polygon may be nearer than it seems, m, in their order;
/// nothing at seams that are farther inside the outline than that.
///
/// A surface without a covariance has only the edges' own errors.
/// # Errors
/// [`Error::BadNumber`] when a number of the view is negative or not finite, or the eye is not on the
/// free side of the surface.
#[allow(non_snake_case)]
pub fn edge_insets_m(surface: &Surface, view: &EdgeView) -> Result<Vec<f64>, Error> {
    for (field, value) in [
        ("k", view.k),
        ("sigma_rad", view.sigma_rad),
        ("further_m", view.further_m),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(bad(field, value, "a finite number ≥ 0"));
        }
    }
    let eye = surface.X_WS.inverse_transform_point(&view.eye_W);
    if !(eye.z > 0.0 && eye.iter().all(|x| x.is_finite())) {
        return Err(bad("eye_W", eye.z, "above the surface"));
    }
    let seen: Vec<Seen> = (surface.polygon.edges())
        .map(|(a, b)| Seen::new(surface, &eye, [a, b]))
        .collect();
    let wanted = seen
        .iter()
        .map(|edge| edge.lack_m(view, EdgeKind::Real, 0.0));
    let reach_m = wanted.fold(edge::ALONG_M, f64::max);
    // What each edge lacks of the parts of the outline that bound the polygon there, and their lengths.
    let mut parts: Vec<(usize, f64, f64)> = Vec::with_capacity(8 * seen.len());
    let half_planes = surface.polygon.half_planes();
    edge::for_bounds(&half_planes, &surface.outline, reach_m, |ring, k, found| {
        let inside = view.inside_rad.get(ring).and_then(|ring| ring.get(k));
        let kind = surface.outline_edge(ring, k);
        let lack = seen[found.edge].lack_m(view, kind, inside.copied().unwrap_or(0.0));
        parts.push((found.edge, lack - found.gap_m, found.length_m));
    });
    if surface.outline.is_empty() {
        for (i, edge) in seen.iter().enumerate() {
            let kind = surface.polygon_edges.get(i).copied().unwrap_or_default();
            parts.push((i, edge.lack_m(view, kind, 0.0), 1.0));
        }
    }
    // Edge by edge, the largest first.
    parts.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let mut insets = vec![0.0; seen.len()];
    for parts in parts.chunk_by(|a, b| a.0 == b.0) {
        insets[parts[0].0] = worst(parts).max(0.0);
    }
    Ok(insets)
}

/// The largest of values but for [`JAGS`] of their weight, the largest first: edge, value, weight.
fn worst(parts: &[(usize, f64, f64)]) -> f64 {
    let mut left = JAGS * parts.iter().map(|(_, _, weight)| weight).sum::<f64>();
    for (_, value, weight) in parts {
        left -= weight;
        if left < 0.0 {
            return *value;
        }
    }
    parts.last().map_or(0.0, |(_, value, _)| *value)
}

/// An edge of a polygon as it is seen, at both ends and in the middle.
struct Seen {
    /// |n · d_xy / d_z| σ(p), m.
    across_m: [f64; 3],
    /// How far the edge moves with the angle at which it is seen, m/rad.
    per_rad: [f64; 3],
}

impl Seen {
    /// The edge between two corners, from an eye in S.
    fn new(surface: &Surface, eye: &Point3<f64>, [a, b]: [&Point2<f64>; 2]) -> Self {
        let along = (b - a).normalize();
        let places = [*a, nalgebra::center(a, b), *b];
        let ray = |p: &Point2<f64>| Point3::new(p.x, p.y, 0.0) - eye;
        let covariance = surface.plane_covariance.as_ref();
        let across = |p: Point2<f64>| {
            let ray = ray(&p);
            let slide = (along.y * ray.x - along.x * ray.y) / ray.z;
            slide.abs() * covariance.map_or(0.0, |c| sigma_at(c, &p))
        };
        let per_rad = |p: Point2<f64>| {
            let ray = ray(&p);
            ray.norm() * ray.cross(&along.push(0.0)).norm() / eye.z
        };
        Self {
            across_m: places.map(across),
            per_rad: places.map(per_rad),
        }
    }

    /// How much farther inside an edge of this kind should be that is `inside_rad` inside already, m.
    fn lack_m(&self, view: &EdgeView, kind: EdgeKind, inside_rad: f64) -> f64 {
        let places = self.across_m.iter().zip(&self.per_rad);
        let lack = |(across, per_rad): (&f64, &f64)| {
            let (own, inside) = match kind {
                EdgeKind::FieldOfView => (0.0, 0.0),
                _ => (view.k * view.sigma_rad * per_rad, inside_rad * per_rad),
            };
            let across = view.k * across;
            (across * across + own * own + view.further_m * view.further_m).sqrt() - inside
        };
        places.map(lack).fold(f64::NEG_INFINITY, f64::max)
    }
}

fn bad(field: &str, value: f64, expected: &'static str) -> Error {
    Error::BadNumber {
        field: field.into(),
        value,
        expected,
    }
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;

    fn surface() -> Surface {
        let corners = vec![[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]];
        let mut surface = Surface::new("s", Isometry3::identity(), corners.try_into().unwrap());
        let (tilt, height) = (0.01_f64.powi(2), 0.002_f64.powi(2));
        surface.plane_covariance =
            Some([[tilt, 0.0, 0.0], [0.0, 4.0 * tilt, 0.0], [0.0, 0.0, height]]);
        surface
    }

    /// An eye so far away that rays are parallel to `ray`, and angles too small to matter.
    fn from_afar(ray: Vector3<f64>, further_m: f64) -> EdgeView<'static> {
        EdgeView {
            eye_W: Point3::from(ray * -1e6),
            k: 2.0,
            sigma_rad: 0.0,
            inside_rad: &[],
            further_m,
        }
    }

    #[test]
    fn a_ray_along_the_normal_leaves_only_the_edge_error() {
        let view = from_afar(-Vector3::z(), 0.008);
        for inset in edge_insets_m(&surface(), &view).unwrap() {
            assert!((inset - 0.008).abs() < 1e-7);
        }
    }

    #[test]
    fn a_slanted_ray_moves_the_edges_it_crosses() {
        // Seen at 45° along +x: an error along the normal moves the x edges by as much.
        let view = from_afar(Vector3::new(1.0, 0.0, -1.0), 0.0);
        let insets = edge_insets_m(&surface(), &view).unwrap();
        let corner = (0.5_f64 * 0.01).hypot(1.0 * 0.02).hypot(0.002);
        approx::assert_relative_eq!(insets[1], 2.0 * corner, max_relative = 1e-5);
        assert!(insets[0] < 1e-6);
    }

    #[test]
    fn seams_keep_no_distance_and_an_edge_counts_the_gap_to_the_outline() {
        // The face goes on toward +x; toward +y its edge is 5 mm beyond the polygon's.
        let mut piece = surface();
        piece.outline = vec![vec![[-1.0, -0.5], [3.0, -0.5], [3.0, 0.505], [-1.0, 0.505]]];
        let view = from_afar(-Vector3::z(), 0.02);
        let insets = edge_insets_m(&piece, &view).unwrap();
        for (inset, expected) in insets.iter().zip([0.02, 0.0, 0.015, 0.02]) {
            assert!((inset - expected).abs() < 1e-6, "{insets:?}");
        }
    }

    #[test]
    fn what_lies_inside_counts_but_not_at_the_border_of_the_view() {
        // One metre above the middle: a milliradian is a millimetre at an edge below, more aside.
        let mut seen = surface();
        seen.plane_covariance = None;
        let corners = seen.polygon.vertices().iter();
        seen.outline = vec![corners.map(|v| [v.x, v.y]).collect()];
        let inside = |angle: f64| vec![vec![angle; 4]];
        let (some, more) = (inside(0.003), inside(0.01));
        let view = EdgeView {
            eye_W: Point3::new(0.0, 0.0, 1.0),
            k: 2.0,
            sigma_rad: 0.002,
            inside_rad: &some,
            further_m: 0.0,
        };
        let insets = edge_insets_m(&seen, &view).unwrap();
        // At a corner: |d| |d × e| = 1.5 · √1.25 and 1.5 · √2.
        approx::assert_relative_eq!(insets[0], 1.5e-3 * 1.25_f64.sqrt(), max_relative = 1e-9);
        approx::assert_relative_eq!(insets[1], 1.5e-3 * 2.0_f64.sqrt(), max_relative = 1e-9);
        // Farther inside than the errors are.
        let view = EdgeView {
            inside_rad: &more,
            ..view
        };
        assert_eq!(edge_insets_m(&seen, &view).unwrap(), [0.0; 4]);
        let view = EdgeView {
            inside_rad: &[],
            ..view
        };
        seen.set_outline_edges(vec![vec![EdgeKind::FieldOfView; 4]]);
        assert_eq!(edge_insets_m(&seen, &view).unwrap(), [0.0; 4]);
    }

    #[test]
    fn bad_views_are_refused_by_name() {
        let good = from_afar(-Vector3::z(), 0.004);
        let bad = [
            (
                EdgeView {
                    k: f64::NAN,
                    ..good
                },
                "k",
            ),
            (
                EdgeView {
                    sigma_rad: -1.0,
                    ..good
                },
                "sigma_rad",
            ),
            (
                EdgeView {
                    eye_W: Point3::new(0.0, 0.0, -1.0),
                    ..good
                },
                "eye_W",
            ),
        ];
        for (view, field) in bad {
            let error = edge_insets_m(&surface(), &view).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        }
    }

    proptest! {
        /// A covariance of rank one is one error: carried to another frame of the plane it is the
        /// error that the moved plane has there.
        #[test]
        fn a_plane_error_is_the_same_seen_from_elsewhere(
            at in prop::array::uniform2(-2.0..2.0_f64), yaw in -3.0..3.0_f64,
            e in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let error = Vector3::from(e) * 1e-4;
            let turn = Vector3::new(error.x, error.y, 0.0);
            let moved = Isometry3::new(Vector3::z() * error.z, turn);
            let X_SC = Isometry3::new(Vector3::new(at[0], at[1], 0.0), Vector3::z() * yaw);
            let X_CS = X_SC.inverse();
            let (x, sigma) = plane_in(&X_CS, &(error * error.transpose())).unwrap();
            prop_assert!(x.norm() < 1e-12);
            let (x, _) = plane_in(&(X_CS * moved), &Matrix3::zeros()).unwrap();
            // Second order in the error: 1e-8 times a few metres.
            prop_assert!((sigma - x * x.transpose()).norm() < 1e-7 * (1.0 + 1e3 * x.norm()));
            prop_assert!((sigma.diagonal().map(f64::sqrt) - x.abs()).norm() < 1e-7);
        }

        #[test]
        fn sigma_is_that_of_a_plane_moved_by_its_errors(
            x in -2.0..2.0, y in -2.0..2.0, a in -1.0..1.0, b in -1.0..1.0, c in -1.0..1.0,
        ) {
            // A covariance of rank one is one error vector; move the plane by it, exactly.
            let error = Vector3::new(a, b, c) * 1e-4;
            let outer = error * error.transpose();
            let covariance = [0, 1, 2].map(|i| [0, 1, 2].map(|j| outer[(i, j)]));
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(error.x, error.y, 0.0));
            let moved = turn * Vector3::new(x, y, 0.0) + Vector3::z() * error.z;
            // Second order in the error: 1e-8 times a few metres.
            let sigma = sigma_at(&covariance, &Point2::new(x, y));
            prop_assert!((sigma - moved.z.abs()).abs() < 1e-7);
        }
    }
}
