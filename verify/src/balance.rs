//! Whether forces exist that hold the robot, by linear programming from nothing but the contacts.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::simplex::{Ended, largest_last};

/// A contact that can push.
pub(crate) struct Support {
    /// Its patch's vertices in W, m.
    pub vertices: Vec<Vector3<f64>>,
    /// Two tangents and the outward normal, in W.
    pub axes: Matrix3<f64>,
    /// The coefficient of friction.
    pub friction: f64,
}

/// Forces λ_k g_k at points p_k: the edges of the friction pyramids at every vertex, each with a
/// normal part of 1.
struct Generators {
    /// Force g and moment (p − c) × g of each.
    wrenches: Vec<[f64; 6]>,
}

/// Why a linear program gave no number.
#[derive(Debug)]
pub(crate) enum Failure {
    /// No forces exist, of whatever sign.
    None,
    /// The solver failed.
    Solver,
}

impl From<Ended> for Failure {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Infeasible => Failure::None,
            Ended::Undecided => Failure::Solver,
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Failure::None => f.write_str("no forces at the contacts balance the robot"),
            Failure::Solver => f.write_str("the linear program was not solved"),
        }
    }
}

/// More than every edge can bear, in even shares.
const SHARE_MAX: f64 = 100.0;

/// The least that every edge may be said to bear, in even shares.
const SHARE_MIN: f64 = 1.0;

/// Half of the side of the box in which a displacement of the centre of mass is looked for, m.
const REACH_M: f64 = 1.0;

impl Generators {
    fn new(supports: &[Support], com: &Vector3<f64>, edges: usize) -> Self {
        let mut wrenches = Vec::new();
        for support in supports {
            let [x, y, z] = [0, 1, 2].map(|k| support.axes.column(k).into_owned());
            for p in &support.vertices {
                for k in 0..edges.max(3) {
                    let (sin, cos) = (TAU * k as f64 / edges.max(3) as f64).sin_cos();
                    let g = z + support.friction * (cos * x + sin * y);
                    let m = (p - com).cross(&g);
                    wrenches.push([g.x, g.y, g.z, m.x, m.y, m.z]);
                }
            }
        }
        Self { wrenches }
    }
}

/// Gravity balanced, over the weight.
const CARRIED: [f64; 6] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// How much every edge of every friction pyramid can bear in an equilibrium:
///
///   max t   s.t.  Σ λ_k w_k = (weight, 0),   λ_k ≥ t
///
/// over the weight, times the number of edges: 1 where all bear the same, 0 where some must bear
/// nothing, negative where no equilibrium exists.
pub(crate) fn equilibrium(
    supports: &[Support],
    com: &Vector3<f64>,
    edges: usize,
) -> Result<f64, Failure> {
    let generators = Generators::new(supports, com, edges);
    let count = generators.wrenches.len();
    if count == 0 {
        return Err(Failure::None);
    }
    // λ_k = t + μ_k with μ_k ≥ 0; t is measured in even shares so that it is of size 1, and from below
    // so that it is positive.
    let share = 1.0 / count as f64;
    let mut even = [0.0; 6];
    for w in &generators.wrenches {
        for (sum, value) in even.iter_mut().zip(w) {
            *sum += share * value;
        }
    }
    let mut target = CARRIED;
    for (wanted, value) in target.iter_mut().zip(even) {
        *wanted += SHARE_MIN * value;
    }
    let columns = [generators.wrenches, vec![even]].concat();
    Ok(largest_last(&columns, target, SHARE_MAX)? - SHARE_MIN)
}

/// How far the centre of mass may move along `direction` (a unit vector) and still be held, m:
///
///   max r   s.t.  Σ λ_k w_k = (weight, r·d × weight),   λ ≥ 0,   r ≤ 1 m
pub(crate) fn reach(
    supports: &[Support],
    com: &Vector3<f64>,
    edges: usize,
    direction: &Vector3<f64>,
) -> Result<f64, Failure> {
    let generators = Generators::new(supports, com, edges);
    // Weight at c + r d: its moment about c is r d × (−ẑ), which the contacts balance.
    let m = direction.cross(&Vector3::new(0.0, 0.0, -1.0));
    let moved = [0.0, 0.0, 0.0, m.x, m.y, m.z];
    let columns = [generators.wrenches, vec![moved]].concat();
    Ok(largest_last(&columns, CARRIED, REACH_M)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 0.2 m on the ground.
    fn foot(x: f64, friction: f64) -> Support {
        let vertices = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]
            .map(|[dx, dy]| Vector3::new(x + dx, dy, 0.0));
        Support {
            vertices: vertices.to_vec(),
            axes: Matrix3::identity(),
            friction,
        }
    }

    #[test]
    fn the_centre_of_mass_moves_to_the_edge_of_a_foot_and_no_further() {
        let com = Vector3::new(0.03, 0.0, 0.8);
        let (x, y) = (Vector3::x(), Vector3::y());
        for (direction, expected) in [(x, 0.07), (-x, 0.13), (y, 0.10)] {
            let r = reach(&[foot(0.0, 0.5)], &com, 16, &direction).unwrap();
            assert!((r - expected).abs() < 1e-6, "{direction:?}: {r}");
        }
    }

    #[test]
    fn equilibrium_is_lost_at_the_edge() {
        let at = |x: f64| equilibrium(&[foot(0.0, 0.5)], &Vector3::new(x, 0.0, 0.8), 16);
        assert!((at(0.0).unwrap() - 1.0).abs() < 1e-6);
        assert!(at(0.099).unwrap() > 0.0);
        assert!(at(0.101).unwrap() < 0.0);
    }

    #[test]
    fn a_slope_holds_up_to_its_friction_angle() {
        let tilted = |slope: f64, friction: f64| {
            let turn = nalgebra::Rotation3::new(Vector3::y() * slope);
            let mut support = foot(0.0, friction);
            support.axes = *turn.matrix();
            support.vertices.iter_mut().for_each(|p| *p = turn * *p);
            equilibrium(&[support], &Vector3::new(0.0, 0.0, 0.05), 16)
        };
        assert!(tilted(0.3, 0.3_f64.tan() * 1.03).unwrap() > 0.0);
        assert!(tilted(0.3, 0.3_f64.tan() * 0.97).unwrap() < 0.0);
    }

    #[test]
    fn nothing_holds_nothing() {
        let held = equilibrium(&[], &Vector3::zeros(), 16);
        assert!(matches!(held, Err(Failure::None)));
    }
}
