//! What exporters leave of a surface: edges that end against the middle of others, and triangles turned round among
//! their neighbours.

use std::collections::{BTreeMap, VecDeque};

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::WELD_M;
use super::weld::{Welded, measure};

/// A vertex with its number.
type Numbered = GeomWithData<[f64; 3], usize>;

/// Both ends of an edge, the smaller first.
fn key(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A triangle at an edge, and whether it runs from the smaller to the larger vertex.
pub(super) type Side = (usize, bool);

/// Edges by their ends, the smaller first, each with its sides.
pub(super) type Edges = BTreeMap<[usize; 2], Vec<Side>>;

/// The edges of all triangles.
fn edges(mesh: &Welded) -> Edges {
    let mut edges = Edges::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.corners;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.entry(key(from, to)).or_default().push((t, from < to));
        }
    }
    edges
}

impl Welded {
    /// Splits edges at what ends on them, turns triangles among their neighbours, and returns how many edges and triangles
    /// these were, with the edges that there are then.
    pub fn mend(&mut self) -> (usize, usize, Edges) {
        let mut edges = edges(self);
        let stitched = self.stitch(&edges);
        if stitched > 0 {
            edges = self::edges(self);
        }
        let turned = self.turn(&edges);
        if turned > 0 {
            edges = self::edges(self);
        }
        (stitched, turned, edges)
    }

    /// Splits triangles whose open edges pass through ends of other open edges (T-junctions), so that both sides have
    /// the edge in common; returns how many edges were split.
    fn stitch(&mut self, edges: &Edges) -> usize {
        let open: Vec<[usize; 2]> = (edges.iter())
            .filter_map(|(edge, sides)| (sides.len() == 1).then_some(*edge))
            .collect();
        let mut ends: Vec<usize> = open.iter().flatten().copied().collect();
        ends.sort_unstable();
        ends.dedup();
        let at = |i: usize| Numbered::new(self.vertices[i].coords.into(), i);
        let tree = RTree::bulk_load(ends.into_iter().map(at).collect());
        let mut on: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for edge in open {
            let within = self.within(edge, &tree);
            if !within.is_empty() {
                on.insert(edge, within);
            }
        }
        if on.is_empty() {
            return 0;
        }
        let mut split = Vec::with_capacity(self.triangles.len());
        for triangle in std::mem::take(&mut self.triangles) {
            let mut parts = Vec::new();
            cut(triangle.corners, [true; 3], &on, &mut parts);
            let measured = parts.into_iter().map(|part| measure(&self.vertices, part));
            match measured.collect::<Option<Vec<_>>>() {
                Some(parts) if parts.len() > 1 => split.extend(parts),
                // A part without an area: better whole.
                _ => split.push(triangle),
            }
        }
        self.triangles = split;
        on.len()
    }

    /// The vertices on an edge between its ends, from its smaller end on.
    fn within(&self, [a, b]: [usize; 2], tree: &RTree<Numbered>) -> Vec<usize> {
        let (p, q) = (self.vertices[a], self.vertices[b]);
        let (along, length_m) = ((q - p).normalize(), (q - p).norm());
        let low = p.inf(&q).coords.add_scalar(-WELD_M);
        let high = p.sup(&q).coords.add_scalar(WELD_M);
        let envelope = rstar::AABB::from_corners(low.into(), high.into());
        let near = tree.locate_in_envelope(&envelope);
        let mut within: Vec<(f64, usize)> = near
            .filter_map(|numbered| {
                let r = self.vertices[numbered.data] - p;
                let s_m = r.dot(&along);
                let is_on = (r - along * s_m).norm() < WELD_M;
                let is_between = s_m > WELD_M && s_m < length_m - WELD_M;
                (is_on && is_between).then_some((s_m, numbered.data))
            })
            .collect();
        within.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        within.into_iter().map(|(_, i)| i).collect()
    }

    /// Turns triangles that are wound otherwise than what they are connected with, the smaller area to go with the larger;
    /// returns how many. Parts that agree stay as they are, and so do those of which neither half is larger.
    fn turn(&mut self, edges: &Edges) -> usize {
        let mut across: Vec<Vec<(usize, bool)>> = vec![Vec::new(); self.triangles.len()];
        for sides in edges.values() {
            if let [(t, one), (u, other)] = sides[..] {
                across[t].push((u, one == other));
                across[u].push((t, one == other));
            }
        }
        // For each triangle whether it is turned against the first of its part.
        let mut against: Vec<Option<bool>> = vec![None; self.triangles.len()];
        let mut turned = 0;
        for first in 0..self.triangles.len() {
            if against[first].is_some() {
                continue;
            }
            against[first] = Some(false);
            let (mut part, mut queue) = (Vec::new(), VecDeque::from([(first, false)]));
            while let Some((t, is_against)) = queue.pop_front() {
                part.push((t, is_against));
                for &(u, differs) in &across[t] {
                    if against[u].is_none() {
                        against[u] = Some(is_against != differs);
                        queue.push_back((u, is_against != differs));
                    }
                }
            }
            let area_m2 = |side: bool| -> f64 {
                let of_side = part.iter().filter(|(_, s)| *s == side);
                of_side.map(|(t, _)| self.triangles[*t].area_m2).sum()
            };
            let areas_m2 = [area_m2(false), area_m2(true)];
            let fewer = areas_m2[1] < areas_m2[0];
            // Halves that differ by what is rounded say nothing.
            if (areas_m2[0] - areas_m2[1]).abs() <= 1e-6 * (areas_m2[0] + areas_m2[1]) {
                continue;
            }
            for (t, _) in part.into_iter().filter(|(_, side)| *side == fewer) {
                let triangle = &mut self.triangles[t];
                triangle.corners.swap(1, 2);
                triangle.normal = -triangle.normal;
                turned += 1;
            }
        }
        turned
    }
}

/// Appends the parts of a triangle that is cut at the vertices on its edges. `uncut` tells of each edge, from a corner
/// to the next, whether it is one of the mesh's that was not looked at yet: an edge between parts may pass for another
/// of the mesh where triangles are as thin as what is welded, and cutting it would not end.
fn cut(
    corners: [usize; 3],
    uncut: [bool; 3],
    on: &BTreeMap<[usize; 2], Vec<usize>>,
    parts: &mut Vec<[usize; 3]>,
) {
    for k in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let [this, next, last] = [0, 1, 2].map(|i| uncut[(k + i) % 3]);
        let Some(within) = on.get(&key(a, b)).filter(|_| this) else {
            continue;
        };
        let mut stops = within.clone();
        if a > b {
            stops.reverse();
        }
        stops.insert(0, a);
        stops.push(b);
        for pair in stops.windows(2) {
            let uncut = [false, next && pair[1] == b, last && pair[0] == a];
            cut([pair[0], pair[1], c], uncut, on, parts);
        }
        return;
    }
    parts.push(corners);
}
