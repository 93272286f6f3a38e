//! What ends a fused face at its edges.
//!
//! Every edge of a region that goes into a face leaves a trace. An edge of the union is known as the
//! traces that it lies along; where one view saw that the face ends, it ends, be it hidden in another.
//! An edge along no trace was cut where a view looked through the face, and is real.

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};

use crate::cover::distance_to_segment;
use crate::free_space::CELL_M;
use crate::{Edge, EdgeKind, Face};

/// Traces are compared by what they leave with this many standard deviations.
const SIGMAS: f64 = 2.0;
/// An edge of the union lies along traces that are this near to it, m.
const NEAR_M: f64 = 0.03;
/// Traces that turn away from an edge by more than 45° are not those of it.
const ALIKE: f64 = 0.7;
/// Places along an edge are this far apart, m, and no more of them are looked at.
const APART_M: f64 = 0.02;
const PLACES_MAX: usize = 32;

/// An edge of a region that went into a face, in the face's frame P.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trace {
    pub ends: [Point2<f64>; 2],
    /// Unit normal out of the face.
    pub out: Vector2<f64>,
    /// What is known of it; its view is one of the growing face's.
    pub edge: Edge,
    /// Distance by which the face is taken back along it, m.
    inset_m: f64,
}

impl Trace {
    /// The traces of all edges of a face, ring by ring, in its frame.
    pub fn all(face: &Face) -> Vec<Self> {
        let insets_m = face.edge_insets_m(SIGMAS);
        let edges = face.region.segments().zip(insets_m.into_iter().flatten());
        let trace = |((edge, [a, b]), inset_m): ((&Edge, [&Point2<f64>; 2]), f64)| Self {
            ends: [*a, *b],
            out: outward([a, b]),
            edge: *edge,
            inset_m,
        };
        edges.map(trace).collect()
    }

    /// Moves it to another frame of the plane.
    pub fn move_by(&mut self, X_QP: &Isometry3<f64>) {
        self.ends = self.ends.map(|p| (X_QP * Point3::new(p.x, p.y, 0.0)).xy());
        self.out = (X_QP.rotation * Vector3::new(self.out.x, self.out.y, 0.0)).xy();
    }

    /// What is known of an edge of the union between two points, by the traces along it.
    ///
    /// Its kind is that of most of its places. Its errors are those of the trace that leaves most of
    /// the face at a place, of all places the one where that is least; half a cell of
    /// [`crate::free_space`] where there is no trace.
    pub fn along(traces: &[Self], ends: [&Point2<f64>; 2]) -> Edge {
        let out = outward(ends);
        let beside: Vec<&Self> = traces.iter().filter(|t| t.out.dot(&out) > ALIKE).collect();
        let cut = Edge {
            further_m: 0.5 * CELL_M,
            ..Edge::default()
        };
        let mut kinds = Vec::new();
        let mut worst: Option<(f64, Edge)> = None;
        for p in places(ends) {
            let near = beside
                .iter()
                .map(|t| (distance_to_segment(&p, &t.ends[0], &t.ends[1]), *t));
            let near: Vec<(f64, &Self)> = near.filter(|(off, _)| *off <= NEAR_M).collect();
            let least = |by: &dyn Fn(&(f64, &Self)) -> f64| {
                near.iter().min_by(|a, b| by(a).total_cmp(&by(b))).copied()
            };
            let real = near.iter().any(|(_, t)| t.edge.kind == EdgeKind::Real);
            let nearest = least(&|(off, _)| *off).filter(|_| !real);
            kinds.push(nearest.map_or(EdgeKind::Real, |(_, t)| t.edge.kind));
            let farthest = least(&|(off, t)| off + t.inset_m);
            let here = farthest.map_or((cut.further_m, cut), |(off, t)| (off + t.inset_m, t.edge));
            if worst.is_none_or(|(most, _)| here.0 > most) {
                worst = Some(here);
            }
        }
        Edge {
            kind: EdgeKind::most(kinds.into_iter()),
            ..worst.map_or(cut, |(_, edge)| edge)
        }
    }
}

/// The unit normal out of the region on the left of an edge.
fn outward([a, b]: [&Point2<f64>; 2]) -> Vector2<f64> {
    let along = (b - a).normalize();
    Vector2::new(along.y, -along.x)
}

/// Places along an edge.
fn places([a, b]: [&Point2<f64>; 2]) -> impl Iterator<Item = Point2<f64>> {
    let along = b - a;
    let count = ((along.norm() / APART_M).ceil() as usize).clamp(1, PLACES_MAX);
    (0..count).map(move |i| a + along * ((i as f64 + 0.5) / count as f64))
}
