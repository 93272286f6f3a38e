//! Fewer vertices, never more area: every edge is a constraint for the solver.

use nalgebra::Point2;

use super::ConvexPolygon;

impl ConvexPolygon {
    /// A polygon inside this one with at most `max_vertices` vertices and nearly the most area.
    ///
    /// The largest inscribed k-gon of a convex polygon has its vertices among the polygon's. Of
    /// many vertices the cheapest are dropped one by one; among the last 2k + 8 the best k are
    /// found exactly. Fewer than 3 is read as 3.
    pub fn simplified_inside(&self, max_vertices: usize) -> Self {
        let wanted = max_vertices.max(3);
        if self.vertices.len() <= wanted {
            return self.clone();
        }
        let vertices = drop_cheapest(self.vertices.clone(), wanted.saturating_mul(2) + 8);
        Self {
            vertices: best_inscribed(&vertices, wanted),
        }
    }
}

/// Drops the vertex that costs the least area until `wanted` are left.
fn drop_cheapest(mut ring: Vec<Point2<f64>>, wanted: usize) -> Vec<Point2<f64>> {
    while ring.len() > wanted {
        let count = ring.len();
        let cost = |i: usize| {
            let (before, after) = (&ring[(i + count - 1) % count], &ring[(i + 1) % count]);
            triangle_area(before, &ring[i], after)
        };
        let costs: Vec<f64> = (0..count).map(cost).collect();
        let cheaper = |best: usize, i: usize| if costs[i] < costs[best] { i } else { best };
        ring.remove((1..count).fold(0, cheaper));
    }
    ring
}

/// The `wanted` vertices that enclose the most area, by dynamic programming.
///
///   A_c(j) = max_{i < j} A_{c−1}(i) + |△(v_first, v_i, v_j)|
///
/// is the area of the best fan of c vertices from `first` to `j`; every `first` is tried.
fn best_inscribed(ring: &[Point2<f64>], wanted: usize) -> Vec<Point2<f64>> {
    let count = ring.len();
    let mut best_area = f64::NEG_INFINITY;
    let mut best = Vec::new();
    for first in 0..=count.saturating_sub(wanted) {
        // area[c][j]: the best fan with c vertices after the first; from[c][j]: the one before j.
        let mut area = vec![vec![f64::NEG_INFINITY; count]; wanted];
        let mut from = vec![vec![first; count]; wanted];
        area[0][first] = 0.0;
        for c in 1..wanted {
            for j in first + c..count {
                for i in first + c - 1..j {
                    let fan = area[c - 1][i] + triangle_area(&ring[first], &ring[i], &ring[j]);
                    if fan > area[c][j] {
                        (area[c][j], from[c][j]) = (fan, i);
                    }
                }
            }
        }
        for (last, whole) in area[wanted - 1].iter().enumerate() {
            if *whole > best_area {
                best_area = *whole;
                let mut chain = vec![last];
                for c in (1..wanted).rev() {
                    chain.push(from[c][chain[chain.len() - 1]]);
                }
                chain.reverse();
                best = chain.into_iter().map(|i| ring[i]).collect();
            }
        }
    }
    best
}

fn triangle_area(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    0.5 * (b - a).perp(&(c - b))
}
