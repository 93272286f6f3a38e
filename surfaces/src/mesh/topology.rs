//! What the triangles of a mesh make together: neighbours, parts, solids.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Point3, Unit};

use super::mend::{Edges, Side};
use super::weld::Welded;
use super::{MERGE_OFFSET_M, Report, WELD_M};

/// Neighbours of each triangle, and the parts of the mesh.
pub(super) struct Topology {
    /// For each triangle those across an edge that run along it the other way.
    pub neighbours: Vec<Vec<usize>>,
    /// For each triangle the index of its solid.
    pub solid: Vec<Option<usize>>,
    /// Triangles of each closed convex part whose normals point outward.
    pub solids: Vec<Vec<usize>>,
    /// The counts of edges and parts.
    pub report: Report,
}

/// Most triangles at one edge that are neighbours of each.
const LEAVES: usize = 16;
/// What is narrower is no wedge, rad.
const FLAT_RAD: f64 = 1e-3;

impl Topology {
    pub fn new(mesh: &Welded, edges: &Edges) -> Self {
        let count = mesh.triangles.len();
        let mut topology = Self {
            neighbours: vec![Vec::new(); count],
            solid: vec![None; count],
            solids: Vec::new(),
            report: Report::default(),
        };
        let mut parts = Parts::new(count);
        let mut closed = vec![true; count];
        for (edge, sides) in edges {
            let wedges = wedges(mesh, edge, sides);
            match sides[..] {
                [_] => topology.report.open_edges += 1,
                [_, _] => topology.report.flipped_edges += usize::from(wedges.is_none()),
                _ => topology.report.crowded_edges += usize::from(wedges.is_none()),
            }
            for (t, u) in wedges.iter().flatten() {
                parts.join(*t, *u);
            }
            for (i, (t, direction)) in sides.iter().enumerate() {
                closed[*t] &= wedges.is_some();
                // A fold of many leaves at one edge is no surface: few of them need to know each other.
                for (u, other) in sides[..i].iter().rev().take(LEAVES) {
                    if wedges.is_none() {
                        parts.join(*t, *u);
                    }
                    if direction != other {
                        topology.neighbours[*t].push(*u);
                        topology.neighbours[*u].push(*t);
                    }
                }
            }
        }
        for part in parts.lists() {
            if part.iter().any(|t| !closed[*t]) {
                continue;
            }
            let (volume, area) = (volume(mesh, &part), area(mesh, &part));
            // A ball in a convex body has at most the radius 3 V / A.
            if 3.0 * volume.abs() < WELD_M * area {
                topology.report.flat_parts += 1;
            } else if volume < 0.0 {
                topology.report.inward_parts += 1;
            } else if topology.is_convex(mesh, &part) {
                for t in &part {
                    topology.solid[*t] = Some(topology.solids.len());
                }
                topology.solids.push(part);
            }
        }
        topology.report.solids = topology.solids.len();
        topology
    }

    /// Whether every vertex of a closed part lies behind every triangle's plane.
    fn is_convex(&self, mesh: &Welded, part: &[usize]) -> bool {
        let behind = |t: usize, points: &[Point3<f64>]| {
            let (origin, normal) = (mesh.corners(t)[0], mesh.triangles[t].normal);
            // The plane of a narrow triangle is known near it only.
            let tilt = 2.0 * WELD_M / mesh.triangles[t].height_m;
            points.iter().all(|p| {
                let tolerance = MERGE_OFFSET_M.max(tilt * (p - origin).norm());
                normal.dot(&(p - origin)) <= tolerance
            })
        };
        // The neighbours first: nearly every part that is not convex is found out there.
        let locally = part.iter().all(|t| {
            let mut across = self.neighbours[*t].iter();
            across.all(|u| part.binary_search(u).is_err() || behind(*t, &mesh.corners(*u)))
        });
        locally && {
            let mut vertices: Vec<usize> = part
                .iter()
                .flat_map(|t| mesh.triangles[*t].corners)
                .collect();
            vertices.sort_unstable();
            vertices.dedup();
            let points: Vec<_> = vertices.into_iter().map(|i| mesh.vertices[i]).collect();
            part.iter().all(|t| behind(*t, &points))
        }
    }
}

/// The two sides of each wedge that is solid at an edge; None where the sides are not those of wedges, one beside the
/// other.
///
/// What stands wall to wall has four sides at an edge, or more. Seen along the edge, what is solid begins at a side
/// that runs along it and goes on clockwise to the next that runs the other way.
fn wedges(mesh: &Welded, edge: &[usize; 2], sides: &[Side]) -> Option<Vec<(usize, usize)>> {
    if let [(t, one), (u, other)] = sides {
        return (one != other).then(|| vec![(*t, *u)]);
    }
    if !sides.len().is_multiple_of(2) || sides.len() > LEAVES {
        return None;
    }
    let [start, end] = edge.map(|i| mesh.vertices[i]);
    let axis = Unit::try_new(end - start, 0.0)?;
    let aside = |t: usize| {
        let corners = mesh.triangles[t].corners;
        let tip = corners.iter().find(|i| !edge.contains(i))?;
        let to_tip = mesh.vertices[*tip] - start;
        Some(to_tip - *axis * axis.dot(&to_tip))
    };
    let zero = aside(sides[0].0)?;
    let angle = |(t, along): &Side| {
        let aside = aside(*t)?;
        let angle = axis.dot(&zero.cross(&aside)).atan2(zero.dot(&aside));
        Some((*t, *along, angle))
    };
    let angles: Vec<_> = sides.iter().map(angle).collect::<Option<_>>()?;
    let (along, against): (Vec<_>, Vec<_>) = angles.into_iter().partition(|(_, along, _)| *along);
    let clockwise = |from: f64, to: f64| {
        let turn = (from - to).rem_euclid(TAU);
        // Walls that touch have nothing between them.
        if turn < FLAT_RAD { turn + TAU } else { turn }
    };
    let next = |(t, _, from): &(usize, bool, f64)| {
        let nearest = |(u, _, to): &(usize, bool, f64)| (clockwise(*from, *to), *u);
        let nearest = against
            .iter()
            .map(nearest)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, u)| (*t, u))
    };
    let pairs: Vec<_> = along.iter().map(next).collect::<Option<_>>()?;
    let mut ends: Vec<usize> = pairs.iter().map(|(_, u)| *u).collect();
    ends.sort_unstable();
    ends.dedup();
    (ends.len() == against.len()).then_some(pairs)
}

/// Signed volume of a closed part, positive when its normals point outward, m³.
fn volume(mesh: &Welded, part: &[usize]) -> f64 {
    // Seen from a vertex of the part, so that a part far from the origin loses no digits.
    let Some(origin) = part.first().map(|t| mesh.corners(*t)[0]) else {
        return 0.0;
    };
    let of_triangle = |t: &usize| {
        let [a, b, c] = mesh.corners(*t).map(|p| p - origin);
        a.dot(&b.cross(&c)) / 6.0
    };
    part.iter().map(of_triangle).sum()
}

/// Area of a part, m².
fn area(mesh: &Welded, part: &[usize]) -> f64 {
    part.iter().map(|t| mesh.triangles[*t].area_m2).sum()
}

/// Disjoint sets of triangles.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn new(count: usize) -> Self {
        Self {
            parent: (0..count).collect(),
        }
    }

    fn root(&mut self, mut t: usize) -> usize {
        while self.parent[t] != t {
            self.parent[t] = self.parent[self.parent[t]];
            t = self.parent[t];
        }
        t
    }

    /// The smaller root stays one, so that the result does not depend on the order of joins.
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// The sets, each sorted, in the order of their first triangles.
    fn lists(mut self) -> Vec<Vec<usize>> {
        let mut lists: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for t in 0..self.parent.len() {
            lists.entry(self.root(t)).or_default().push(t);
        }
        lists.into_values().collect()
    }
}
