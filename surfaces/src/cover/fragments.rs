//! What is not covered yet, as disjoint convex fragments.

use nalgebra::Point2;

use crate::ConvexPolygon;
use crate::polygon::{clip_ring, ring_area};

/// Fragments below this area are rounding, m² (a strip of a micrometre over a millimetre).
const AREA_MIN_M2: f64 = 1e-9;

/// Disjoint convex fragments.
pub(super) struct Fragments {
    list: Vec<Fragment>,
}

struct Fragment {
    ring: Vec<Point2<f64>>,
    /// A piece was grown from it, or from what it is a part of.
    tried: bool,
}

impl Fragment {
    fn area(&self) -> f64 {
        ring_area(&self.ring)
    }
}

impl Fragments {
    pub fn new(rings: impl Iterator<Item = Vec<Point2<f64>>>) -> Self {
        let list = rings.map(|ring| Fragment { ring, tried: false }).collect();
        Self { list }
    }

    /// The area of all fragments, m².
    pub fn area(&self) -> f64 {
        self.list.iter().map(Fragment::area).sum()
    }

    /// The fragments, as rings.
    pub fn into_rings(self) -> impl Iterator<Item = Vec<Point2<f64>>> {
        self.list.into_iter().map(|fragment| fragment.ring)
    }

    /// The largest fragment of at least `area_min_m2` that was not taken here before.
    pub fn take_largest(&mut self, area_min_m2: f64) -> Option<Vec<Point2<f64>>> {
        let untried = self.list.iter_mut().filter(|f| !f.tried);
        let largest = untried.max_by(|a, b| a.area().total_cmp(&b.area()))?;
        if largest.area() < area_min_m2.max(AREA_MIN_M2) {
            return None;
        }
        largest.tried = true;
        Some(largest.ring.clone())
    }

    /// The area of the fragments inside a polygon, m².
    pub fn area_in(&self, polygon: &ConvexPolygon) -> f64 {
        let edges = polygon.half_planes();
        let common = |fragment: &Fragment| {
            let mut inside = fragment.ring.clone();
            for edge in &edges {
                inside = clip_ring(&inside, edge);
                if inside.is_empty() {
                    return 0.0;
                }
            }
            ring_area(&inside)
        };
        self.list.iter().map(common).sum()
    }

    /// Removes what lies in a polygon.
    pub fn subtract(&mut self, polygon: &ConvexPolygon) {
        let edges = polygon.half_planes();
        let mut left = Vec::with_capacity(self.list.len());
        for fragment in self.list.drain(..) {
            // Cut along each edge: the outer part stays, the inner part goes on to the next.
            let mut inside = fragment.ring.clone();
            let mut outside = Vec::new();
            for edge in &edges {
                let ring = clip_ring(&inside, &edge.flipped());
                if ring_area(&ring) > AREA_MIN_M2 {
                    let tried = fragment.tried;
                    outside.push(Fragment { ring, tried });
                }
                inside = clip_ring(&inside, edge);
                if inside.is_empty() {
                    break;
                }
            }
            if ring_area(&inside) > AREA_MIN_M2 {
                left.append(&mut outside);
            } else {
                // Nothing in common: it stays in one part.
                left.push(fragment);
            }
        }
        self.list = left;
    }
}
