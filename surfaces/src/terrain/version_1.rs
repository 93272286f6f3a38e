//! A file of version 1, which kept faces as convex pieces: those of one outline are one face again.

use nalgebra::{Isometry3, Point2, Point3};
use serde::Deserialize;
use serde_json::Value;

use super::{Terrain, read_each};
use crate::pose::Pose;
use crate::{ConvexPolygon, Edge, EdgeKind, Error, Face, Fit, Obstacle, Region, Ring, Source};

/// The value of the field `format`.
pub(super) const FORMAT: &str = "scandent-surfaces/1";

/// Corners of two outlines nearer than this are one, m: pieces of a face were moved one by one.
const SAME_CORNER_M: f64 = 0.005;
/// An edge of a piece lies along the outline's edges that are this near to it, m.
const ALONG_M: f64 = 0.01;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(rename = "format")]
    _format: String,
    surfaces: Vec<Value>,
    #[serde(default)]
    obstacles: Vec<Value>,
}

/// A convex piece of a face; what is written by hand has the first three fields.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    id: String,
    X_WS: Pose,
    polygon: Vec<[f64; 2]>,
    #[serde(default)]
    outline: Vec<Vec<[f64; 2]>>,
    #[serde(default)]
    outline_edges: Vec<Vec<EdgeKind>>,
    #[serde(default)]
    polygon_edges: Vec<PieceEdge>,
    #[serde(default)]
    inset_m: f64,
    #[serde(default)]
    edge_insets_m: Vec<f64>,
    /// What a body was widened by follows from the source.
    #[serde(default, rename = "edge_m")]
    _edge_m: f64,
    #[serde(default)]
    depth_m: f64,
    #[serde(default)]
    inliers: usize,
    #[serde(default)]
    rms_m: f64,
    #[serde(default)]
    plane_covariance: Option<[[f64; 3]; 3]>,
    #[serde(default)]
    source: Source,
    #[serde(default)]
    face: Option<String>,
}

/// What ends a piece at an edge: the face, or nothing where it goes on.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum PieceEdge {
    Between(Seam),
    Face(EdgeKind),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Seam {
    Seam,
}

/// A piece, checked.
struct Piece {
    X_WS: Isometry3<f64>,
    polygon: ConvexPolygon,
    record: Record,
}

impl TryFrom<File> for Terrain {
    type Error = Error;

    fn try_from(file: File) -> Result<Self, Error> {
        let mut groups: Vec<Vec<Piece>> = Vec::new();
        for record in read_each::<Record>("surface", file.surfaces)? {
            let piece = Piece::try_from(record)?;
            match groups
                .iter_mut()
                .find(|group| group[0].shares_outline(&piece))
            {
                Some(group) => group.push(piece),
                None => groups.push(vec![piece]),
            }
        }
        let mut faces: Vec<Face> = Vec::with_capacity(groups.len());
        for group in &groups {
            let first = &group[0].record;
            let name = first.face.as_ref().filter(|_| group.len() > 1);
            let taken = |name: &&String| faces.iter().any(|face| face.id.as_str() == *name);
            let id = name.filter(|name| !taken(name)).unwrap_or(&first.id);
            faces.push(face(id, group).map_err(|cause| cause.of_face(&first.id))?);
        }
        let mut obstacles: Vec<Obstacle> = read_each("obstacle", file.obstacles)?;
        for body in &mut obstacles {
            let has = |group: &Vec<Piece>| {
                group
                    .iter()
                    .any(|p| Some(&p.record.id) == body.surface.as_ref())
            };
            if let Some(index) = groups.iter().position(has) {
                body.surface = Some(faces[index].id.to_string());
            }
        }
        Self::new(faces, obstacles)
    }
}

impl TryFrom<Record> for Piece {
    type Error = Error;

    fn try_from(record: Record) -> Result<Self, Error> {
        let named = |cause: Error| cause.of_face(&record.id);
        let X_WS = Isometry3::try_from(record.X_WS).map_err(named)?;
        let polygon = ConvexPolygon::try_from(record.polygon.clone()).map_err(named)?;
        let edges = polygon.vertices().len();
        let counted = |field: &str, found: usize, expected: usize| {
            (found == 0 || found == expected)
                .then_some(())
                .ok_or_else(|| {
                    let wrong = format!("{field}: {found} entries for {expected} edges");
                    named(Error::Shape(wrong))
                })
        };
        counted("polygon_edges", record.polygon_edges.len(), edges)?;
        counted("edge_insets_m", record.edge_insets_m.len(), edges)?;
        for (ring, kinds) in record.outline_edges.iter().enumerate() {
            let points = record.outline.get(ring).map_or(0, Vec::len);
            counted("outline_edges", kinds.len(), points)?;
        }
        for inset_m in record.edge_insets_m.iter().chain([&record.inset_m]) {
            Error::check_not_negative("inset_m", *inset_m).map_err(named)?;
        }
        Ok(Self {
            X_WS,
            polygon,
            record,
        })
    }
}

impl Piece {
    /// Whether both are pieces of one connected part of a face: of one outline.
    fn shares_outline(&self, other: &Self) -> bool {
        let corner = |piece: &Self| {
            let [x, y] = *piece.record.outline.first()?.first()?;
            Some(piece.X_WS * Point3::new(x, y, 0.0))
        };
        let sizes = |piece: &Self| {
            piece
                .record
                .outline
                .iter()
                .map(Vec::len)
                .collect::<Vec<_>>()
        };
        let corners = corner(self).zip(corner(other));
        self.record.face.is_some()
            && self.record.face == other.record.face
            && sizes(self) == sizes(other)
            && corners.is_some_and(|(a, b)| (a - b).norm() < SAME_CORNER_M)
    }

    /// The distance by which the piece is taken back at one of its edges, m.
    fn inset_m(&self, edge: usize) -> f64 {
        let own = self.record.edge_insets_m.get(edge).copied();
        match self.record.polygon_edges.get(edge) {
            Some(PieceEdge::Between(_)) => own.unwrap_or(0.0),
            _ => own.unwrap_or(self.record.inset_m),
        }
    }

    /// How far what is left of the piece keeps from a segment in the frame of `first`, m, if an edge of
    /// the piece lies along it.
    fn kept_m(&self, first: &Self, ends: [Point2<f64>; 2]) -> Option<f64> {
        let X_ps = self.X_WS.inverse() * first.X_WS;
        let ends = ends.map(|p| (X_ps * Point3::new(p.x, p.y, 0.0)).xy());
        let along = (ends[1] - ends[0]).normalize();
        let gaps = self.polygon.edges().enumerate().filter_map(|(k, (a, b))| {
            let edge = (b - a).normalize();
            let gap_m = |p: &Point2<f64>| edge.perp(&(p - a)).abs();
            // Parallel and near, the one beside the other for some length.
            let [from, to] = ends.map(|p| edge.dot(&(p - a)));
            let common = to.max(from).min((b - a).norm()) - to.min(from).max(0.0);
            let near = ends.iter().map(gap_m).fold(0.0, f64::max);
            (edge.dot(&along).abs() > 0.9 && near <= ALONG_M && common > 0.0)
                .then(|| near + self.inset_m(k))
        });
        gaps.reduce(f64::max)
    }
}

/// The face of pieces of one outline, in the frame of the first.
fn face(id: &str, pieces: &[Piece]) -> Result<Face, Error> {
    let first = &pieces[0].record;
    let largest = |field: fn(&Record) -> f64| {
        pieces
            .iter()
            .map(|piece| field(&piece.record))
            .fold(0.0, f64::max)
    };
    let mut rings = Vec::new();
    for (number, ring) in first.outline.iter().enumerate() {
        let mut ring = Ring::from(ring.iter().map(|p| Point2::from(*p)).collect::<Vec<_>>());
        let kinds = first.outline_edges.get(number);
        let ends: Vec<[Point2<f64>; 2]> = ring.segments().map(|(_, [a, b])| [*a, *b]).collect();
        for (k, (edge, ends)) in ring.edges.iter_mut().zip(ends).enumerate() {
            let kept = pieces
                .iter()
                .filter_map(|piece| piece.kept_m(&pieces[0], ends));
            *edge = Edge {
                further_m: kept.reduce(f64::max).unwrap_or(largest(|s| s.inset_m)),
                ..Edge::new(
                    kinds
                        .and_then(|kinds| kinds.get(k))
                        .copied()
                        .unwrap_or_default(),
                )
            };
        }
        rings.push(ring);
    }
    if rings.is_empty() {
        let mut ring = Ring::from(pieces[0].polygon.vertices().to_vec());
        for (k, edge) in ring.edges.iter_mut().enumerate() {
            let kind = match first.polygon_edges.get(k) {
                Some(PieceEdge::Face(kind)) => *kind,
                _ => EdgeKind::Real,
            };
            *edge = Edge {
                further_m: pieces[0].inset_m(k),
                ..Edge::new(kind)
            };
        }
        rings.push(ring);
    }
    Ok(Face {
        plane_covariance: first.plane_covariance,
        fit: (first.inliers > 0).then_some(Fit {
            points: first.inliers,
            rms_m: first.rms_m,
        }),
        depth_m: largest(|s| s.depth_m),
        source: first.source,
        ..Face::new(id, pieces[0].X_WS, Region::new(rings)?)
    })
}
