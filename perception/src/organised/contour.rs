//! The rings around a face's pixels: outer boundary and holes.

use nalgebra::{Point2, Vector2};

use super::boundary::traces;
use super::face::Face;

/// Closed rings around the face in the pixel plane, the outer one first, then the holes.
///
/// Rings run along the centres of the face's outermost pixels, so that they enclose no pixel that
/// is not the face's, and are then simplified: nowhere by more than `tolerance_px`, and notches no
/// deeper than `notch_px` are filled, so that a face that is convex but for the noise of its edge
/// has a convex ring. Rings that shrink to fewer than three corners are dropped.
pub(super) fn rings(face: &Face, tolerance_px: f64, notch_px: f64) -> Vec<Vec<Point2<f64>>> {
    let traces = traces(face).into_iter();
    let mut rings: Vec<Ring> = traces.map(|ring| Ring::new(ring, tolerance_px)).collect();
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
        let mut kept = Vec::with_capacity(64);
        kept.extend([0, high]);
        let mut stack = Vec::with_capacity(64);
        stack.extend([(0, high), (high, n)]);
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
    use super::super::face::tests::of_labels as faces;
    use super::*;

    fn rings_of(picture: &[&str]) -> Vec<Vec<Point2<f64>>> {
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
            .collect();
        let faces = faces(&labels, picture[0].len());
        assert_eq!(faces.len(), 1);
        rings(&faces[0], 0.3, 0.0)
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
            assert_eq!(rings(face, 0.3, 1.2)[0].len(), corners);
        }
    }

    #[test]
    fn rings_part_the_face_from_all_other_pixels() {
        // Specks and holes of all forms, from a congruential generator.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 24
        };
        const WIDTH: usize = 14;
        for full in (60..230).step_by(10) {
            let labels: Vec<u16> = (0..WIDTH * 12)
                .map(|_| if random() < full { 0 } else { u16::MAX })
                .collect();
            for face in faces(&labels, WIDTH) {
                let rings = rings(&face, 0.0, 0.0);
                let held = |u: usize, v: usize| {
                    let mut runs = face.runs.iter();
                    runs.any(|r| r.0 as usize == v && (r.1..r.2).contains(&(u as u32)))
                };
                for (u, v) in (0..WIDTH * 12).map(|i| (i % WIDTH, i / WIDTH)) {
                    let edges = (rings.iter()).flat_map(|r| r.iter().zip(r.iter().cycle().skip(1)));
                    let (x, y) = (u as f64, v as f64);
                    let crossed = edges.filter(|(a, b)| {
                        (a.y > y) != (b.y > y) && x < a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)
                    });
                    let inside = crossed.count() % 2 == 1;
                    let around = |u: usize, v: usize| {
                        let beside = (0..9).map(|k| (u + k % 3, v + k / 3));
                        beside
                            .into_iter()
                            .all(|(u, v)| u > 0 && v > 0 && held(u - 1, v - 1))
                    };
                    assert!(held(u, v) || !inside, "{u} {v} is not the face's");
                    assert!(
                        !around(u, v) || inside,
                        "{u} {v} is in the middle of the face"
                    );
                }
            }
        }
    }
}
