//! The rings around a face's pixels: outer boundary and holes.

mod chain;

use nalgebra::Point2;

use super::boundary_trace::traces;
use super::face::Face;
use chain::{Chain, Chord, Limits};

/// A ring may cut into a face by this part of its mean width at most: of a tread that is hardly longer
/// than a foot, nothing can be spared.
const WIDTH_PART: f64 = 0.03;

/// Closed rings around the face in the pixel plane, the outer one first, then the holes.
///
/// Rings run along the centres of the face's outermost pixels, so that they enclose no pixel that
/// is not the face's, and are then simplified: notches no deeper than `notch_px` are filled, so that
/// a face that is convex but for the noise of its edge has a convex ring, and bulges no higher than
/// `bulge_px` cut off; of a narrow face, less. What a ring cuts off is safe to stand beside, what it
/// fills is not: so the one may be more than the other. Rings that shrink to fewer than three corners
/// are dropped.
pub(super) fn rings(face: &Face, notch_px: f64, bulge_px: f64) -> Vec<Vec<Point2<f64>>> {
    let traces = traces(face);
    let area: f64 = face.runs.iter().map(|(_, a, b)| f64::from(b - a)).sum();
    let length: f64 = traces.iter().map(|trace| length(trace)).sum();
    let width = 2.0 * area / length.max(1.0);
    let limits = Limits::new(notch_px, bulge_px.min(WIDTH_PART * width));
    let ring = |trace| Ring::new(trace, limits);
    let mut rings: Vec<Ring> = traces.into_iter().map(ring).collect();
    // The outer ring encloses all others.
    rings.sort_by(|a, b| b.area().abs().total_cmp(&a.area().abs()));
    for ring in &mut rings {
        ring.drop_corners();
    }
    rings
        .iter()
        .map(Ring::corners)
        .filter(|corners| corners.len() >= 3)
        .collect()
}

/// A closed chain of pixels and the ones of them that stand for it.
struct Ring {
    points: Chain,
    /// Indices of the corners, ascending.
    kept: Vec<usize>,
    limits: Limits,
}

impl Ring {
    /// The corners by Douglas and Peucker, from the two points that lie farthest apart along x.
    fn new(mut points: Vec<Point2<f64>>, limits: Limits) -> Self {
        let n = points.len();
        if n < 3 {
            return Self {
                points: Chain::new(&points),
                kept: Vec::new(),
                limits,
            };
        }
        let by_x = |a: &Point2<f64>, b: &Point2<f64>| a.x.total_cmp(&b.x);
        let at = |points: &[Point2<f64>], most: Option<&Point2<f64>>| {
            most.and_then(|most| points.iter().position(|p| p == most))
        };
        let low = at(&points, points.iter().min_by(|a, b| by_x(a, b))).unwrap_or(0);
        points.rotate_left(low);
        let high = at(&points, points.iter().max_by(|a, b| by_x(a, b))).unwrap_or(0);
        let points = Chain::new(&points);
        let mut kept = Vec::with_capacity(64);
        kept.extend([0, high]);
        let mut stack = Vec::with_capacity(64);
        stack.extend([(0, high), (high, n)]);
        while let Some((a, b)) = stack.pop() {
            let chord = Chord::new(&points.at(a), &points.at(b % n), limits);
            if let Some(worst) = points.worst(&chord, a + 1..b) {
                kept.push(worst);
                stack.extend([(a, worst), (worst, b)]);
            }
        }
        kept.sort_unstable();
        kept.dedup();
        Self {
            points,
            kept,
            limits,
        }
    }

    fn corners(&self) -> Vec<Point2<f64>> {
        self.kept.iter().map(|&k| self.points.at(k)).collect()
    }

    /// Area, positive when x to y turns left. The face is on the right of its traced rings with
    /// v down, so on the left with y up: outer rings are positive, holes negative.
    fn area(&self) -> f64 {
        area(&self.corners())
    }

    /// Drops corners while the new edge stays within the limits, the one that takes least of them
    /// first.
    fn drop_corners(&mut self) {
        let count = self.kept.len();
        let mut excesses: Vec<f64> = (0..count).map(|i| self.without(i)).collect();
        while self.kept.len() > 3 {
            let least = |best: usize, i: usize| {
                if excesses[i] < excesses[best] {
                    i
                } else {
                    best
                }
            };
            let i = (1..excesses.len()).fold(0, least);
            if excesses[i] > 1.0 {
                break;
            }
            self.kept.remove(i);
            excesses.remove(i);
            // The corners beside it have other edges now.
            let count = self.kept.len();
            for k in [(i + count - 1) % count, i % count] {
                excesses[k] = self.without(k);
            }
        }
    }

    /// How far the ring is off the edge that leaves out a corner, squared, in units of the limits;
    /// infinite beyond them.
    fn without(&self, corner: usize) -> f64 {
        let count = self.kept.len();
        let beside = [corner + count - 1, corner + 1];
        let [first, last] = beside.map(|i| self.kept[i % count]);
        let chord = Chord::new(&self.points.at(first), &self.points.at(last), self.limits);
        let ways = if first < last {
            [first + 1..last, 0..0]
        } else {
            [first + 1..self.points.count, 0..last]
        };
        let mut most: f64 = 0.0;
        for way in ways {
            most = most.max(self.points.farthest(&chord, way));
            if most > 1.0 {
                return f64::INFINITY;
            }
        }
        most
    }
}

/// Length of a ring in steps from pixel to pixel.
fn length(ring: &[Point2<f64>]) -> f64 {
    let next = ring.iter().skip(1).chain(ring.first());
    ring.iter().zip(next).map(|(a, b)| (b - a).amax()).sum()
}

/// Area of a ring, positive when x to y turns left.
fn area(ring: &[Point2<f64>]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(a, b)| a.x * b.y - b.x * a.y)
        .sum::<f64>()
        / 2.0
}

#[cfg(test)]
mod tests;
