//! The rings around a face's pixels: outer boundary and holes.

use nalgebra::{Point2, Vector2};

use super::boundary::traces;
use super::face::Face;

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

/// How far a ring may leave the traced one.
#[derive(Clone, Copy)]
struct Limits {
    /// 1 over the squares of how far it may lie outside, and inside, 1/px².
    outside: f64,
    inside: f64,
}

impl Limits {
    fn new(notch_px: f64, bulge_px: f64) -> Self {
        let inverse = |px: f64| 1.0 / (px * px).max(1e-9);
        Self {
            outside: inverse(notch_px),
            inside: inverse(bulge_px),
        }
    }

    /// Square of how far off a chord of the ring a point of it is, in units of what is allowed there.
    fn excess(&self, chord: &Chord, p: &Point2<f64>) -> f64 {
        // The face is on the left of its rings: there the chord lies outside of it.
        let left = chord.along.perp(&(p - chord.from)) > 0.0;
        chord.square(p) * if left { self.outside } else { self.inside }
    }
}

/// A closed chain of pixels and the ones of them that stand for it.
struct Ring {
    points: Vec<Point2<f64>>,
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
                points,
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
        let mut kept = Vec::with_capacity(64);
        kept.extend([0, high]);
        let mut stack = Vec::with_capacity(64);
        stack.extend([(0, high), (high, n)]);
        while let Some((a, b)) = stack.pop() {
            let chord = Chord::new(&points[a], &points[b % n]);
            let mut worst = (1.0, 0);
            for (k, p) in points.iter().enumerate().take(b).skip(a + 1) {
                let excess = limits.excess(&chord, p);
                if excess > worst.0 {
                    worst = (excess, k);
                }
            }
            if worst.1 > 0 {
                kept.push(worst.1);
                stack.extend([(a, worst.1), (worst.1, b)]);
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
        self.kept.iter().map(|&k| self.points[k]).collect()
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
        let chord = Chord::new(&self.points[first], &self.points[last]);
        let (whole, n) = (&self.points, self.points.len());
        let (head, tail) = if first < last {
            (&whole[first + 1..last], &whole[..0])
        } else {
            (&whole[(first + 1).min(n)..], &whole[..last])
        };
        let mut most: f64 = 0.0;
        for p in head.iter().chain(tail) {
            most = most.max(self.limits.excess(&chord, p));
            if most > 1.0 {
                return f64::INFINITY;
            }
        }
        most
    }
}

/// A segment from which distances are taken (not its line: a ring may double back).
struct Chord {
    from: Point2<f64>,
    along: Vector2<f64>,
    /// 1 / ‖along‖², or 0 for a point.
    inverse: f64,
}

impl Chord {
    fn new(a: &Point2<f64>, b: &Point2<f64>) -> Self {
        let along = b - a;
        let square = along.norm_squared();
        Self {
            from: *a,
            along,
            inverse: if square > 0.0 { 1.0 / square } else { 0.0 },
        }
    }

    /// Square of the distance of a point.
    fn square(&self, p: &Point2<f64>) -> f64 {
        let from = p - self.from;
        let t = (from.dot(&self.along) * self.inverse).clamp(0.0, 1.0);
        (from - self.along * t).norm_squared()
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
