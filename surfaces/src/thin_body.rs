//! The body behind a surface, for collision avoidance.
//!
//! `brossette2013` extrudes each surface by a few centimetres against its normal. A distance
//! algorithm that finds a link past the middle of so thin a body pushes it out at the far side, so
//! a body should be as deep as what is known allows: not into space that is known to be free, and
//! not through the far side of the object.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::polygon::HalfPlane;
use crate::{ConvexPolygon, Surface};

/// A surface's polygon extruded against its normal: a convex prism.
#[allow(non_snake_case)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThinBody {
    /// Id of the surface.
    pub surface: String,
    /// The n vertices of the polygon in W, then the same n shifted by the thickness, m.
    pub points_W: Vec<Point3<f64>>,
}

impl ThinBody {
    /// The prism of depth `thickness_m` behind the surface.
    ///
    ///   { p_W − t z_S : p in the polygon ⊕ edge, 0 ≤ t ≤ thickness }
    ///
    /// Shapes: 2n points.  Units: m.  Frames: W.
    /// Source: `brossette2013` section IV-B, widened by what the face may go on beyond its polygon.
    #[allow(non_snake_case)]
    pub fn new(surface: &Surface, thickness_m: f64) -> Self {
        let inward: Vector3<f64> = -surface.normal_W() * thickness_m;
        let front: Vec<Point3<f64>> = surface
            .polygon
            .grown(surface.edge_m)
            .vertices()
            .iter()
            .map(|v| surface.point_W(v))
            .collect();
        let back = front.iter().map(|p| p + inward);
        Self {
            surface: surface.id.clone(),
            points_W: front.iter().copied().chain(back).collect(),
        }
    }
}

/// How deep the bodies behind surfaces are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Depth that every object is taken to have, m.
    pub thickness_m: f64,
    /// Depth of a body behind which nothing is known, m; not more than `thickness_m` where bodies
    /// shall be thin.
    pub depth_max_m: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            thickness_m: 0.03,
            depth_max_m: 0.25,
        }
    }
}

/// What is this near to the body's faces touches it and does not bound it, m: the noise of
/// neighbouring surfaces, such as the riser under the front edge of a tread.
const TOUCH_M: f64 = 0.02;
/// The least depth of a body whose far side is known, m: it must stay a body.
const DEPTH_MIN_M: f64 = 1e-3;

/// How deep the body behind `surface` can be without reaching through known space, m.
///
/// - A surface that looks the opposite way is the far side of the object: the body ends there,
///   be it thinner than `thickness_m`.
/// - Any other surface under this one was seen past its edge, so the space between is free, at
///   least in part: the body is `thickness_m` deep.
/// - It ends before a point that is known to be free, but is at least `thickness_m` deep.
/// - Otherwise it is `depth_max_m` deep.
///
/// `others` may contain the surface itself, and pieces of the same plane.
#[allow(non_snake_case)]
pub fn depth_m(
    surface: &Surface,
    others: &[Surface],
    free_W: &[Point3<f64>],
    config: &Config,
) -> f64 {
    let wanted = config.depth_max_m.max(config.thickness_m);
    // The column behind the polygon, without the rim where neighbours touch it.
    let core = surface.polygon.inset(TOUCH_M);
    let column = core.as_ref().unwrap_or(&surface.polygon);
    let mut depth = wanted;
    for other in others {
        let along = other.normal_W().dot(&surface.normal_W());
        // Within 60° of the opposite direction: the other side of the same object.
        let far_side = along < -0.5;
        // The two sides of a sheet may lie in one plane.
        let touch = if far_side { -DEPTH_MIN_M } else { TOUCH_M };
        if let Some(entry) = entry_depth(surface, column, other, touch)
            && entry < wanted
        {
            let limit = if far_side {
                entry.max(DEPTH_MIN_M)
            } else {
                config.thickness_m
            };
            depth = depth.min(limit);
        }
    }
    for p_W in free_W {
        let p_S = surface.X_WS.inverse_transform_point(p_W);
        if -p_S.z > TOUCH_M && column.contains(&p_S.xy(), 0.0) {
            depth = depth.min((-p_S.z).max(config.thickness_m));
        }
    }
    depth
}

/// The least depth, not less than `touch_m`, at which another polygon is in the column.
fn entry_depth(
    surface: &Surface,
    column: &ConvexPolygon,
    other: &Surface,
    touch_m: f64,
) -> Option<f64> {
    let inverse = surface.X_WS.inverse();
    let mut ring: Vec<Point3<f64>> = other.vertices_W().iter().map(|p| inverse * p).collect();
    for HalfPlane { n, b } in column.half_planes() {
        ring = clip(&ring, |p| n.dot(&p.xy().coords) - b);
    }
    ring = clip(&ring, |p| p.z + touch_m);
    ring.iter().map(|p| -p.z).reduce(f64::min)
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
    use nalgebra::Isometry3;
    use proptest::prelude::*;

    use super::*;
    use crate::polygon::tests::polygons;

    /// A square of the given half width whose normal is turned by `roll` about W's x axis.
    fn square(id: &str, half: f64, at: [f64; 3], roll: f64) -> Surface {
        let corners = vec![[-half, -half], [half, -half], [half, half], [-half, half]];
        let pose = Isometry3::new(at.into(), Vector3::x() * roll);
        Surface::new(id, pose, corners.try_into().unwrap())
    }

    fn depth(others: &[Surface], free: &[Point3<f64>]) -> f64 {
        let table = square("table", 0.4, [0.0, 0.0, 0.7], 0.0);
        let config = Config {
            depth_max_m: 1.0,
            ..Config::default()
        };
        depth_m(&table, others, free, &config)
    }

    #[test]
    fn unknown_space_is_filled_and_known_space_is_not() {
        use std::f64::consts::{FRAC_PI_2, PI};
        let table = square("table", 0.4, [0.0, 0.0, 0.7], 0.0);
        let floor_under = square("floor", 0.5, [0.6, 0.0, 0.0], 0.0);
        let floor_beside = square("floor", 0.5, [0.95, 0.0, 0.0], 0.0);
        let underside = square("under", 0.4, [0.0, 0.0, 0.68], PI);
        // The front of a box below: its top edge touches the rim of the column.
        let riser = square("riser", 0.35, [0.0, -0.4, 0.35], FRAC_PI_2);
        let riser_inside = square("riser", 0.35, [0.0, -0.2, 0.35], FRAC_PI_2);
        let wall_behind = square("wall", 2.0, [0.0, 0.5, 1.0], FRAC_PI_2);
        assert_eq!(depth(&[], &[]), 1.0);
        assert_eq!(depth(&[table, floor_beside, riser, wall_behind], &[]), 1.0);
        assert_eq!(depth(&[floor_under], &[]), 0.03);
        assert_eq!(depth(&[riser_inside], &[]), 0.03);
        approx::assert_relative_eq!(depth(&[underside], &[]), 0.02, epsilon = 1e-12);
    }

    #[test]
    fn free_points_bound_the_body() {
        let under = Point3::new(0.1, 0.1, 0.5);
        let just_under = Point3::new(0.1, 0.1, 0.675);
        let above = Point3::new(0.1, 0.1, 0.9);
        let beside = Point3::new(0.5, 0.1, 0.5);
        approx::assert_relative_eq!(depth(&[], &[under, above, beside]), 0.2, epsilon = 1e-12);
        assert_eq!(depth(&[], &[just_under]), 0.03);
    }

    proptest! {
        #[test]
        fn a_body_has_its_top_face_in_the_surface_and_its_thickness_behind(
            polygon in polygons(), turn in prop::array::uniform3(-2.0..2.0), thickness in 0.01..0.5,
        ) {
            let pose = Isometry3::new(Vector3::new(1.0, -2.0, 0.5), turn.into());
            let surface = Surface::new("s", pose, polygon);
            let body = surface.thin_body(thickness);
            let count = surface.polygon.vertices().len();
            prop_assert_eq!(body.points_W.len(), 2 * count);
            prop_assert_eq!(&body.points_W[..count], &surface.vertices_W()[..]);
            for p in &body.points_W[..count] {
                prop_assert!(surface.height_of(p).abs() < 1e-12);
            }
            for p in &body.points_W[count..] {
                prop_assert!((surface.height_of(p) + thickness).abs() < 1e-12);
            }
            prop_assert!(surface.is_behind(&body.points_W, 1e-9));
            prop_assert!(!surface.is_behind(&body.points_W, -0.5 * thickness));
        }
    }
}
