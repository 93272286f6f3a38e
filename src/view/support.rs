//! Where the centre of mass may stand in static equilibrium.
//!
//!   R = { (c_x, c_y) : Σ f = −m g,  Σ (p − c) × f = 0,  f in the friction cone at every p }
//!
//! R is convex and does not depend on c_z. It is found from its support function, a linear
//! program for each direction, refined where the outer and the inner approximation differ.
//! Source: [bretl2008] Algorithm 1; deviation: cones become pyramids of eight edges inscribed in
//! them, and R is cut off at [`REACH_M`] from the contacts, since it may be unbounded.

use std::f64::consts::TAU;

use microlp::{ComparisonOp, LinearExpr, OptimizationDirection, Problem, Variable};
use nalgebra::{Point2, Point3, Vector2, Vector3};

/// Edges of a friction pyramid.
const EDGES: usize = 8;
/// R is cut off where it is further than this from the contacts' middle, m.
const REACH_M: f64 = 2.0;
/// R is refined until it is known to this distance, m; it is drawn at some 300 pixels a metre.
const TOLERANCE_M: f64 = 0.0005;
/// Refinements of an edge by its middle, one within the other.
const DEPTH_MAX: usize = 6;

/// A contact that may push.
pub(super) struct LoadedContact {
    /// Where forces may act, in W, m.
    pub points_W: Vec<Point3<f64>>,
    /// The axis of the friction cones, in W.
    pub normal_W: Vector3<f64>,
    /// Coefficient of friction.
    pub friction: f64,
}

/// Corners of R, counter-clockwise; fewer than three where R is a point or a line; None where no
/// place of the centre of mass is in equilibrium.
pub(super) fn support_region(contacts: &[LoadedContact]) -> Option<Vec<Point2<f64>>> {
    let cones = Cones::of(contacts)?;
    let start = (0..4).map(|k| cones.farthest(&unit(TAU * k as f64 / 4.0)));
    let start = start.collect::<Option<Vec<_>>>()?;
    let mut corners = Vec::new();
    for (k, a) in start.iter().enumerate() {
        corners.push(*a);
        cones.refine(a, &start[(k + 1) % start.len()], DEPTH_MAX, &mut corners);
    }
    Some(without_repeats(corners))
}

/// Edges g of the friction pyramids at points p, as what each unit of force along them does.
struct Cones {
    /// The contacts' middle r, about which moments are taken.
    middle: Vector2<f64>,
    forces: Vec<Vector3<f64>>,
    /// (p − r) × g.
    moments: Vec<Vector3<f64>>,
}

impl Cones {
    /// None when no point can push.
    fn of(contacts: &[LoadedContact]) -> Option<Self> {
        let points: Vec<_> = contacts.iter().flat_map(|c| &c.points_W).collect();
        if points.is_empty() {
            return None;
        }
        let middle = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
        let (mut forces, mut moments) = (Vec::new(), Vec::new());
        for contact in contacts {
            let aside = least_aligned_axis(&contact.normal_W);
            let tangent = contact.normal_W.cross(&aside).normalize();
            let bitangent = contact.normal_W.cross(&tangent);
            for p in &contact.points_W {
                for k in 0..EDGES {
                    let (sin, cos) = (TAU * k as f64 / EDGES as f64).sin_cos();
                    let g = contact.normal_W + contact.friction * (tangent * cos + bitangent * sin);
                    forces.push(g);
                    moments.push((p.coords - middle).cross(&g));
                }
            }
        }
        Some(Self {
            middle: middle.xy(),
            forces,
            moments,
        })
    }

    /// The place of the centre of mass in equilibrium that is farthest along `direction`.
    ///
    /// With the weight as the unit of force, Σ λ_k g_k = ẑ and Σ λ_k m_k = (c − r) × ẑ, so
    /// c − r = (−Σ λ_k m_k,y, Σ λ_k m_k,x): the objective is linear in λ.
    fn farthest(&self, direction: &Vector2<f64>) -> Option<Point2<f64>> {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let shift = |m: &Vector3<f64>| Vector2::new(-m.y, m.x);
        let lambda = self.moments.iter();
        let lambda: Vec<Variable> = lambda
            .map(|m| problem.add_var(direction.dot(&shift(m)), (0.0, f64::INFINITY)))
            .collect();
        let row = |values: &mut dyn Iterator<Item = f64>| {
            let mut terms = LinearExpr::empty();
            for (&variable, value) in lambda.iter().zip(values) {
                // Smaller ones are the rounding of sines and cosines.
                if value.abs() > 1e-12 {
                    terms.add(variable, value);
                }
            }
            terms
        };
        for (axis, wanted) in [(0, 0.0), (1, 0.0), (2, 1.0)] {
            let sum = row(&mut self.forces.iter().map(|g| g[axis]));
            problem.add_constraint(sum, ComparisonOp::Eq, wanted);
        }
        let twist = row(&mut self.moments.iter().map(|m| m.z));
        problem.add_constraint(twist, ComparisonOp::Eq, 0.0);
        for axis in 0..2 {
            for (bound, side) in [(REACH_M, ComparisonOp::Le), (-REACH_M, ComparisonOp::Ge)] {
                let sum = row(&mut self.moments.iter().map(|m| shift(m)[axis]));
                problem.add_constraint(sum, side, bound);
            }
        }
        let solution = problem.solve().ok()?.into_solution().ok()?;
        let shifts = lambda.iter().zip(&self.moments);
        let shifts = shifts.map(|(&k, m)| shift(m) * solution.var_value(k));
        Some(Point2::from(self.middle + shifts.sum::<Vector2<f64>>()))
    }

    /// Appends the corners between neighbours `a` and `b` (counter-clockwise), both left out.
    fn refine(
        &self,
        a: &Point2<f64>,
        b: &Point2<f64>,
        depth: usize,
        corners: &mut Vec<Point2<f64>>,
    ) {
        let edge = b - a;
        if depth == 0 || edge.norm() < TOLERANCE_M {
            return;
        }
        let outward = Vector2::new(edge.y, -edge.x).normalize();
        let Some(c) = self.farthest(&outward) else {
            return;
        };
        if outward.dot(&(c - a)) > TOLERANCE_M {
            self.refine(a, &c, depth - 1, corners);
            corners.push(c);
            self.refine(&c, b, depth - 1, corners);
        }
    }
}

fn unit(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// The axis of W that a direction has least of.
fn least_aligned_axis(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

/// Corners that several directions found are kept once.
fn without_repeats(corners: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    let mut kept: Vec<Point2<f64>> = Vec::with_capacity(corners.len());
    for corner in corners {
        if kept.iter().all(|k| (k - corner).norm() > 0.5 * TOLERANCE_M) {
            kept.push(corner);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use surfaces::ConvexPolygon;

    use super::*;

    fn square(centre: [f64; 3], normal: Vector3<f64>, friction: f64) -> LoadedContact {
        let corners = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]];
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TAU / 2.0));
        let corner = |[x, y]: [f64; 2]| Point3::from(centre) + turn * Vector3::new(x, y, 0.0);
        LoadedContact {
            points_W: corners.map(corner).to_vec(),
            normal_W: normal,
            friction,
        }
    }

    #[test]
    fn on_level_ground_it_is_the_hull_of_the_contacts() {
        let contacts = [
            square([0.0, 0.1, 0.3], Vector3::z(), 0.6),
            square([0.4, -0.1, 0.3], Vector3::z(), 0.6),
        ];
        let region = ConvexPolygon::hull(&support_region(&contacts).unwrap()).unwrap();
        let points = contacts.iter().flat_map(|c| &c.points_W);
        let points: Vec<_> = points.map(|p| p.xy()).collect();
        let hull = ConvexPolygon::hull(&points).unwrap();
        let (area, wanted) = (region.area(), hull.area());
        assert!((area - wanted).abs() < 1e-6, "{area} {wanted}");
        for p in hull.vertices() {
            assert!(region.signed_distance(p).abs() < 1e-6, "{p} is no corner");
        }
    }

    #[test]
    fn a_slope_holds_below_its_friction_angle_and_not_above() {
        let tilted = |angle: f64| Vector3::new(angle.sin(), 0.0, angle.cos());
        // The inscribed pyramid has an edge in the direction of the slope: the angle is atan 0.5.
        let limit = 0.5_f64.atan();
        assert!(support_region(&[square([0.0; 3], tilted(limit - 0.01), 0.5)]).is_some());
        assert!(support_region(&[square([0.0; 3], tilted(limit + 0.01), 0.5)]).is_none());
    }

    #[test]
    fn between_two_slopes_it_reaches_as_far_as_the_steepest_forces_cross() {
        // Two points at x = ±0.5 whose normals lean inward by 45°, with next to no friction: the
        // forces along them balance the weight only where both are equal, at x = 0.
        let lean = std::f64::consts::FRAC_1_SQRT_2;
        let point = |x: f64, y: f64, side: f64| LoadedContact {
            points_W: vec![Point3::new(x, y, 0.0)],
            normal_W: Vector3::new(side * lean, 0.0, lean),
            friction: 1e-6,
        };
        let contacts = [
            point(-0.5, -0.2, 1.0),
            point(-0.5, 0.2, 1.0),
            point(0.5, -0.2, -1.0),
            point(0.5, 0.2, -1.0),
        ];
        let region = support_region(&contacts).unwrap();
        assert!(region.iter().all(|p| p.x.abs() < 1e-3), "{region:?}");
        let reach = region.iter().map(|p| p.y).fold(f64::MIN, f64::max);
        assert!((reach - 0.2).abs() < 1e-3, "{reach}");
    }

    #[test]
    fn opposite_walls_are_cut_off_and_no_contact_holds_nothing() {
        let walls = [
            square([-0.5, 0.0, 1.0], Vector3::x(), 0.8),
            square([0.5, 0.0, 1.0], -Vector3::x(), 0.8),
        ];
        let region = support_region(&walls).unwrap();
        let reach = region.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        assert!((reach - REACH_M).abs() < 1e-6, "{reach}");
        assert!(support_region(&[]).is_none());
        let ceiling = square([0.0; 3], -Vector3::z(), 0.5);
        assert!(support_region(&[ceiling]).is_none());
    }
}
