//! Fewer vertices, never more area: every edge is a constraint for the solver.

use nalgebra::Point2;

use super::ConvexPolygon;

impl ConvexPolygon {
    /// A polygon inside this one with at most `max_vertices` vertices and nearly the most area.
    ///
    /// The largest inscribed k-gon of a convex polygon has its vertices among the polygon's, so
    /// vertices are dropped, the one that costs the least area first, and then each one kept is
    /// moved to the vertex farthest from the chord of its neighbours until none moves.
    /// Fewer than 3 is read as 3.
    pub fn simplified_inside(&self, max_vertices: usize) -> Self {
        let wanted = max_vertices.max(3);
        let all = &self.vertices;
        let mut kept: Vec<usize> = (0..all.len()).collect();
        while kept.len() > wanted {
            let count = kept.len();
            let cost = |i: usize| {
                let before = &all[kept[(i + count - 1) % count]];
                let after = &all[kept[(i + 1) % count]];
                triangle_area(before, &all[kept[i]], after)
            };
            let costs: Vec<f64> = (0..count).map(cost).collect();
            let cheapest =
                (1..count).fold(0, |best, i| if costs[i] < costs[best] { i } else { best });
            kept.remove(cheapest);
        }
        exchange(all, &mut kept);
        Self {
            vertices: kept.into_iter().map(|i| all[i]).collect(),
        }
    }
}

/// Moves each kept vertex between its kept neighbours to where it adds the most area.
fn exchange(all: &[Point2<f64>], kept: &mut [usize]) {
    let count = kept.len();
    // Every move adds area, so this ends; the bound guards against ties by rounding.
    for _ in 0..all.len() {
        let mut moved = false;
        for i in 0..count {
            let (before, after) = (kept[(i + count - 1) % count], kept[(i + 1) % count]);
            let area = |v: usize| triangle_area(&all[before], &all[v], &all[after]);
            let between = (1..all.len())
                .map(|step| (before + step) % all.len())
                .take_while(|v| *v != after);
            let mut best = kept[i];
            for v in between {
                // A relative gain: equal areas must not swap for ever.
                if area(v) > area(best) * (1.0 + 1e-12) {
                    best = v;
                }
            }
            moved |= best != kept[i];
            kept[i] = best;
        }
        if !moved {
            break;
        }
    }
}

fn triangle_area(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    0.5 * (b - a).perp(&(c - b))
}
