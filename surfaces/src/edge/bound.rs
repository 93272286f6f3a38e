//! Where an outline bounds a piece: the edges of it that are near, and at which of the piece's.

use nalgebra::Point2;

use crate::{ConvexPolygon, HalfPlane};

/// The edge of a piece at which an edge of an outline bounds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Index l of the piece's edge.
    pub edge: usize,
    /// Gap between both, m; negative where the outline reaches into the piece.
    pub gap_m: f64,
    /// Length of the outline's edge that is near, m.
    pub length_m: f64,
}

/// Where the outline's edge from `a` to `b` bounds a piece; `None` where it is farther than
/// `reach_m` from every edge's line on the outer side.
///
/// Units: m.  Frames: all in that of the polygon.
pub fn bound(
    polygon: &ConvexPolygon,
    a: &Point2<f64>,
    b: &Point2<f64>,
    reach_m: f64,
) -> Option<Bound> {
    bound_by(&fours(&polygon.half_planes()), a, b, reach_m)
        .ok()
        .flatten()
}

/// [`bound`] of each edge of the rings that bounds the polygon with these half planes
/// ([`ConvexPolygon::half_planes`]), with the indices of its ring and in it.
pub(crate) fn for_bounds(
    half_planes: &[HalfPlane],
    rings: &[Vec<[f64; 2]>],
    reach_m: f64,
    mut found: impl FnMut(usize, usize, Bound),
) {
    let fours = fours(half_planes);
    for (number, ring) in rings.iter().enumerate() {
        // Most edges are beyond a half plane, mostly the one beyond which the edge before is: there
        // they begin.
        let mut last: Option<&HalfPlane> = None;
        for (k, a) in ring.iter().enumerate() {
            let b = Point2::from(*ring.get(k + 1).unwrap_or(&ring[0]));
            if last.is_some_and(|h| h.value(&b) > reach_m) {
                continue;
            }
            match bound_by(&fours, &Point2::from(*a), &b, reach_m) {
                Ok(bound) => {
                    last = None;
                    if let Some(bound) = bound {
                        found(number, k, bound);
                    }
                }
                Err(beyond) => last = half_planes.get(beyond),
            }
        }
    }
}

/// Four half planes side by side, which a processor takes at once: n_x, n_y and b of each.
struct Four {
    x: [f64; 4],
    y: [f64; 4],
    b: [f64; 4],
}

/// Half planes in fours; the last four are filled up with what bounds nothing.
fn fours(half_planes: &[HalfPlane]) -> Vec<Four> {
    half_planes.chunks(4).map(Four::new).collect()
}

impl Four {
    /// Of four half planes or fewer.
    fn new(some: &[HalfPlane]) -> Self {
        let mut four = Self {
            x: [0.0; 4],
            y: [0.0; 4],
            b: [f64::INFINITY; 4],
        };
        for (l, h) in some.iter().enumerate() {
            (four.x[l], four.y[l], four.b[l]) = (h.n.x, h.n.y, h.b);
        }
        four
    }

    /// [`HalfPlane::value`] of each, widened by `reach_m`.
    #[inline]
    fn values(&self, p: &Point2<f64>, reach_m: f64) -> [f64; 4] {
        let value = |l: usize| self.x[l] * p.x + self.y[l] * p.y - self.b[l] - reach_m;
        [value(0), value(1), value(2), value(3)]
    }
}

/// [`bound`] of the polygon with these half planes; the index of the one beyond which the edge is, if
/// it is wholly beyond one.
fn bound_by(
    fours: &[Four],
    a: &Point2<f64>,
    b: &Point2<f64>,
    reach_m: f64,
) -> Result<Option<Bound>, usize> {
    // The part of the edge in the piece widened by the reach.
    let (mut from, mut to) = ([0.0_f64; 4], [1.0_f64; 4]);
    for (i, four) in fours.iter().enumerate() {
        let (va, vb) = (four.values(a, reach_m), four.values(b, reach_m));
        let beyond = (0..4).fold(0_u32, |beyond, l| {
            beyond | u32::from((va[l] > 0.0) & (vb[l] > 0.0)) << l
        });
        if beyond != 0 {
            return Err(4 * i + beyond.trailing_zeros() as usize);
        }
        for l in 0..4 {
            let at = va[l] / (va[l] - vb[l]);
            from[l] = from[l].max(if va[l] > 0.0 { at } else { 0.0 });
            to[l] = to[l].min(if vb[l] > 0.0 { at } else { 1.0 });
        }
    }
    let from = from.into_iter().fold(0.0, f64::max);
    let to = to.into_iter().fold(1.0, f64::min);
    if from > to {
        return Ok(None);
    }
    let (near, far) = (a + (b - a) * from, a + (b - a) * to);
    // The edge that separates best: of every fourth, then of these the first that does.
    let (mut edges, mut gaps) = ([0; 4], [f64::NEG_INFINITY; 4]);
    for (i, four) in fours.iter().enumerate() {
        let (u, v) = (four.values(&near, 0.0), four.values(&far, 0.0));
        for l in 0..4 {
            let gap_m = if v[l] < u[l] { v[l] } else { u[l] };
            edges[l] = if gap_m > gaps[l] { 4 * i + l } else { edges[l] };
            gaps[l] = if gap_m > gaps[l] { gap_m } else { gaps[l] };
        }
    }
    let gap_m = gaps.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // No branches, which could not be foreseen.
    let first = |best: usize, l: usize| {
        if gaps[l] == gap_m {
            edges[l].min(best)
        } else {
            best
        }
    };
    let edge = (0..4).fold(usize::MAX, first);
    Ok((gap_m > f64::NEG_INFINITY).then(|| Bound {
        edge,
        gap_m,
        length_m: (far - near).norm(),
    }))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::polygon::tests::polygons;

    /// The definition, one half plane after the other.
    fn defined(
        polygon: &ConvexPolygon,
        a: &Point2<f64>,
        b: &Point2<f64>,
        reach_m: f64,
    ) -> Option<Bound> {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for h in polygon.half_planes() {
            let (va, vb) = (h.value(a) - reach_m, h.value(b) - reach_m);
            match (va > 0.0, vb > 0.0) {
                (true, true) => return None,
                (true, false) => from = from.max(va / (va - vb)),
                (false, true) => to = to.min(va / (va - vb)),
                (false, false) => {}
            }
        }
        let (near, far) = (a + (b - a) * from, a + (b - a) * to);
        let gap = |h: &HalfPlane| h.value(&near).min(h.value(&far));
        let gaps: Vec<f64> = polygon.half_planes().iter().map(gap).collect();
        let gap_m = gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let edge = gaps.iter().position(|gap| *gap == gap_m)?;
        let length_m = (far - near).norm();
        let bound = Bound {
            edge,
            gap_m,
            length_m,
        };
        (from <= to).then_some(bound)
    }

    proptest! {
        #[test]
        fn half_planes_by_fours_bound_as_one_by_one(
            piece in polygons(), other in polygons(), reach in 0.01..0.5,
        ) {
            for (a, b) in other.edges() {
                prop_assert_eq!(bound(&piece, a, b, reach), defined(&piece, a, b, reach));
            }
        }
    }

    #[test]
    fn of_edges_that_separate_alike_the_first_counts() {
        // The upper side in two, of which one is the last of four half planes, the other the first of
        // the next.
        let corners = [[-1, -1], [0, -1], [1, -1], [1, 1], [0, 1], [-1, 1]];
        let corners = corners.map(|corner| corner.map(f64::from)).to_vec();
        let near = Point2::new(0.0, 0.5);
        let found = bound(&corners.try_into().unwrap(), &near, &near, 0.1).unwrap();
        assert_eq!((found.edge, found.gap_m), (3, -0.5));
    }
}
