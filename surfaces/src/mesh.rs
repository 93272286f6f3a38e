//! A triangle mesh of a known environment → its faces and the bodies to avoid.
//!
//! 1. Weld: vertices at one place become one, triangles without an area are dropped.
//! 2. Mend: edges that end against the middle of others are split there; triangles that are wound otherwise
//!    than most of what they are connected with are turned.
//! 3. Topology: what is connected, closed, convex, wound one way.
//! 4. Faces: triangles in one plane are merged, over joints too; a face may have holes and need not be convex.
//! 5. Bodies: a convex solid is one body; of all else every face is covered by thin bodies.
//!
//! Normals point where the winding says: counter-clockwise seen from the free side. A closed mesh
//! that is wound the other way is the inside of a room, so no part is turned round as a whole; the
//! [`Report`] says what the winding looks like.

mod bodies;
mod face;
mod mend;
mod topology;
mod weld;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::{Error, FACE_AREA_MIN_M2, FACE_WIDTH_MIN_M, Face, Terrain};
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

/// Vertices nearer than this are one, and triangles narrower than this have no area, m.
const WELD_M: f64 = 1e-5;
/// Largest angle between the normals of triangles in one face, rad.
const MERGE_ANGLE_RAD: f64 = 0.01;
/// Largest distance of a face's vertices from its plane, m.
const MERGE_OFFSET_M: f64 = 0.001;
/// A gap in a face that is no wider is none, m: soles and balls bridge the joints of tiles (2 to 5 mm) and of boards
/// (5 to 6 mm). A sole's edge over one has its hold this much farther in, less than any margin of balance; a ball of 10
/// mm sinks in by half a millimetre.
const GAP_M: f64 = 0.006;

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
    /// Edges of more than two triangles that are not the sides of solids, one beside the other.
    pub crowded_edges: usize,
    /// Edges that were split where others end on them.
    pub stitched_edges: usize,
    /// Triangles that were turned, since most of what they are connected with is wound the other way.
    pub turned_triangles: usize,
    /// Edges whose two triangles are wound in opposite ways all the same: one of the two normals is wrong.
    pub flipped_edges: usize,
    /// Closed parts whose normals all point inward, as those of a room seen from inside.
    pub inward_parts: usize,
    /// Closed convex parts, each kept as one body.
    pub solids: usize,
    /// Closed convex parts without an inside: their faces are kept, not the body.
    pub flat_parts: usize,
    /// Plane faces that are large enough to touch.
    pub faces: usize,
    /// Plane faces that are too small or too narrow.
    pub faces_dropped: usize,
    /// Part of the mesh's area that those are.
    pub part_dropped: f64,
    /// Faces whose outline could not be used; their triangles are still obstacles.
    pub faces_broken: usize,
}

/// The faces and the bodies of a mesh.
///
/// Faces are named `m0`, `m1`, … by falling area. The mesh's bodies are the obstacles of the terrain;
/// those behind the faces of what is no convex solid are `thickness_m` deep.
/// # Errors
/// [`Error::Shape`] for a vertex beyond the world or that is not there, and where no triangle has an area;
/// [`Error::Value`] for a thickness below a micrometre.
pub fn extract(mesh: &TriangleMesh, thickness_m: f64) -> Result<(Terrain, Report), Error> {
    if !(thickness_m.is_finite() && thickness_m >= 1e-6) {
        return Err(Error::bad(
            "thickness_m",
            thickness_m,
            "finite and at least 1e-6",
        ));
    }
    let mut welded = Welded::new(mesh)?;
    let (stitched_edges, turned_triangles, edges) = welded.mend();
    let topology = Topology::new(&welded, &edges);
    let all: Vec<usize> = (0..welded.triangles.len()).collect();
    let whole = face::faces(&welded, &topology, &all);
    let (all_faces, broken) = &whole;
    let large = |face: &&Face| {
        let wide = || !face.inset_region(0.0, 0.5 * FACE_WIDTH_MIN_M).is_empty();
        face.region.area() >= FACE_AREA_MIN_M2 && wide()
    };
    let faces: Vec<Face> = (all_faces.iter().filter(large).enumerate())
        .map(|(number, face)| Face {
            id: format!("m{number}").into(),
            ..face.clone()
        })
        .collect();
    let area_m2 = |faces: &[Face]| faces.iter().map(|face| face.region.area()).sum::<f64>();
    let (all_m2, large_m2) = (area_m2(all_faces), area_m2(&faces));
    let report = Report {
        triangles: mesh.triangles.len(),
        degenerate_triangles: welded.degenerate,
        welded_vertices: welded.merged,
        stitched_edges,
        turned_triangles,
        faces: faces.len(),
        faces_dropped: all_faces.len() - faces.len(),
        part_dropped: (all_m2 - large_m2) / all_m2.max(f64::MIN_POSITIVE),
        faces_broken: broken.len(),
        ..topology.report
    };
    let obstacles = bodies::bodies(&welded, &topology, &whole, thickness_m);
    Ok((Terrain::new(faces, obstacles)?, report))
}

#[cfg(test)]
mod tests;
