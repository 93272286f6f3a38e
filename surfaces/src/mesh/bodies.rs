//! The convex bodies of a mesh, for collision avoidance.
//!
//! A closed convex part is one body, exactly: there is no far side to be pushed out of. Of every
//! other part each face is a body of its own, the face covered by convex pieces and each piece
//! extruded inward. A piece is extruded to a smaller polygon: a prism behind the last face before
//! an edge would stick out of the next one where they meet at less than a right angle.

#![allow(non_snake_case)]

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::face;
use super::topology::Topology;
use super::weld::Welded;
use crate::bounds::Bounds;
use crate::conservative_bodies::{column, far_side_m};
use crate::{ConvexPolygon, Face, Obstacle, cover};

/// The bodies of the whole mesh: solids first, then faces, then single triangles.
pub(super) fn bodies(
    mesh: &Welded,
    topology: &Topology,
    all_faces: &[Face],
    thickness_m: f64,
) -> Vec<Obstacle> {
    let mut bodies = Vec::new();
    for (i, part) in topology.solids.iter().enumerate() {
        bodies.push(solid(mesh, part, format!("mesh/solid{i}")));
    }
    let open: Vec<usize> = (0..mesh.triangles.len())
        .filter(|t| topology.solid[*t].is_none())
        .collect();
    if open.is_empty() {
        return bodies;
    }
    let (faces, broken) = face::faces(mesh, topology, &open);
    // What may end a body: the far sides of all parts, solids included.
    let mut far: Vec<(Bounds, &Face, ConvexPolygon)> = Vec::new();
    for face in all_faces {
        let bounds = |piece: &ConvexPolygon| Bounds::new(&face.prism_W(piece, 0.0));
        far.extend(
            pieces(face)
                .into_iter()
                .map(|piece| (bounds(&piece), face, piece)),
        );
    }
    for (i, face) in faces.iter().enumerate() {
        for (j, piece) in pieces(face).into_iter().enumerate() {
            let reach = Bounds::new(&face.prism_W(&piece, thickness_m));
            let near = far.iter().filter(|(bounds, _, _)| bounds.overlaps(&reach));
            let behind = [column(&piece)];
            let entry = |(_, other, its): &(_, &Face, ConvexPolygon)| {
                far_side_m(face, &behind, other, &[its.vertices()])
            };
            let depth_m = near.filter_map(entry).fold(thickness_m, f64::min);
            bodies.push(frustum(face, &piece, depth_m, format!("mesh/face{i}.{j}")));
        }
    }
    for t in broken.into_iter().flatten() {
        bodies.push(prism(mesh, t, thickness_m));
    }
    bodies
}

/// The whole of a face that only has to be avoided as convex pieces, however many it takes.
fn pieces(face: &Face) -> Vec<ConvexPolygon> {
    let whole = cover::Config {
        coverage: 1.0 - 1e-6,
        // A square centimetre: what is left is smaller than what a robot's shape is known to. A face
        // smaller than that is covered all the same.
        gain_min_m2: f64::min(1e-4, 0.01 * face.region.area()),
        pieces_max: 256,
        vertices_max: usize::MAX,
        seeds_max: 48,
    };
    let pieces = cover::cover(&face.region, &whole).pieces.into_iter();
    pieces.map(|piece| piece.polygon).collect()
}

/// The vertices of a convex part at which it has a corner.
fn solid(mesh: &Welded, part: &[usize], id: String) -> Obstacle {
    let mut around: BTreeMap<usize, Vec<Vector3<f64>>> = BTreeMap::new();
    for t in part {
        for v in mesh.triangles[*t].corners {
            around.entry(v).or_default().push(mesh.triangles[*t].normal);
        }
    }
    let corners = around.iter().filter(|(_, normals)| is_corner(normals));
    let points_W = corners.map(|(v, _)| mesh.vertices[*v]).collect();
    Obstacle {
        id,
        points_W,
        surface: None,
        assumed: false,
    }
}

/// Whether the normals around a vertex span all directions: in the middle of a face they agree,
/// on an edge between two faces they lie in one plane.
fn is_corner(normals: &[Vector3<f64>]) -> bool {
    // The normals of coordinates with single precision, 1e-7, are not told apart.
    const APART: f64 = 1e-6;
    let Some(first) = normals.first() else {
        return false;
    };
    let crosses = normals.iter().map(|n| first.cross(n));
    let widest = crosses.fold(
        Vector3::zeros(),
        |a: Vector3<f64>, b| {
            if b.norm() > a.norm() { b } else { a }
        },
    );
    normals
        .iter()
        .any(|n| widest.dot(n).abs() > APART * widest.norm())
        && widest.norm() > APART
}

/// A piece extruded inward to a polygon that is smaller by the depth on every side.
fn frustum(face: &Face, piece: &ConvexPolygon, depth_m: f64, id: String) -> Obstacle {
    let (_, radius) = piece.inscribed_circle();
    // A narrow piece gets a ridge, not a point: nine tenths of what would leave nothing.
    let back = piece.inset(depth_m.min(0.9 * radius));
    let mut points_W = face.prism_W(piece, 0.0);
    points_W.truncate(piece.vertices().len());
    let behind = face.prism_W(back.as_ref().unwrap_or(piece), depth_m);
    points_W.extend(&behind[behind.len() / 2..]);
    Obstacle {
        id,
        points_W,
        surface: None,
        assumed: false,
    }
}

/// A triangle extruded inward.
fn prism(mesh: &Welded, t: usize, thickness_m: f64) -> Obstacle {
    let front = mesh.corners(t);
    let inward = -mesh.triangles[t].normal * thickness_m;
    Obstacle {
        id: format!("mesh/triangle{t}"),
        points_W: front.into_iter().chain(front.map(|p| p + inward)).collect(),
        surface: None,
        assumed: false,
    }
}
