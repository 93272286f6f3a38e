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

use crate::Config;
use crate::layout::ContactModel;
use crate::problem::Problem;

/// Smallest upward part of a normal for which this is meant: on steeper faces friction holds, and
/// the balls need not stand around the centre of mass.
const UPWARD_MIN: f64 = 0.7;
/// More than all contacts bear: no posture has a margin over balls in a line.
const TOO_MUCH: f64 = 2.0;

/// Whether a margin is asked for and all that is loaded are balls on faces that are not steep.
pub(crate) fn on_balls_alone(
    problem: &Problem,
    contacts: &[ContactModel],
    config: &Config,
) -> bool {
    let mut all = problem.contacts.iter().zip(contacts);
    let ball = |m: &ContactModel| m.radius.is_some() && m.axes[(2, 2)] >= UPWARD_MIN;
    config.com_margin_m > 0.0 && all.all(|(contact, model)| !contact.loaded || ball(model))
}

/// The part ε of the weight that each of the balls at these places must be able to do without for a
/// margin of `margin_m`, and its derivatives by the places, 1/m.
pub(crate) fn least_load(places: &[Vector2<f64>], margin_m: f64) -> (f64, Vec<Vector2<f64>>) {
    let none = vec![Vector2::zeros(); places.len()];
    let Some((width_m, by_place)) = width(places).filter(|(w, _)| *w * TOO_MUCH > margin_m) else {
        return (TOO_MUCH, none);
    };
    let load = margin_m / width_m;
    let slope = |d: Vector2<f64>| d * (-load / width_m);
    (load, by_place.into_iter().map(slope).collect())
}

/// D, m, and its derivatives by the points; none for points that have no hull.
fn width(points: &[Vector2<f64>]) -> Option<(f64, Vec<Vector2<f64>>)> {
    let mut least: Option<(f64, usize, usize)> = None;
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate() {
            let Some(along) = (b - a).try_normalize(1e-9) else {
                continue;
            };
            let beside = || points.iter().map(|p| along.perp(&(p - a)));
            // An edge has every point on its left.
            if beside().all(|d| d >= -1e-9) {
                let sum = beside().sum();
                if least.is_none_or(|(least, ..)| sum < least) {
                    least = Some((sum, i, j));
                }
            }
        }
    }
    let (sum, i, j) = least?;
    // dD = n · Σ w dp: one each, and what turns and moves the edge at its ends.
    let (a, b) = (points[i], points[j]);
    let length = (b - a).norm();
    let along = (b - a) / length;
    let inward = Vector2::new(-along.y, along.x);
    let lever = points.iter().map(|p| along.dot(&(p - a))).sum::<f64>() / length;
    let mut by_point = vec![inward; points.len()];
    by_point[i] += inward * (lever - points.len() as f64);
    by_point[j] -= inward * lever;
    Some((sum, by_point))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width_m(points: &[Vector2<f64>]) -> f64 {
        width(points).map_or(0.0, |(width_m, _)| width_m)
    }

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
