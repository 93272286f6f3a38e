//! The rings around a face's pixels: outer boundary and holes.

use nalgebra::Point2;

use super::face::Raster;

/// Closed rings around the face in the pixel plane, the outer one first, then the holes.
///
/// Rings run along the centres of the face's outermost pixels (so a polygon through them covers
/// no pixel that is not the face's), simplified to `tolerance_px`; rings that shrink to fewer than
/// three corners are dropped. The outer ring turns counter-clockwise with v down, as the image
/// shows it; holes turn the other way.
pub(super) fn rings(raster: &Raster, tolerance_px: f64) -> Vec<Vec<Point2<f64>>> {
    let mut seen = vec![false; raster.inside.len()];
    let mut rings = Vec::new();
    for i in 0..raster.inside.len() {
        // A ring starts at a pixel of the face with nothing of it on the left.
        if raster.inside[i] && !raster.inside[i - 1] && !seen[i] {
            let ring = trace(raster, i, &mut seen);
            let ring = simplified(&ring, tolerance_px);
            if ring.len() >= 3 {
                rings.push(ring);
            }
        }
    }
    // The outer ring encloses all others.
    rings.sort_by(|a, b| area(b).abs().total_cmp(&area(a).abs()));
    rings
}

/// Twice-signed area halved: positive when x to y turns left.
fn area(ring: &[Point2<f64>]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(a, b)| a.x * b.y - b.x * a.y)
        .sum::<f64>()
        / 2.0
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

/// Douglas–Peucker on a closed ring, from its two points that lie farthest apart along x.
fn simplified(ring: &[Point2<f64>], tolerance: f64) -> Vec<Point2<f64>> {
    if ring.len() < 3 {
        return Vec::new();
    }
    let by_x = |a: &usize, b: &usize| ring[*a].x.total_cmp(&ring[*b].x);
    let low = (0..ring.len()).min_by(by_x).unwrap_or(0);
    let high = (0..ring.len()).max_by(by_x).unwrap_or(0);
    let n = ring.len();
    let at = |k: usize| ring[(low + k) % n];
    let middle = (high + n - low) % n;
    let mut keep = vec![false; n + 1];
    keep[0] = true;
    keep[middle] = true;
    keep[n] = true;
    let mut stack = vec![(0, middle), (middle, n)];
    while let Some((a, b)) = stack.pop() {
        let (p, q) = (at(a), at(b));
        let along = q - p;
        let length = along.norm();
        let mut worst = (tolerance, 0);
        for k in a + 1..b {
            let r = at(k) - p;
            let off = if length > 0.0 {
                // Distance from the segment, not the line: a ring may double back.
                let t = (r.dot(&along) / (length * length)).clamp(0.0, 1.0);
                (r - along * t).norm()
            } else {
                r.norm()
            };
            if off > worst.0 {
                worst = (off, k);
            }
        }
        if worst.1 > 0 {
            keep[worst.1] = true;
            stack.extend([(a, worst.1), (worst.1, b)]);
        }
    }
    (0..n).filter(|&k| keep[k]).map(at).collect()
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
        rings(&Raster::new(&faces[0]).unwrap(), 0.3)
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
}
