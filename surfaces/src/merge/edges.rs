//! What ends a merged face at the edges of its outline.
//!
//! Every edge of an outline that goes into a face leaves a trace with its kind. An edge of the union
//! has the kind of the traces that it lies along; where one view saw that the face ends, it ends, be
//! it hidden in another. An edge along no trace was cut where a view looked through the face, and is
//! real. So is one beyond which a view looked through the plane.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};

use super::Config;
use super::sheet::Sheet;
use super::sight::Sight;
use crate::edge::{self, ring_edges};
use crate::outline::Outline;
use crate::{ConvexPolygon, EdgeKind, Surface};

/// An edge of an outline that went into a face, in the face's frame P.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trace {
    pub a: Point2<f64>,
    pub b: Point2<f64>,
    /// Unit normal out of the face.
    pub out: Vector2<f64>,
    pub kind: EdgeKind,
    /// Distance by which the face's pieces are taken back along it, m.
    pub inset_m: f64,
    /// The member whose outline it is of, its ring (`None`: the polygon) and its edge there.
    pub of: (usize, Option<usize>, usize),
}

/// A strip beyond an edge begins and ends so far from it, m: three cells wide, of which a view
/// looks through blocks of two.
const STRIP_M: [f64; 2] = [0.01, 0.07];
/// The face ends where this part of the strip was looked through.
const THROUGH_MIN: f64 = 0.5;
/// Traces that turn away from an edge by more than 45° are not those of it.
const ALIKE: f64 = 0.7;
/// Places along an edge are this far apart, m, and no more of them are looked at.
const APART_M: f64 = 0.02;
const PLACES_MAX: usize = 32;

/// The traces of a surface's outline, or of its polygon where it has none, in a frame P on its plane.
///
/// `pieces` are the surfaces that share its outline, itself among them.
pub(super) fn traces(
    member: usize,
    surface: &Surface,
    pieces: &[&Surface],
    X_PS: &Isometry3<f64>,
) -> Vec<Trace> {
    let mut traces = Vec::new();
    let mut add = |ring: &[[f64; 2]], turn: f64, number: Option<usize>| {
        for (edge, (a, b)) in ring_edges(ring).enumerate() {
            let kind = match number {
                Some(ring) => surface.outline_edge(ring, edge),
                None => surface.polygon_edges.get(edge).copied().unwrap_or_default(),
            };
            let Some(along) = (b - a).try_normalize(1e-9) else {
                continue;
            };
            let out = Vector2::new(along.y, -along.x) * turn;
            let inset_m = (pieces.iter())
                .filter_map(|piece| kept(surface, piece, &a, &b))
                .fold(0.0, f64::max);
            let trace = Trace {
                a,
                b,
                out,
                kind,
                inset_m,
                of: (member, number, edge),
            };
            traces.push(trace.moved(X_PS));
        }
    };
    // The first ring is the outer one; the face is on the same side of all of them.
    let turn = surface.outline.first().map_or(1.0, |ring| {
        let doubled: f64 = ring_edges(ring)
            .map(|(a, b)| a.coords.perp(&b.coords))
            .sum();
        doubled.signum()
    });
    for (number, ring) in surface.outline.iter().enumerate() {
        add(ring, turn, Some(number));
    }
    if surface.outline.is_empty() {
        let ring: Vec<[f64; 2]> = surface.polygon.clone().into();
        add(&ring, 1.0, None);
    }
    traces
}

/// The distance by which a piece is taken back at an edge in the frame of `surface` along which it lies.
fn kept(surface: &Surface, piece: &Surface, a: &Point2<f64>, b: &Point2<f64>) -> Option<f64> {
    let X_ps = piece.X_WS.inverse() * surface.X_WS;
    let [a, b] = [a, b].map(|p| (X_ps * Point3::new(p.x, p.y, 0.0)).xy());
    let found = edge::bound(&piece.polygon, &a, &b, edge::ALONG_M)?;
    piece.insets_m().get(found.edge).copied()
}

impl Trace {
    /// The same in another frame of the plane.
    pub fn moved(mut self, X_QP: &Isometry3<f64>) -> Self {
        let onto = |p: &Point2<f64>| (X_QP * Point3::new(p.x, p.y, 0.0)).xy();
        (self.a, self.b) = (onto(&self.a), onto(&self.b));
        self.out = (X_QP.rotation * Vector3::new(self.out.x, self.out.y, 0.0)).xy();
        self
    }

    /// Distance of a point from it.
    fn distance(&self, p: &Point2<f64>) -> f64 {
        let along = self.b - self.a;
        let t = (p - self.a).dot(&along) / along.norm_squared().max(1e-18);
        (p - (self.a + along * t.clamp(0.0, 1.0))).norm()
    }

    /// The strip of the plane beyond it.
    fn strip(&self) -> Outline {
        let [near, far] = STRIP_M.map(|d| self.out * d);
        let corners = [self.a + near, self.b + near, self.b + far, self.a + far];
        Outline::from_rings(&[corners.iter().map(|p| [p.x, p.y]).collect()])
    }
}

/// The kinds of the edges of rings in P, whose region is on their left.
pub(super) fn kinds(
    traces: &[Trace],
    rings: &[Vec<[f64; 2]>],
    config: &Config,
) -> Vec<Vec<EdgeKind>> {
    let at = |p: &Point2<f64>, out: &Vector2<f64>| {
        let mut nearest: Option<(f64, EdgeKind)> = None;
        for trace in traces.iter().filter(|t| t.out.dot(out) > ALIKE) {
            let off = trace.distance(p);
            if off > config.edge_near_m {
                continue;
            }
            if trace.kind == EdgeKind::Real {
                return EdgeKind::Real;
            }
            if trace.kind != EdgeKind::Seam && nearest.is_none_or(|(least, _)| off < least) {
                nearest = Some((off, trace.kind));
            }
        }
        nearest.map_or(EdgeKind::Real, |(_, kind)| kind)
    };
    let of_edge = |edge| EdgeKind::most(places(edge).map(|(p, out)| at(&p, &out)));
    let of_ring = |ring: &Vec<[f64; 2]>| ring_edges(ring).map(of_edge).collect();
    rings.iter().map(of_ring).collect()
}

/// The distances by which the edges of a piece in P are taken back: as far as a view that saw an edge
/// there takes its own back, and what that lies farther inside; of several views the one that goes
/// farthest out. Of an edge's places the largest; `otherwise_m` where no view has an edge, and nothing
/// at seams.
pub(super) fn insets_m(
    traces: &[Trace],
    piece: &ConvexPolygon,
    kinds: &[EdgeKind],
    otherwise_m: f64,
    config: &Config,
) -> Vec<f64> {
    let at = |p: &Point2<f64>, out: &Vector2<f64>| {
        let near = (traces.iter())
            .filter(|t| t.out.dot(out) > ALIKE)
            .map(|t| (t.distance(p), t.inset_m))
            .filter(|(off, _)| *off <= config.edge_near_m);
        let least = near.map(|(off, inset_m)| off + inset_m).reduce(f64::min);
        least.unwrap_or(otherwise_m)
    };
    let edges = piece.edges().map(|(a, b)| (*a, *b)).zip(kinds);
    let of_edge = |(edge, kind): ((Point2<f64>, Point2<f64>), &EdgeKind)| match kind {
        EdgeKind::Seam => 0.0,
        _ => places(edge)
            .map(|(p, out)| at(&p, &out))
            .fold(0.0, f64::max),
    };
    edges.map(of_edge).collect()
}

/// Places along an edge that has the face on its left, and the normal out of the face there.
fn places((a, b): (Point2<f64>, Point2<f64>)) -> impl Iterator<Item = (Point2<f64>, Vector2<f64>)> {
    let along = b - a;
    let out = Vector2::new(along.y, -along.x).normalize();
    let count = ((along.norm() / APART_M).ceil() as usize).clamp(1, PLACES_MAX);
    (0..count).map(move |i| (a + along * ((i as f64 + 0.5) / count as f64), out))
}

/// Makes edges real beyond which a view looked through the plane.
pub(super) fn look_beyond(sheet: &mut Sheet, sight: &Sight, config: &Config) {
    let open = |trace: &Trace| trace.kind != EdgeKind::Real && trace.kind != EdgeKind::Seam;
    let zone = (sheet.traces.iter())
        .filter(|trace| open(trace))
        .fold(Outline::default(), |zone, trace| zone.union(&trace.strip()));
    if zone.is_empty() {
        return;
    }
    let looked = sheet.looked(sight, &zone, config);
    if looked.through.is_empty() {
        return;
    }
    for trace in sheet.traces.iter_mut().filter(|trace| open(trace)) {
        let strip = trace.strip();
        if strip.common(&looked.through).area() >= THROUGH_MIN * strip.area() {
            trace.kind = EdgeKind::Real;
        }
    }
}

/// Gives members that stay as they are the kinds that their edges now have.
pub(super) fn relabel(members: &mut [Surface], traces: &[Trace]) {
    for index in 0..members.len() {
        // Pieces of one outline left their traces once, by the first of them.
        let first = (0..index).find(|&i| members[i].shares_outline(&members[index]));
        let of = first.unwrap_or(index);
        let surface = &mut members[index];
        let mut kinds = surface.outline_edges.clone();
        let mut changed = false;
        for trace in traces.iter().filter(|trace| trace.of.0 == of) {
            let kind = match trace.of {
                (_, Some(ring), edge) => kinds.get_mut(ring).and_then(|k| k.get_mut(edge)),
                (_, None, edge) => surface.polygon_edges.get_mut(edge),
            };
            if let Some(kind) = kind.filter(|kind| **kind != trace.kind) {
                *kind = trace.kind;
                changed = true;
            }
        }
        if changed && !surface.outline.is_empty() {
            surface.set_outline_edges(kinds);
        }
    }
}
