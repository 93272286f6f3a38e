//! Regions of faces as convex parts.

use surfaces::{Edge, Face};

use crate::region::{Point, edges};

/// Lengths below this are rounding, m.
const ROUNDING_M: f64 = 1e-9;

/// A convex polygon between its lower and its upper corners, each from left to right.
struct Part {
    lower: Vec<Point>,
    upper: Vec<Point>,
}

impl Part {
    /// The part with a trapezoid added to its right side, where that is the trapezoid's left side and
    /// the two together are convex.
    fn joined(&self, next: &Part) -> Option<Part> {
        let chain = |first: &[Point], second: &[Point], bend: f64| {
            let [.., a, b] = first else { return None };
            let [c, d, ..] = second else { return None };
            let meets = (b - c).norm() < ROUNDING_M;
            let turn = (b - a).perp(&(d - b)) * bend;
            let off_m = turn / (b - a).norm().max(f64::MIN_POSITIVE);
            (meets && off_m > -ROUNDING_M).then(|| [first, &second[1..]].concat())
        };
        Some(Part {
            lower: chain(&self.lower, &next.lower, 1.0)?,
            upper: chain(&self.upper, &next.upper, -1.0)?,
        })
    }
}

/// The region as convex polygons that do not overlap: trapezoids between the vertical lines through
/// its corners, each between an odd edge from below and the next one, joined from left to right.
pub(crate) fn convex_parts(face: &Face) -> Vec<Vec<Point>> {
    let mut lines: Vec<f64> = edges(face).map(|(_, a, _)| a.x).collect();
    lines.sort_by(f64::total_cmp);
    lines.dedup_by(|a, b| (*a - *b).abs() < ROUNDING_M);
    let mut found: Vec<Part> = Vec::new();
    // Parts before this one end to the left of the line.
    let mut open = 0;
    for slab in lines.windows(2) {
        let (low, high) = (slab[0], slab[1]);
        let middle = 0.5 * (low + high);
        let height =
            |(_, a, b): &(&Edge, Point, Point), x: f64| a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
        let crosses = |(_, a, b): &(&Edge, Point, Point)| (a.x < middle) != (b.x < middle);
        let mut across: Vec<_> = edges(face).filter(crosses).collect();
        across.sort_by(|a, b| height(a, middle).total_cmp(&height(b, middle)));
        let mut left = found.split_off(open);
        open = found.len();
        let mut right = Vec::new();
        for pair in across.chunks_exact(2) {
            let side = |edge| [low, high].map(|x| Point::new(x, height(edge, x))).to_vec();
            let (lower, upper) = (side(&pair[0]), side(&pair[1]));
            let next = Part { lower, upper };
            let mut joined = left.iter().enumerate();
            let joined = joined.find_map(|(k, part)| Some((k, part.joined(&next)?)));
            right.push(joined.map_or(next, |(k, whole)| {
                left.remove(k);
                whole
            }));
        }
        open += left.len();
        found.append(&mut left);
        found.append(&mut right);
    }
    let ring = |part: Part| [part.lower, part.upper.into_iter().rev().collect()].concat();
    found.into_iter().map(ring).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point2};
    use proptest::prelude::*;
    use surfaces::Region;

    use super::*;
    use crate::region::tests::frame;
    use crate::region::{nearest, winding};

    fn area(ring: &[Point]) -> f64 {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        0.5 * edges.map(|(a, b)| a.perp(b)).sum::<f64>()
    }

    #[test]
    fn a_frame_is_four_parts() {
        let parts = convex_parts(&frame());
        let total: f64 = parts.iter().map(|part| area(part)).sum();
        assert!((total - 12.0).abs() < 1e-9 && parts.len() == 4, "{total}");
    }

    proptest! {
        /// Stars with a star for a hole: their parts are convex, as large as they are, and hold the
        /// points that are inside, each once.
        #[test]
        fn parts_are_convex_and_the_region(
            radii in prop::collection::vec(1.0..3.0_f64, 3..24),
            hole in prop::collection::vec(0.1..0.4_f64, 3..12),
            places in prop::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 40),
        ) {
            let star = |radii: &[f64]| -> Vec<Point2<f64>> {
                let turn = std::f64::consts::TAU / radii.len() as f64;
                let at = |(k, r): (usize, &f64)| {
                    let (sin, cos) = (0.1 + turn * k as f64).sin_cos();
                    Point2::new(r * cos, r * sin)
                };
                radii.iter().enumerate().map(at).collect()
            };
            let Ok(region) = Region::new([star(&radii), star(&hole)]) else {
                return Ok(());
            };
            let corners = radii.len() + hole.len();
            let whole = region.area();
            let face = Face::new("star", Isometry3::identity(), region);
            let parts = convex_parts(&face);
            prop_assert!(parts.len() <= corners + 1);
            let total: f64 = parts.iter().map(|part| area(part)).sum();
            prop_assert!((total - whole).abs() < 1e-7, "{total} of {whole}");
            let outside_m = |part: &[Point], p: &Point| {
                let edges = part.iter().zip(part.iter().cycle().skip(1));
                let long = edges.filter(|(a, b)| (*b - *a).norm() > 1e-6);
                let off = long.map(|(a, b)| -(b - a).perp(&(p - a)) / (b - a).norm());
                off.fold(f64::NEG_INFINITY, f64::max)
            };
            for part in &parts {
                prop_assert!(part.iter().all(|p| outside_m(part, p) < 1e-6));
            }
            for (x, y) in places {
                let p = Point::new(x, y);
                let holding = parts.iter().filter(|part| outside_m(part, &p) < 0.0).count();
                let inside = usize::from(winding(&face, &p) > 0.5);
                let gap = edges(&face).map(|(_, a, b)| (p - nearest(&a, &b, &p)).norm());
                let on_side = parts.iter().any(|part| outside_m(part, &p).abs() < 1e-6);
                if gap.fold(f64::INFINITY, f64::min) > 1e-6 && !on_side {
                    prop_assert_eq!(holding, inside);
                }
            }
        }
    }
}
