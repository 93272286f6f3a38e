//! What makes a list of points a convex, counter-clockwise polygon.

use nalgebra::{Point2, Vector2};

use super::{VERTEX_SEPARATION_M, ring_area};
use crate::Error;

/// A right turn up to this angle is the rounding of a straight edge, rad.
///
/// Six decimals on an edge of a metre turn it by 1e-6 rad; taken as a constraint, such an edge
/// cuts off no more than a micrometre per metre.
const STRAIGHT_RAD: f64 = 1e-6;

/// Checks the vertices from the plainest fault to the subtlest.
pub(super) fn check(vertices: &[Point2<f64>]) -> Result<(), Error> {
    Error::check_count(vertices.len())?;
    Error::check_in_world(vertices)?;
    check_distinct(vertices)?;
    check_width(vertices)?;
    check_turns(vertices)
}

/// Refuses two vertices at one place, neighbours or not.
fn check_distinct(vertices: &[Point2<f64>]) -> Result<(), Error> {
    for (vertex, v) in vertices.iter().enumerate() {
        let near = |w: &Point2<f64>| (v - w).norm() < VERTEX_SEPARATION_M;
        if let Some(of) = vertices[..vertex].iter().position(near) {
            return Err(Error::repeated(vertex, of, v));
        }
    }
    Ok(())
}

/// Refuses vertices that all lie on one line.
pub(crate) fn check_width(vertices: &[Point2<f64>]) -> Result<(), Error> {
    // The line through vertex 0 and the vertex farthest from it: every polygon with an area has
    // a vertex off that line.
    let origin = vertices[0];
    let mut axis = Vector2::zeros();
    for v in vertices {
        if (v - origin).norm() > axis.norm() {
            axis = v - origin;
        }
    }
    // One place only: no line, no vertex off it.
    let axis = axis.try_normalize(0.0).unwrap_or_default();
    let (mut vertex, mut off_m) = (0, 0.0);
    for (i, v) in vertices.iter().enumerate() {
        let off = axis.perp(&(v - origin)).abs();
        if off > off_m {
            (vertex, off_m) = (i, off);
        }
    }
    if off_m < VERTEX_SEPARATION_M {
        let count = vertices.len();
        return Err(Error::Shape(format!(
            "all {count} vertices lie on one line: vertex {vertex}, the farthest from it, is off by {off_m:.3e} m"
        )));
    }
    Ok(())
}

/// Refuses right turns, spikes and boundaries that go round more than once.
fn check_turns(vertices: &[Point2<f64>]) -> Result<(), Error> {
    let count = vertices.len();
    let turn_at = |i: usize| {
        let before = vertices[i] - vertices[(i + count - 1) % count];
        let after = vertices[(i + 1) % count] - vertices[i];
        before.perp(&after).atan2(before.dot(&after))
    };
    let mut turned = 0.0;
    let mut first_right = None;
    let mut only_right = true;
    let mut gone_round = None;
    for vertex in 0..count {
        let turn = turn_at(vertex);
        // A half turn is a spike, whichever sign rounding gives it.
        let spike = turn.abs() > std::f64::consts::PI - STRAIGHT_RAD;
        if first_right.is_none() && (turn < -STRAIGHT_RAD || spike) {
            first_right = Some((vertex, turn.abs()));
        }
        only_right &= turn < STRAIGHT_RAD;
        turned += turn;
        // 0.1 rad: a full circle is a whole number of turns, only rounding has to be told apart.
        if gone_round.is_none() && turned > std::f64::consts::TAU + 0.1 {
            gone_round = Some(vertex);
        }
    }
    Err(Error::Shape(match (first_right, gone_round) {
        (Some((vertex, _)), _) if only_right && ring_area(vertices) < 0.0 => format!(
            "the vertices run clockwise about the outward normal (at vertex {vertex} the boundary turns right): give \
             them counter-clockwise"
        ),
        (Some((vertex, turn_rad)), _) => {
            format!("not convex: the boundary turns right by {turn_rad:.3e} rad at vertex {vertex}")
        }
        (None, Some(vertex)) => {
            format!("the boundary crosses itself: it has gone round once before vertex {vertex}")
        }
        (None, None) => return Ok(()),
    }))
}
