//! The rings around a face's pixels: outer boundary and holes.

use nalgebra::{Point2, Vector2};

use super::bits::Bits;
use super::face::Face;

/// Closed rings around the face in the pixel plane, the outer one first, then the holes.
///
/// Rings run along the centres of the face's outermost pixels, so that they enclose no pixel that
/// is not the face's, and are then simplified: nowhere by more than `tolerance_px`, and notches no
/// deeper than `notch_px` are filled, so that a face that is convex but for the noise of its edge
/// has a convex ring. Rings that shrink to fewer than three corners are dropped.
///
/// `labels` are those that the face was found in, rows of `width`; `seen` marks those pixels that the rings
/// came to from the left.
pub(super) fn rings(
    face: &Face,
    labels: &[u16],
    width: usize,
    seen: &mut Bits,
    tolerance_px: f64,
    notch_px: f64,
) -> Vec<Vec<Point2<f64>>> {
    let mut rings = Vec::new();
    for &(v, u, _) in &face.runs {
        // A ring starts at a pixel of the face with nothing of it on the left.
        if !seen.has(u as usize, v as usize) {
            let traced = trace(face.label, labels, width, (u.into(), v.into()), seen);
            rings.push(Ring::new(traced, tolerance_px));
        }
    }
    // The outer ring encloses all others.
    rings.sort_by(|a, b| b.area().abs().total_cmp(&a.area().abs()));
    for ring in &mut rings {
        ring.fill_notches(notch_px);
    }
    rings
        .iter()
        .map(Ring::corners)
        .filter(|corners| corners.len() >= 3)
        .collect()
}

/// Follows the pixel edges around the face from the left edge of `start`, keeping the face on
/// the right hand; returns the pixels passed, but for those inside of a straight row: no chord has
/// them farther off than both ends. Marks the left edges passed in `seen`.
fn trace(
    label: u16,
    labels: &[u16],
    width: usize,
    start: (i64, i64),
    seen: &mut Bits,
) -> Vec<Point2<f64>> {
    // Heading up, right, down, left.
    const STEPS: [(i64, i64); 4] = [(0, -1), (1, 0), (0, 1), (-1, 0)];
    let (columns, rows) = (width as i64, (labels.len() / width.max(1)) as i64);
    let index = |(u, v): (i64, i64)| (v * columns + u) as usize;
    let inside = |(u, v): (i64, i64)| {
        (0..columns).contains(&u) && (0..rows).contains(&v) && labels[index((u, v))] == label
    };
    let step = |(u, v): (i64, i64), d: usize| (u + STEPS[d].0, v + STEPS[d].1);
    let (mut pixel, mut heading) = (start, 0);
    let (mut last, mut way) = (None, (0, 0));
    let mut ring = Vec::new();
    loop {
        if heading == 0 {
            let (u, v) = (pixel.0 as usize, pixel.1 as usize);
            if seen.has(u, v) {
                break;
            }
            seen.set(u, v);
        }
        if last != Some(pixel) {
            // Of pixels in a row the last one stands for those between.
            let from: (i64, i64) = last.unwrap_or(pixel);
            let next = (pixel.0 - from.0, pixel.1 - from.1);
            if next == way && ring.len() > 1 {
                ring.pop();
            }
            ring.push(Point2::new(pixel.0 as f64, pixel.1 as f64));
            (last, way) = (Some(pixel), next);
        }
        // `pixel` lies on the right of the edge walked. What is ahead of it, and left of that,
        // decides: turn left, go straight, or turn right around the pixel.
        let ahead = step(pixel, heading);
        let left = step(ahead, (heading + 3) % 4);
        if !inside(ahead) {
            heading = (heading + 1) % 4;
        } else if inside(left) {
            pixel = left;
            heading = (heading + 3) % 4;
        } else {
            pixel = ahead;
        }
    }
    if ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    ring
}

/// A closed chain of pixels and the ones of them that stand for it.
struct Ring {
    points: Vec<Point2<f64>>,
    /// Indices of the corners, ascending.
    kept: Vec<usize>,
}

impl Ring {
    /// The corners by Douglas and Peucker, from the two points that lie farthest apart along x.
    fn new(mut points: Vec<Point2<f64>>, tolerance: f64) -> Self {
        let n = points.len();
        if n < 3 {
            return Self {
                points,
                kept: Vec::new(),
            };
        }
        let by_x = |a: &Point2<f64>, b: &Point2<f64>| a.x.total_cmp(&b.x);
        let at = |points: &[Point2<f64>], most: Option<&Point2<f64>>| {
            most.and_then(|most| points.iter().position(|p| p == most))
        };
        let low = at(&points, points.iter().min_by(|a, b| by_x(a, b))).unwrap_or(0);
        points.rotate_left(low);
        let high = at(&points, points.iter().max_by(|a, b| by_x(a, b))).unwrap_or(0);
        let mut kept = vec![0, high];
        let mut stack = vec![(0, high), (high, n)];
        while let Some((a, b)) = stack.pop() {
            let chord = Chord::new(&points[a], &points[b % n]);
            let mut worst = (tolerance * tolerance, 0);
            for (k, p) in points.iter().enumerate().take(b).skip(a + 1) {
                let off = chord.square(p);
                if off > worst.0 {
                    worst = (off, k);
                }
            }
            if worst.1 > 0 {
                kept.push(worst.1);
                stack.extend([(a, worst.1), (worst.1, b)]);
            }
        }
        kept.sort_unstable();
        kept.dedup();
        Self { points, kept }
    }

    fn corners(&self) -> Vec<Point2<f64>> {
        self.kept.iter().map(|&k| self.points[k]).collect()
    }

    /// Area, positive when x to y turns left. The face is on the right of its traced rings with
    /// v down, so on the left with y up: outer rings are positive, holes negative.
    fn area(&self) -> f64 {
        area(&self.corners())
    }

    /// Drops corners that turn away from the face while no point of the ring comes to lie more
    /// than `depth` off the new edge, the shallowest notch first.
    fn fill_notches(&mut self, depth: f64) {
        let around = |i: usize, count: usize| ((i + count - 1) % count, (i + 1) % count);
        let count = self.kept.len();
        let mut depths: Vec<f64> = (0..count)
            .map(|i| {
                let (before, after) = around(i, count);
                self.notch(before, i, after, depth)
            })
            .collect();
        while self.kept.len() > 3 {
            let shallower = |best: usize, i: usize| if depths[i] < depths[best] { i } else { best };
            let i = (1..depths.len()).fold(0, shallower);
            if depths[i] > depth {
                break;
            }
            self.kept.remove(i);
            depths.remove(i);
            // The corners beside it have other edges now.
            let count = self.kept.len();
            for k in [(i + count - 1) % count, i % count] {
                let (before, after) = around(k, count);
                depths[k] = self.notch(before, k, after, depth);
            }
        }
    }

    /// How far the ring lies off the edge that leaves out a corner; infinite beyond `most`, and
    /// where the corner turns toward the face.
    fn notch(&self, before: usize, corner: usize, after: usize, most: f64) -> f64 {
        let [first, middle, last] = [before, corner, after].map(|i| self.kept[i]);
        let [a, b, c] = [first, middle, last].map(|k| &self.points[k]);
        // The face is on the left of its rings: a right turn is a notch (or no corner).
        if (b - a).perp(&(c - b)) > 0.0 {
            return f64::INFINITY;
        }
        let chord = Chord::new(a, c);
        let (whole, n) = (&self.points, self.points.len());
        let (head, tail) = if first < last {
            (&whole[first + 1..last], &whole[..0])
        } else {
            (&whole[(first + 1).min(n)..], &whole[..last])
        };
        let mut off: f64 = 0.0;
        for p in head.iter().chain(tail) {
            off = off.max(chord.square(p));
            if off > most * most {
                return f64::INFINITY;
            }
        }
        off.sqrt()
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
mod tests {
    use super::super::face::faces;
    use super::*;

    fn trace_all(face: &Face, labels: &[u16], width: usize, notch: f64) -> Vec<Vec<Point2<f64>>> {
        rings(
            face,
            labels,
            width,
            &mut Bits::new(width, labels.len() / width, |_, _| {}),
            0.3,
            notch,
        )
    }

    fn rings_of(picture: &[&str]) -> Vec<Vec<Point2<f64>>> {
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
            .collect();
        let faces = faces(&labels, picture[0].len());
        assert_eq!(faces.len(), 1);
        trace_all(&faces[0], &labels, picture[0].len(), 0.0)
    }

    #[test]
    fn a_square_with_a_hole_has_two_rings_of_opposite_turn() {
        let rings = rings_of(&[
            "#######", "#######", "##...##", "##...##", "#######", "#######",
        ]);
        assert_eq!(rings.len(), 2);
        // Through pixel centres, cut across the corners of the hole: 6 × 5, and 4 × 3 − 4/2.
        assert_eq!(area(&rings[0]).abs(), 30.0);
        assert_eq!(area(&rings[1]).abs(), 10.0);
        assert!(area(&rings[0]) * area(&rings[1]) < 0.0);
    }

    #[test]
    fn an_l_keeps_its_corner() {
        let rings = rings_of(&["##....", "##....", "##....", "######", "######"]);
        assert_eq!(rings.len(), 1);
        // 1 × 4 and 4 × 1, and half a pixel cut across the inner corner.
        assert_eq!(area(&rings[0]).abs(), 8.5);
    }

    #[test]
    fn a_shallow_notch_is_filled_and_a_deep_one_is_not() {
        let picture = ["##########", "####..####", "##########"];
        let deep = ["###....###", "###....###", "##########", "##########"];
        for (picture, corners) in [(&picture[1..], 4), (&deep[..], 8)] {
            let labels: Vec<u16> = picture
                .iter()
                .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
                .collect();
            let face = &faces(&labels, 10)[0];
            assert_eq!(trace_all(face, &labels, 10, 1.2)[0].len(), corners);
        }
    }
}
