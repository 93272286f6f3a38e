//! The vertex of a convex polyhedron farthest along a direction, by walking uphill.
//!
//! On a convex polyhedron a vertex that no neighbour tops is the highest; a table of directions
//! tells where to begin.

use nalgebra::{Point3, Vector3};

/// Polyhedra with fewer vertices are searched through.
const FEW: usize = 20;
/// Cells along each edge of each of the six faces of the table's cube.
const CELLS: usize = 5;

/// Neighbours of every vertex, and where to begin for every direction of the table.
#[derive(Clone, Debug, Default)]
pub(super) struct Ascent {
    /// Neighbours of vertex v: `neighbours[first[v]..first[v + 1]]`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    /// The highest vertex along the middle of each cell.
    begin: Vec<u32>,
}

impl Ascent {
    /// Prepares a polyhedron of triangles.
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Self {
        if vertices.len() < FEW {
            return Self::default();
        }
        let mut edges: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let first = (0..=vertices.len() as u32)
            .map(|v| edges.partition_point(|e| e.0 < v) as u32)
            .collect();
        let begin = (0..6 * CELLS * CELLS)
            .map(|cell| highest(vertices, &middle(cell)) as u32)
            .collect();
        Self {
            first,
            neighbours: edges.iter().map(|e| e.1).collect(),
            begin,
        }
    }

    /// Index of a vertex farthest along `d`.
    pub fn support(&self, vertices: &[Point3<f64>], d: &Vector3<f64>) -> usize {
        let Some(&begin) = self.begin.get(cell(d)) else {
            return highest(vertices, d);
        };
        let mut at = begin as usize;
        let mut height = vertices[at].coords.dot(d);
        loop {
            let around = self.first[at] as usize..self.first[at + 1] as usize;
            let mut next = None;
            for &v in &self.neighbours[around] {
                let h = vertices[v as usize].coords.dot(d);
                if h > height {
                    (height, next) = (h, Some(v as usize));
                }
            }
            match next {
                Some(v) => at = v,
                None => return at,
            }
        }
    }
}

/// The vertex farthest along `d`; the first of them on a tie.
fn highest(vertices: &[Point3<f64>], d: &Vector3<f64>) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (i, vertex) in vertices.iter().enumerate() {
        let along = vertex.coords.dot(d);
        if along > best.0 {
            best = (along, i);
        }
    }
    best.1
}

/// The cell of the cube's surface that a direction meets.
fn cell(d: &Vector3<f64>) -> usize {
    let axis = d.iamax();
    let size = d[axis].abs();
    let face = 2 * axis + usize::from(d[axis] < 0.0);
    let along = |k: usize| {
        let t = 0.5 + 0.5 * d[(axis + k) % 3] / size;
        // A direction of zeros gives NaN, which counts as 0.
        ((t * CELLS as f64) as usize).min(CELLS - 1)
    };
    (face * CELLS + along(1)) * CELLS + along(2)
}

/// The direction through the middle of a cell.
fn middle(cell: usize) -> Vector3<f64> {
    let (face, u, v) = (cell / (CELLS * CELLS), cell / CELLS % CELLS, cell % CELLS);
    let at = |k: usize| 2.0 * (k as f64 + 0.5) / CELLS as f64 - 1.0;
    let mut d = Vector3::zeros();
    d[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
    d[(face / 2 + 1) % 3] = at(u);
    d[(face / 2 + 2) % 3] = at(v);
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::hull::Hull;

    fn number(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn finds_what_a_search_through_all_vertices_finds() {
        let mut seed = 7;
        for _ in 0..20 {
            let points: Vec<Point3<f64>> = (0..200)
                .map(|_| {
                    Point3::new(
                        number(&mut seed),
                        0.3 * number(&mut seed),
                        2.0 * number(&mut seed),
                    )
                })
                .collect();
            let hull = Hull::new(&points).unwrap();
            assert!(hull.vertices().len() >= FEW);
            for _ in 0..500 {
                let d = Vector3::from_fn(|_, _| number(&mut seed));
                let best = hull.vertices()[highest(hull.vertices(), &d)].coords.dot(&d);
                assert!((hull.support(&d).coords.dot(&d) - best).abs() < 1e-12);
            }
            for d in [Vector3::zeros(), Vector3::x(), -Vector3::z()] {
                let best = hull.vertices()[highest(hull.vertices(), &d)].coords.dot(&d);
                assert!((hull.support(&d).coords.dot(&d) - best).abs() < 1e-12);
            }
        }
    }
}
