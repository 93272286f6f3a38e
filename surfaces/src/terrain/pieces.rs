//! Faces as convex pieces.

use nalgebra::{Isometry3, Vector2};

use super::Terrain;
use crate::config::{FACE_AREA_MIN_M2, FACE_WIDTH_MIN_M};
use crate::cover::{self, cover};
use crate::{ConvexPolygon, EdgeKind, Error, Face, Source, Surface, SurfaceSet, covariance, edge};

/// A further piece must add this part of the face, or this area, whichever is less.
const GAIN: f64 = 0.03;
const GAIN_M2: f64 = 0.06;
/// Of the outline along an edge of a piece the worst part of this size is left out: jags of it.
const JAGS: f64 = 0.25;

impl Terrain {
    /// Every face as convex pieces that may overlap, each taken back at its edges by what is known of
    /// those of the face with `k_sigma` standard deviations.
    ///
    /// # Errors
    /// Those of [`SurfaceSet::validate`].
    pub fn pieces(&self, k_sigma: f64) -> Result<SurfaceSet, Error> {
        let mut surfaces = Vec::new();
        let mut obstacles = self.obstacles.clone();
        for face in &self.faces {
            let pieces = face.pieces(k_sigma);
            for body in &mut obstacles {
                if body.surface.as_deref() == Some(face.id.as_str()) {
                    body.surface = pieces.first().map(|piece| piece.id.clone());
                }
            }
            surfaces.extend(pieces);
        }
        SurfaceSet::new(surfaces, obstacles)
    }
}

impl Face {
    /// The convex pieces of a face, the one that adds the most first.
    pub(crate) fn pieces(&self, k_sigma: f64) -> Vec<Surface> {
        pieces(self, k_sigma)
    }
}

fn pieces(face: &Face, k_sigma: f64) -> Vec<Surface> {
    let area_m2 = face.region.area();
    let config = cover::Config {
        coverage: 0.98,
        gain_min_m2: (GAIN * area_m2).clamp(FACE_AREA_MIN_M2, GAIN_M2),
        pieces_max: 12,
        vertices_max: 12,
        seeds_max: 12,
    };
    // What is given exactly is taken as it is, however small.
    let given = matches!(face.source, Source::File | Source::Robot);
    let polygons: Vec<ConvexPolygon> = match face.region.as_convex().filter(|_| given) {
        Some(whole) => vec![whole],
        None => {
            let found = cover(&face.region, &config).pieces.into_iter();
            let large = |p: &ConvexPolygon| {
                p.area() >= FACE_AREA_MIN_M2 && 2.0 * p.inscribed_circle().1 >= FACE_WIDTH_MIN_M
            };
            found.map(|piece| piece.polygon).filter(large).collect()
        }
    };
    let insets_m = face.edge_insets_m(k_sigma);
    let several = polygons.len() > 1;
    let numbered = polygons.iter().enumerate();
    let named = numbered.filter_map(|(number, polygon)| {
        let mut piece = piece(face, polygon)?;
        piece.set_insets(piece_insets_m(
            face,
            polygon,
            &piece.polygon_edges,
            &insets_m,
        ));
        if several {
            piece.id = format!("{}.{number}", face.id);
            piece.face = Some(face.id.to_string());
        }
        Some(piece)
    });
    named.collect()
}

/// One piece as a surface with its origin at its centroid.
fn piece(face: &Face, polygon: &ConvexPolygon) -> Option<Surface> {
    let centre = polygon.centroid().coords;
    let rings = face.region.rings().iter();
    let moved = |p: &nalgebra::Point2<f64>| [p.x - centre.x, p.y - centre.y];
    let corners: Vec<[f64; 2]> = polygon.vertices().iter().map(moved).collect();
    let carried = |rows| covariance::carried(rows, &Vector2::new(centre.x, centre.y));
    let mut surface = Surface {
        outline: rings
            .clone()
            .map(|ring| ring.vertices.iter().map(moved).collect())
            .collect(),
        depth_m: face.depth_m,
        inliers: face.fit.map_or(0, |fit| fit.points),
        rms_m: face.fit.map_or(0.0, |fit| fit.rms_m),
        plane_covariance: face.plane_covariance.as_ref().map(carried),
        source: face.source,
        ..Surface::new(
            face.id.as_str(),
            face.X_WF * Isometry3::translation(centre.x, centre.y, 0.0),
            corners.try_into().ok()?,
        )
    };
    let kinds = rings.map(|ring| ring.edges.iter().map(|edge| edge.kind).collect());
    surface.set_outline_edges(kinds.collect());
    Some(surface)
}

/// The distance by which each edge of a piece in F is taken back, m: as far as the face's edges along
/// it and near it ask for, but for the worst quarter of their length; nothing at seams.
fn piece_insets_m(
    face: &Face,
    polygon: &ConvexPolygon,
    kinds: &[EdgeKind],
    insets_m: &[Vec<f64>],
) -> Vec<f64> {
    let reach_m = insets_m
        .iter()
        .flatten()
        .copied()
        .fold(edge::ALONG_M, f64::max);
    let rings: Vec<Vec<[f64; 2]>> = (face.region.rings().iter())
        .map(|ring| ring.vertices.iter().map(|p| [p.x, p.y]).collect())
        .collect();
    // What each edge lacks of the parts of the outline that bound it, and their lengths.
    let mut parts: Vec<Vec<(f64, f64)>> = vec![Vec::new(); kinds.len()];
    edge::for_bounds(&polygon.half_planes(), &rings, reach_m, |ring, k, found| {
        parts[found.edge].push((insets_m[ring][k] - found.gap_m, found.length_m));
    });
    let worst = |parts: &mut Vec<(f64, f64)>| {
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut left = JAGS * parts.iter().map(|(_, length)| length).sum::<f64>();
        let beyond = parts.iter().find(|(_, length)| {
            left -= length;
            left < 0.0
        });
        beyond
            .or(parts.last())
            .map_or(0.0, |(lack, _)| lack.max(0.0))
    };
    parts.iter_mut().map(worst).collect()
}
