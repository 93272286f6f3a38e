//! A contact patch inside a surface: Algorithm 1 of `brossette2013`.
//!
//! Both polygons run counter-clockwise about the common normal N, so a patch vertex p is inside
//! the surface when it is on the left of every edge q_l q_{l+1}, the closing edge included:
//!
//!   [(q_{l+1} − q_l) × (p_k − q_l)] · N ≥ 0,    k = 0 … n−1, l = 0 … m−1.
//!
//! Divided by the edge's length that is n_l · p_k − b_l ≤ 0, a distance in m with the unit outward
//! normal n_l; the solver gets it in this form.
//!
//! Source: `brossette2013` Algorithm 1; deviation: its product is turned round (the same
//! statement) and normalised.

use nalgebra::{Isometry2, Point2, Vector3};

use crate::{ConvexPolygon, HalfPlane, Surface};

/// The products as the paper writes them: inside when all are ≤ 0.
///
///   [(p_k − q_l) × (q_{l+1} − q_l)] · N
///
/// Shapes: n·m values, those of the first patch vertex first.  Units: m².  Frames: all in S.
#[allow(non_snake_case)]
pub fn products(patch_S: &[Point2<f64>], surface: &ConvexPolygon) -> Vec<f64> {
    let of_vertex = |p: &Point2<f64>| {
        let p = *p;
        surface.edges().map(move |(a, b)| (p - a).perp(&(b - a)))
    };
    patch_S.iter().flat_map(of_vertex).collect()
}

/// The distances n_l · p_k − b_l: inside when all are ≤ 0.
///
/// Shapes: n·m values, those of the first patch vertex first.  Units: m.  Frames: all in S.
#[allow(non_snake_case)]
pub fn values(patch_S: &[Point2<f64>], surface: &ConvexPolygon) -> Vec<f64> {
    let edges = surface.half_planes();
    let of_vertex = |p: &Point2<f64>| {
        let p = *p;
        edges.iter().map(move |edge| edge.value(&p))
    };
    patch_S.iter().flat_map(of_vertex).collect()
}

/// The smallest distance of a patch vertex from a surface edge's line, negative when one is
/// outside, m; infinite for a patch without vertices.
#[allow(non_snake_case)]
pub fn margin(patch_S: &[Point2<f64>], surface: &ConvexPolygon) -> f64 {
    -values(patch_S, surface)
        .into_iter()
        .fold(f64::NEG_INFINITY, f64::max)
}

/// One linearised inclusion constraint on a patch that moves in the plane.
///
///   value + gradient · (δx, δy, δψ) ≤ 0
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Index k of the patch vertex.
    pub vertex: usize,
    /// Index l of the surface edge.
    pub edge: usize,
    /// n_l · p_k − b_l at the present pose, m.
    pub value: f64,
    /// Its derivative by the position of C's origin in S (1, 1) and by C's heading (m/rad).
    pub gradient: [f64; 3],
}

/// The constraints on the pose of C in S, and their derivatives.
///
///   v_kl = n_l · (t + R(ψ) c_k) − b_l,   ∂v/∂t = n_l,   ∂v/∂ψ = n_l · R(ψ + π/2) c_k
///
/// Shapes: n·m rows, those of the first patch vertex first.  Units: m, rad.  Frames: `patch_C` in
/// C, the surface in S.
#[allow(non_snake_case)]
pub fn rows(patch_C: &[Point2<f64>], X_SC: &Isometry2<f64>, surface: &ConvexPolygon) -> Vec<Row> {
    let edges = surface.half_planes();
    let mut rows = Vec::with_capacity(patch_C.len() * edges.len());
    for (vertex, c) in patch_C.iter().enumerate() {
        let arm = X_SC.rotation * c.coords;
        let p = Point2::from(X_SC.translation.vector + arm);
        for (edge, HalfPlane { n, b }) in edges.iter().enumerate() {
            rows.push(Row {
                vertex,
                edge,
                value: n.dot(&p.coords) - b,
                gradient: [n.x, n.y, arm.perp(n)],
            });
        }
    }
    rows
}

/// The places where the patch lies inside the surface when C has the heading `yaw_rad` in S.
///
///   { t : n_l · t ≤ b_l − max_k n_l · R(ψ) c_k }
///
/// None when the patch does not fit at this heading. Frames: the result is in S.
#[allow(non_snake_case)]
pub fn placements(
    patch_C: &[Point2<f64>],
    yaw_rad: f64,
    surface: &ConvexPolygon,
) -> Option<ConvexPolygon> {
    let turned: Vec<_> = {
        let R_SC = nalgebra::Rotation2::new(yaw_rad);
        patch_C.iter().map(|c| R_SC * c).collect()
    };
    let tightened: Vec<HalfPlane> = surface
        .half_planes()
        .into_iter()
        .map(|HalfPlane { n, b }| {
            let reach = turned.iter().map(|c| n.dot(&c.coords));
            HalfPlane {
                n,
                b: b - reach.fold(f64::NEG_INFINITY, f64::max),
            }
        })
        .collect();
    // The surface itself may lie beyond the placements: C's origin need not be in the patch.
    let shift = turned.first()?.coords;
    let start: Vec<_> = surface.vertices().iter().map(|q| q - shift).collect();
    ConvexPolygon::new(start).ok()?.clip_all(&tightened)
}

/// A half space of W: { p_W : n_W · p_W ≤ b }, n_W a unit vector, b in m.
#[allow(non_snake_case)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Unit outward normal, in W.
    pub n_W: Vector3<f64>,
    /// Offset, m.
    pub b: f64,
}

/// One half space an edge of the surface's effective polygon, for a solver that works in W.
///
///   n_W = R_WS (n_l, 0),   b = b_l + n_W · p_WS
///
/// None when the inset leaves nothing of the polygon.
#[allow(non_snake_case)]
pub fn half_spaces_W(surface: &Surface) -> Option<Vec<HalfSpace>> {
    let polygon = surface.effective_polygon()?;
    let in_world = |HalfPlane { n, b }| {
        let n_W = surface.X_WS.rotation * Vector3::new(n.x, n.y, 0.0);
        HalfSpace {
            n_W,
            b: b + n_W.dot(&surface.X_WS.translation.vector),
        }
    };
    Some(polygon.half_planes().into_iter().map(in_world).collect())
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use nalgebra::{Isometry3, Vector2};
    use proptest::prelude::*;

    use super::*;
    use crate::polygon::tests::{points, polygons};

    fn turned(patch: &ConvexPolygon, X_SC: &Isometry2<f64>) -> Vec<Point2<f64>> {
        patch.vertices().iter().map(|c| X_SC * c).collect()
    }

    #[test]
    fn a_patch_over_the_closing_edge_is_outside() {
        // The unit square; only its closing edge (0, 1) → (0, 0) excludes the patch.
        let corners = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let surface = ConvexPolygon::try_from(corners).unwrap();
        let patch = [
            Point2::new(-0.1, 0.4),
            Point2::new(0.2, 0.4),
            Point2::new(0.2, 0.6),
        ];
        let positive: Vec<_> = values(&patch, &surface)
            .into_iter()
            .enumerate()
            .filter(|(_, v)| *v > 0.0)
            .collect();
        assert_eq!(positive, [(3, 0.1)]);
        assert_eq!(margin(&patch, &surface), -0.1);
    }

    #[test]
    fn half_spaces_agree_with_the_plane() {
        let corners = vec![[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]];
        let X_WS = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -0.4, 0.5));
        let mut surface = Surface::new("s", X_WS, corners.try_into().unwrap());
        surface.inset_m = 0.1;
        let p_S = Point2::new(0.2, -0.3);
        let p_W = surface.point_W(&p_S);
        let plane = values(&[p_S], &surface.effective_polygon().unwrap());
        let space = half_spaces_W(&surface).unwrap();
        for (value, h) in plane.iter().zip(&space) {
            approx::assert_relative_eq!(*value, h.n_W.dot(&p_W.coords) - h.b, epsilon = 1e-12);
        }
        surface.inset_m = 1.0;
        assert_eq!(half_spaces_W(&surface), None);
    }

    proptest! {
        #[test]
        fn inside_exactly_when_no_value_is_positive(
            surface in polygons(), patch in polygons(), x in -2.0..2.0, y in -2.0..2.0, size in 0.05..1.0,
        ) {
            let patch: Vec<_> = patch
                .vertices()
                .iter()
                .map(|c| Point2::from(c.coords * size + Vector2::new(x, y)))
                .collect();
            let all_values = values(&patch, &surface);
            prop_assert_eq!(all_values.len(), patch.len() * surface.vertices().len());
            let inside = all_values.iter().all(|v| *v <= 0.0);
            // Independent of the half planes: nothing of the patch is lost by the intersection.
            let patch = ConvexPolygon::new(patch).unwrap();
            let common = patch.intersection(&surface).map_or(0.0, |c| c.area());
            if inside {
                prop_assert!((common - patch.area()).abs() < 1e-9);
            } else if margin(patch.vertices(), &surface) < -1e-3 {
                prop_assert!(common < patch.area());
            }
            // The paper's products have the signs of the values.
            for (value, product) in all_values.iter().zip(products(patch.vertices(), &surface)) {
                prop_assert!(value * product >= 0.0 || value.abs() < 1e-12);
            }
        }

        #[test]
        fn rows_are_the_values_and_their_derivatives(
            surface in polygons(), patch in polygons(), x in -2.0..2.0, y in -2.0..2.0, yaw in -3.0..3.0,
        ) {
            let at = |x: f64, y: f64, yaw: f64| {
                let X_SC = Isometry2::new(Vector2::new(x, y), yaw);
                values(&turned(&patch, &X_SC), &surface)
            };
            let rows = rows(patch.vertices(), &Isometry2::new(Vector2::new(x, y), yaw), &surface);
            let here = at(x, y, yaw);
            let h = 1e-6;
            let by = [
                (at(x + h, y, yaw), at(x - h, y, yaw)),
                (at(x, y + h, yaw), at(x, y - h, yaw)),
                (at(x, y, yaw + h), at(x, y, yaw - h)),
            ];
            for (i, row) in rows.iter().enumerate() {
                prop_assert_eq!(i, row.vertex * surface.vertices().len() + row.edge);
                prop_assert!((row.value - here[i]).abs() < 1e-12);
                for (gradient, (after, before)) in row.gradient.iter().zip(&by) {
                    let difference = (after[i] - before[i]) / (2.0 * h);
                    // Central differences of a function with derivatives of a few metres.
                    prop_assert!((gradient - difference).abs() < 1e-7);
                }
            }
        }

        #[test]
        fn placements_are_where_the_patch_is_inside(
            surface in polygons(), patch in polygons(), size in 0.02..0.5, yaw in -3.0..3.0,
            places in points(20..21),
        ) {
            let patch: Vec<_> = patch.vertices().iter().map(|c| c * size).collect();
            let region = placements(&patch, yaw, &surface);
            for t in &places {
                let X_SC = Isometry2::new(t.coords, yaw);
                let moved: Vec<_> = patch.iter().map(|c| X_SC * c).collect();
                let depth = margin(&moved, &surface);
                let allowed = region.as_ref().is_some_and(|r| r.contains(t, 0.0));
                prop_assert!(!allowed || depth > -2e-6);
                prop_assert!(allowed || depth < 1e-4, "refused {depth} inside");
            }
        }
    }
}
