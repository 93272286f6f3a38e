//! What keeps the centre of mass away from the edge of what balls support.
//!
//! An area is shrunk where its forces act; a point cannot be. Instead every ball bears a part ε of
//! the weight W that it could do without: f_i − ε W ẑ stays in its cone. With horizontal places p_i
//!
//!   ε = m / D,   D = min over the hull's edges of Σ_i (distance of p_i from the edge)
//!
//! and the centre of mass may move by m to any side: the loads δ_i ≥ −ε with Σ δ_i = 0 that may be
//! added reach every Σ δ_i p_i of length ε D.

use nalgebra::Vector2;
use robot_model::Kinematics;

use crate::iterate::ContactModel;
use crate::problem::{Place, Problem};

/// Smallest upward part of a normal for which this is meant: on steeper faces friction holds, and
/// the balls need not stand around the centre of mass.
const UPWARD_MIN: f64 = 0.7;
/// More than all contacts bear: no posture has a margin over balls in a line.
const TOO_MUCH: f64 = 2.0;

/// Whether all that is loaded are balls on faces that are not steep: then there is a least load.
pub(crate) fn is_meant(problem: &Problem, contacts: &[ContactModel]) -> bool {
    let mut all = problem.contacts.iter().zip(contacts);
    all.all(|(contact, model)| {
        let ball = model.radius.is_some() && model.axes[(2, 2)] >= UPWARD_MIN;
        ball || !contact.loaded
    })
}

/// The part of the weight that every loaded ball must be able to do without for a margin of
/// `margin_m` where the balls are: at their fixed places, or where the robot has them.
pub(crate) fn least_load(
    problem: &Problem,
    contacts: &[ContactModel],
    kinematics: &Kinematics,
    margin_m: f64,
) -> f64 {
    let all = problem.contacts.iter().zip(contacts);
    let loaded = all.filter(|(contact, _)| contact.loaded);
    let places: Vec<Vector2<f64>> = loaded
        .map(|(contact, model)| {
            let patch = &problem.robot.patches[contact.patch];
            let centre = match &contact.place {
                Place::Fixed { X_WC, .. } => X_WC.translation.vector,
                Place::OnSurface { .. } => kinematics.X_WC(patch).translation.vector,
            };
            (centre - model.radius.unwrap_or(0.0) * model.axes.column(2)).xy()
        })
        .collect();
    (margin_m / width_m(&places)).min(TOO_MUCH)
}

/// The smallest sum of distances from an edge of the points' hull, m; zero for points in a line.
fn width_m(points: &[Vector2<f64>]) -> f64 {
    let mut least = f64::INFINITY;
    for a in points {
        for b in points {
            let Some(along) = (b - a).try_normalize(1e-9) else {
                continue;
            };
            let beside = || points.iter().map(|p| along.perp(&(p - a)));
            // An edge has every point on its left.
            if beside().all(|d| d >= -1e-9) {
                least = least.min(beside().sum());
            }
        }
    }
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_of_a_triangle_is_its_least_height() {
        let points = [[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]].map(Vector2::from);
        // Heights 3, 4 and 12/5.
        assert!((width_m(&points) - 2.4).abs() < 1e-12);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector2::from);
        assert!((width_m(&square) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn points_in_a_line_have_none() {
        let line = [[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]].map(Vector2::from);
        assert!(width_m(&line).abs() < 1e-8);
        assert_eq!(width_m(&line[..1]), 0.0);
    }
}
