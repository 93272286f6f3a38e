//! A triangle mesh of a known environment → its surfaces and the bodies to avoid.
//!
//! 1. Weld: vertices at one place become one, triangles without an area are dropped.
//! 2. Topology: what is connected, closed, convex, wound one way.
//! 3. Faces: triangles in one plane are merged; a face may have holes and need not be convex.
//! 4. Surfaces: each face is covered by convex pieces that may overlap and share the face's name.
//! 5. Bodies: a convex solid is one body; of all else every face is a thin body of its own.
//!
//! Normals point where the winding says: counter-clockwise seen from the free side. A closed mesh
//! that is wound the other way is the inside of a room, so nothing is turned round here; the
//! [`Report`] says what the winding looks like.

mod bodies;
mod face;
mod topology;
mod weld;

use nalgebra::{Isometry3, Point2, Point3};
use serde::{Deserialize, Serialize};

use crate::{ConvexPolygon, Error, Source, Surface, SurfaceSet, cover};
use face::Face;
use topology::Topology;
use weld::Welded;

/// Triangles in W.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// The vertices, m.
    pub vertices: Vec<Point3<f64>>,
    /// Three vertices each, counter-clockwise seen from the free side.
    pub triangles: Vec<[usize; 3]>,
}

/// How a mesh is taken apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Vertices nearer than this are one, and triangles narrower than this have no area, m.
    pub weld_m: f64,
    /// Largest angle between the normals of triangles in one face, rad.
    pub merge_angle_rad: f64,
    /// Largest distance of a face's vertices from its plane, m.
    pub merge_offset_m: f64,
    /// Smallest area of a face that becomes a surface, m².
    pub area_min_m2: f64,
    /// Smallest radius of the largest circle in a surface, m.
    pub radius_min_m: f64,
    /// Thickness of the bodies behind the faces of what is not a convex solid, m.
    pub thickness_m: f64,
    /// How faces are covered by convex surfaces.
    pub cover: cover::Config,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            weld_m: 1e-5,
            merge_angle_rad: 0.01,
            merge_offset_m: 0.001,
            area_min_m2: 0.005,
            radius_min_m: 0.02,
            thickness_m: 0.03,
            cover: cover::Config::default(),
        }
    }
}

/// What a mesh was like and what became of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Triangles given.
    pub triangles: usize,
    /// Triangles that were skipped because they have no area.
    pub degenerate_triangles: usize,
    /// Vertices that were merged into another one.
    pub welded_vertices: usize,
    /// Edges of one triangle only: the mesh is open there.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub crowded_edges: usize,
    /// Edges whose two triangles are wound in opposite ways: one of the two normals is wrong.
    pub flipped_edges: usize,
    /// Closed parts whose normals all point inward, as those of a room seen from inside.
    pub inward_parts: usize,
    /// Closed convex parts, each kept as one body.
    pub solids: usize,
    /// Plane faces that became surfaces.
    pub faces: usize,
    /// Plane faces that were too small or too narrow to become surfaces.
    pub faces_dropped: usize,
    /// Faces whose outline could not be used; their triangles are still obstacles.
    pub faces_broken: usize,
    /// Smallest covered part of a face that became surfaces, 0…1.
    pub coverage_min: f64,
}

/// The surfaces and the bodies of a mesh.
///
/// Surfaces are named `m0`, `m1`, … by falling area of their face, with `.0`, `.1`, … where a face
/// has several; those name the face in [`Surface::face`]. The mesh's bodies are the obstacles of
/// the set.
/// # Errors
/// [`Error::NonFiniteVertex`], [`Error::MeshIndex`], [`Error::EmptyMesh`], and
/// [`Error::BadNumber`] for a setting that is negative or not finite.
pub fn extract(mesh: &TriangleMesh, config: &Config) -> Result<(SurfaceSet, Report), Error> {
    config.check()?;
    let welded = Welded::new(mesh, config.weld_m)?;
    let topology = Topology::new(&welded, config);
    let mut report = Report {
        triangles: mesh.triangles.len(),
        degenerate_triangles: welded.degenerate,
        welded_vertices: welded.merged,
        open_edges: topology.open_edges,
        crowded_edges: topology.crowded_edges,
        flipped_edges: topology.flipped_edges,
        inward_parts: topology.inward_parts,
        solids: topology.solids.len(),
        coverage_min: 1.0,
        ..Report::default()
    };
    let all: Vec<usize> = (0..welded.triangles.len()).collect();
    let (faces, broken) = face::faces(&welded, &topology, &all, config);
    report.faces_broken = broken.len();
    let mut surfaces = Vec::new();
    for face in &faces {
        let pieces = face_surfaces(face, report.faces, config);
        let Some(pieces) = pieces else {
            report.faces_dropped += 1;
            continue;
        };
        report.coverage_min = report.coverage_min.min(pieces.coverage);
        report.faces += 1;
        surfaces.extend(pieces.surfaces);
    }
    let obstacles = bodies::bodies(&welded, &topology, &faces, config);
    Ok((SurfaceSet::new(surfaces, obstacles)?, report))
}

impl Config {
    fn check(&self) -> Result<(), Error> {
        for (field, value) in [
            ("weld_m", self.weld_m),
            ("merge_angle_rad", self.merge_angle_rad),
            ("merge_offset_m", self.merge_offset_m),
            ("area_min_m2", self.area_min_m2),
            ("radius_min_m", self.radius_min_m),
            ("thickness_m", self.thickness_m),
        ] {
            // Welding and thickness divide and extrude: they must be more than nothing.
            let least = if matches!(field, "weld_m" | "thickness_m") {
                1e-9
            } else {
                0.0
            };
            if !(value.is_finite() && value >= least) {
                return Err(Error::BadNumber {
                    field: field.into(),
                    value,
                    expected: "a finite number ≥ 0 (weld_m and thickness_m ≥ 1e-9)",
                });
            }
        }
        Ok(())
    }
}

struct FaceSurfaces {
    surfaces: Vec<Surface>,
    coverage: f64,
}

/// The surfaces of a face; None when it is too small or too narrow.
fn face_surfaces(face: &Face, number: usize, config: &Config) -> Option<FaceSurfaces> {
    if face.region.area() < config.area_min_m2 {
        return None;
    }
    let cover = cover::cover(&face.region, &config.cover);
    let wide = |p: &cover::Piece| p.polygon.inscribed_circle().1 >= config.radius_min_m;
    let polygons: Vec<ConvexPolygon> = cover
        .pieces
        .into_iter()
        .filter(wide)
        .map(|p| p.polygon)
        .collect();
    let name = format!("m{number}");
    let several = polygons.len() > 1;
    let mut surfaces = Vec::new();
    for (i, polygon) in polygons.into_iter().enumerate() {
        let id = if several {
            format!("{name}.{i}")
        } else {
            name.clone()
        };
        let mut surface = piece_surface(face, id, &polygon)?;
        surface.face = several.then(|| name.clone());
        surfaces.push(surface);
    }
    (!surfaces.is_empty()).then_some(FaceSurfaces {
        surfaces,
        coverage: cover.coverage,
    })
}

/// A piece of a face as a surface with its origin at the piece's centroid.
#[allow(non_snake_case)]
fn piece_surface(face: &Face, id: String, polygon: &ConvexPolygon) -> Option<Surface> {
    let centre = polygon.centroid().coords;
    let X_WS = face.X_WF * Isometry3::translation(centre.x, centre.y, 0.0);
    let moved = |p: &Point2<f64>| p - centre;
    let vertices = polygon.vertices().iter().map(moved).collect();
    let mut surface = Surface::new(id, X_WS, ConvexPolygon::new(vertices).ok()?);
    let ring = |ring: &Vec<Point2<f64>>| ring.iter().map(|p| moved(p).coords.into()).collect();
    surface.outline = face.region.rings().iter().map(ring).collect();
    surface.rms_m = face.rms_m;
    surface.source = Source::Mesh;
    Some(surface)
}

#[cfg(test)]
mod tests;
