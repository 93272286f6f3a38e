//! The rings around a face's pixels: outer boundary and holes.

use nalgebra::Point2;

use super::face::Raster;

/// Closed rings around the face in the pixel plane, the outer one first, then the holes.
///
/// Rings run along the centres of the face's outermost pixels, so that they enclose no pixel that
/// is not the face's, and are then simplified: nowhere by more than `tolerance_px`, and notches no
/// deeper than `notch_px` are filled, so that a face that is convex but for the noise of its edge
/// has a convex ring. Rings that shrink to fewer than three corners are dropped.
pub(super) fn rings(raster: &Raster, tolerance_px: f64, notch_px: f64) -> Vec<Vec<Point2<f64>>> {
    let mut seen = vec![false; raster.inside.len()];
    let mut rings = Vec::new();
    for i in 1..raster.inside.len() {
        // A ring starts at a pixel of the face with nothing of it on the left.
        if raster.inside[i] && !raster.inside[i - 1] && !seen[i] {
            let ring = Ring::new(trace(raster, i, &mut seen), tolerance_px);
            rings.push(ring);
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
/// the right hand; returns the pixels passed. Marks the left edges passed in `seen`.
fn trace(raster: &Raster, start: usize, seen: &mut [bool]) -> Vec<Point2<f64>> {
    let s = raster.stride as i64;
    // Heading up, right, down, left.
    let steps = [-s, 1, s, -1];
    let step = |i: usize, d: usize| (i as i64 + steps[d]) as usize;
    let (mut pixel, mut heading) = (start, 0);
    let mut ring = Vec::new();
    loop {
        if heading == 0 {
            if seen[pixel] {
                break;
            }
            seen[pixel] = true;
        }
        let p = raster.point(pixel);
        if ring.last() != Some(&p) {
            ring.push(p);
        }
        // `pixel` lies on the right of the edge walked. What is ahead of it, and left of that,
        // decides: turn left, go straight, or turn right around the pixel.
        let ahead = step(pixel, heading);
        let left = step(ahead, (heading + 3) % 4);
        if raster.inside[ahead] && raster.inside[left] {
            pixel = left;
            heading = (heading + 3) % 4;
        } else if raster.inside[ahead] {
            pixel = ahead;
        } else {
            heading = (heading + 1) % 4;
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
    fn new(points: Vec<Point2<f64>>, tolerance: f64) -> Self {
        let n = points.len();
        if n < 3 {
            return Self {
                points,
                kept: Vec::new(),
            };
        }
        let by_x = |a: &usize, b: &usize| points[*a].x.total_cmp(&points[*b].x);
        let low = (0..n).min_by(by_x).unwrap_or(0);
        let high = (0..n).max_by(by_x).unwrap_or(0);
        let middle = (high + n - low) % n;
        let mut kept = vec![0, middle];
        let mut stack = vec![(0, middle), (middle, n)];
        while let Some((a, b)) = stack.pop() {
            let chord = (&points[(low + a) % n], &points[(low + b) % n]);
            let mut worst = (tolerance, 0);
            for k in a + 1..b {
                let off = distance(&points[(low + k) % n], chord);
                if off > worst.0 {
                    worst = (off, k);
                }
            }
            if worst.1 > 0 {
                kept.push(worst.1);
                stack.extend([(a, worst.1), (worst.1, b)]);
            }
        }
        let mut kept: Vec<usize> = kept.into_iter().map(|k| (low + k) % n).collect();
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
        while self.kept.len() > 3 {
            let count = self.kept.len();
            let mut best: Option<(f64, usize)> = None;
            for i in 0..count {
                let (before, after) = (
                    self.kept[(i + count - 1) % count],
                    self.kept[(i + 1) % count],
                );
                let (a, c) = (&self.points[before], &self.points[after]);
                let b = &self.points[self.kept[i]];
                // The face is on the left of its rings: a right turn is a notch (or no corner).
                if (b - a).perp(&(c - b)) > 0.0 {
                    continue;
                }
                let mut k = (before + 1) % self.points.len();
                let mut off: f64 = 0.0;
                while k != after && off <= depth {
                    off = off.max(distance(&self.points[k], (a, c)));
                    k = (k + 1) % self.points.len();
                }
                if off <= depth && best.is_none_or(|(least, _)| off < least) {
                    best = Some((off, i));
                }
            }
            let Some((_, i)) = best else { break };
            self.kept.remove(i);
        }
    }
}

/// Distance of a point from a segment (not its line: a ring may double back).
fn distance(p: &Point2<f64>, (a, b): (&Point2<f64>, &Point2<f64>)) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let t = if square > 0.0 {
        ((p - a).dot(&along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p - a - along * t).norm()
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

    fn rings_of(picture: &[&str]) -> Vec<Vec<Point2<f64>>> {
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
            .collect();
        let faces = faces(&labels, picture[0].len());
        assert_eq!(faces.len(), 1);
        rings(&Raster::new(&faces[0]).unwrap(), 0.3, 0.0)
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
            let raster = Raster::new(&faces(&labels, 10)[0]).unwrap();
            assert_eq!(rings(&raster, 0.3, 1.2)[0].len(), corners);
        }
    }
}
