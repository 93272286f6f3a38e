//! What ends a face at each edge of its outline.
//!
//! The edges of an outline are seen: beyond one the scan sees that the face ends, or something nearer
//! hides how it goes on, or the view ends. A convex piece of the face inherits the kind of the
//! outline's edges along which an edge of it lies; where it lies along none it is a seam, beyond
//! which the face goes on.
//!
//! An edge k of the outline bounds a piece { p : n_l · p ≤ b_l } at that edge l of the piece which
//! separates the two best,
//!
//!   l(k) = argmax_l g_kl,   g_kl = min over the part of k near the piece of n_l · p − b_l,
//!
//! and leaves the gap g_k = g_{k,l(k)} between them, m; negative where it reaches into the piece.

mod bound;

use nalgebra::Point2;
use serde::{Deserialize, Serialize};

use crate::ConvexPolygon;
pub(crate) use bound::for_bounds;
pub use bound::{Bound, bound};

/// What ends a face at an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeKind {
    /// The face ends: beyond it is something farther away, or another face that meets it.
    #[default]
    Real,
    /// Something nearer hides how the face goes on.
    Occluded,
    /// The border of what the sensor measured cuts the face.
    FieldOfView,
    /// Nothing was measured beyond it.
    Unknown,
    /// No edge of the face: between two convex pieces of it, which goes on beyond. Polygons have
    /// such edges, outlines do not.
    Seam,
}

impl EdgeKind {
    /// The kinds that an outline's edge can have, each at its own number.
    const SEEN: [Self; 4] = [Self::Real, Self::Occluded, Self::FieldOfView, Self::Unknown];

    /// The kind that an outline's edge has in most of its places; of equals the first in the order
    /// above, and [`Self::Real`] of none.
    pub fn most(places: impl Iterator<Item = Self>) -> Self {
        let mut weights = Weights::default();
        places.for_each(|kind| weights.add(kind, 1.0));
        weights.heaviest().unwrap_or_default()
    }
}

/// What each kind weighs that an outline's edge can have, in the order of [`EdgeKind::SEEN`].
#[derive(Clone, Copy, Default)]
struct Weights([f64; EdgeKind::SEEN.len()]);

impl Weights {
    /// Adds to a kind; seams weigh nothing.
    fn add(&mut self, kind: EdgeKind, weight: f64) {
        if let Some(sum) = self.0.get_mut(kind as usize) {
            *sum += weight;
        }
    }

    /// The kind that weighs most, if any weighs something.
    fn heaviest(&self) -> Option<EdgeKind> {
        let kinds = EdgeKind::SEEN.into_iter().zip(self.0);
        let heavier = |a: (EdgeKind, f64), b: (EdgeKind, f64)| if b.1 > a.1 { b } else { a };
        let (kind, weight) = kinds.reduce(heavier)?;
        (weight > 0.0).then_some(kind)
    }
}

/// An edge of a piece lies along the outline's edges that are this near to it, m.
pub const ALONG_M: f64 = 0.01;

/// An edge of a piece is one of the face where this part of it lies along the outline.
const ALONG_MIN: f64 = 0.1;

/// The kinds of a piece's edges, by those of the outline's edges along which they lie.
///
/// Shapes: one kind an edge of the polygon, in its order; `kinds` has one an edge of each ring, from
/// a corner to the next, or is empty: all real. The longest part of an edge gives its kind.
/// Frames: rings in that of the polygon, m.
pub fn kinds_of(
    polygon: &ConvexPolygon,
    rings: &[Vec<[f64; 2]>],
    kinds: &[Vec<EdgeKind>],
) -> Vec<EdgeKind> {
    let half_planes = polygon.half_planes();
    // How much of the outline lies along each edge, m, in all and by its kind.
    let mut along = vec![(0.0, Weights::default()); half_planes.len()];
    for_bounds(&half_planes, rings, ALONG_M, |ring, k, found| {
        let kind = kinds.get(ring).and_then(|kinds| kinds.get(k));
        let (length_m, weights) = &mut along[found.edge];
        *length_m += found.length_m;
        weights.add(kind.copied().unwrap_or_default(), found.length_m);
    });
    let edges = polygon.edges().zip(&along);
    edges
        .map(|((a, b), (length_m, weights))| {
            let enough = *length_m >= ALONG_MIN * (b - a).norm();
            let kind = weights.heaviest().filter(|_| enough);
            kind.unwrap_or(EdgeKind::Seam)
        })
        .collect()
}

/// The edges of a ring as pairs of corners, the closing one last.
pub fn ring_edges(ring: &[[f64; 2]]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
    let next = ring.iter().skip(1).chain(ring.first());
    ring.iter()
        .zip(next)
        .map(|(a, b)| (Point2::from(*a), Point2::from(*b)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::outline::Outline;
    use crate::polygon::tests::polygons;

    fn rectangle(low: [f64; 2], high: [f64; 2]) -> ConvexPolygon {
        let [x0, y0] = low;
        let [x1, y1] = high;
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
            .try_into()
            .unwrap()
    }

    #[test]
    fn pieces_of_an_l_inherit_from_its_outline_and_meet_in_seams() {
        // ┌─┐
        // │ └──┐   the ring counter-clockwise from the lower left corner
        // └────┘
        let ring = vec![
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.5],
            [0.6, 0.5],
            [0.6, 2.0],
            [0.0, 2.0],
        ];
        use EdgeKind::{FieldOfView, Occluded, Real, Seam, Unknown};
        let kinds = vec![vec![FieldOfView, Unknown, Real, Occluded, Real, Occluded]];
        // The foot: below, right, above (half of it along the notch), left.
        let foot = kinds_of(
            &rectangle([0.0, 0.0], [2.0, 0.5]),
            std::slice::from_ref(&ring),
            &kinds,
        );
        assert_eq!(foot, [FieldOfView, Unknown, Real, Occluded]);
        // The upper part of the leg, which does not reach down: its lower edge is a seam.
        let leg = kinds_of(
            &rectangle([0.0, 0.3], [0.6, 2.0]),
            std::slice::from_ref(&ring),
            &kinds,
        );
        assert_eq!(leg, [Seam, Occluded, Real, Occluded]);
        // Without kinds all edges of the outline are real.
        let plain = kinds_of(&rectangle([0.0, 0.3], [0.6, 2.0]), &[ring], &[]);
        assert_eq!(plain, [Seam, Real, Real, Real]);
    }

    #[test]
    fn an_outline_that_touches_a_corner_of_an_edge_only_leaves_it_a_seam() {
        // A notch whose tip touches the middle of the edge above.
        let ring = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]];
        let kinds = kinds_of(&rectangle([0.0, 0.0], [2.0, 1.0]), &[ring], &[]);
        assert_eq!(kinds[2], EdgeKind::Seam);
        assert_eq!(kinds[0], EdgeKind::Real);
    }

    proptest! {
        /// Edges are left out for the one before them: none that bounds the polygon.
        #[test]
        fn all_edges_of_rings_that_bound_a_piece_are_found(
            piece in polygons(), a in polygons(), b in polygons(), reach in 0.01..0.5,
        ) {
            let both = Outline::from_polygon(&a).union(&Outline::from_polygon(&b));
            for part in both.parts() {
                let rings = part.rings();
                let mut expected = Vec::new();
                for (number, ring) in rings.iter().enumerate() {
                    for (k, (p, q)) in ring_edges(ring).enumerate() {
                        expected.extend(bound(&piece, &p, &q, reach).map(|b| (number, k, b)));
                    }
                }
                let mut found = Vec::new();
                for_bounds(&piece.half_planes(), &rings, reach, |number, k, bound| {
                    found.push((number, k, bound));
                });
                prop_assert_eq!(found, expected);
            }
        }

        /// A piece moved back by what an edge lacks of a distance keeps that distance from it.
        #[test]
        fn an_edge_moved_by_what_it_lacks_keeps_the_distance(
            a in polygons(), b in polygons(), need in 0.01..0.2,
        ) {
            let both = Outline::from_polygon(&a).union(&Outline::from_polygon(&b));
            for part in both.parts() {
                let rings = part.rings();
                for piece in part.pieces(&crate::cover::Config::default()) {
                    let mut back = vec![0.0_f64; piece.vertices().len()];
                    for (p, q) in rings.iter().flat_map(|ring| ring_edges(ring)) {
                        if let Some(found) = bound(&piece, &p, &q, need) {
                            back[found.edge] = back[found.edge].max(need - found.gap_m);
                        }
                    }
                    let Some(inner) = piece.inset_edges(&back) else { continue };
                    for (p, q) in rings.iter().flat_map(|ring| ring_edges(ring)) {
                        // To the nearest point of the outline's edge, a dense sample of it.
                        for i in 0..=50 {
                            let at = p + (q - p) * (f64::from(i) / 50.0);
                            prop_assert!(inner.signed_distance(&at) > need - 1e-6);
                        }
                    }
                }
            }
        }
    }
}
