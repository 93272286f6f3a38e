//! The convex bodies of a mesh, for collision avoidance.
//!
//! A closed convex part is one body, exactly: there is no far side to be pushed out of. Of every
//! other part each face is a body of its own, the face covered by convex pieces and each piece
//! extruded inward. A piece is extruded to a smaller polygon: a prism behind the last face before
//! an edge would stick out of the next one where they meet at less than a right angle.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::MERGE_OFFSET_M;
use super::face;
use super::topology::Topology;
use super::weld::Welded;
use crate::bounds::{BoundsTree, around};
use crate::conservative_bodies::{column, far_side_m};
use crate::outline::Outline;
use crate::{ConvexPolygon, Face, Obstacle, Region, cover};

/// The bodies of the whole mesh: solids first, then faces, then single triangles. `all` are the faces of
/// the whole mesh and the triangles of those that are beyond use.
pub(super) fn bodies(
    mesh: &Welded,
    topology: &Topology,
    all: &(Vec<Face>, Vec<Vec<usize>>),
    thickness_m: f64,
) -> Vec<Obstacle> {
    let mut bodies = Vec::new();
    for (i, part) in topology.solids.iter().enumerate() {
        bodies.push(solid(mesh, part, format!("mesh/solid{i}")));
    }
    let is_open = |t: &usize| topology.solid[*t].is_none();
    let open: Vec<usize> = (0..mesh.triangles.len()).filter(is_open).collect();
    if open.is_empty() {
        return bodies;
    }
    let of_open;
    let (faces, broken) = if topology.solids.is_empty() {
        all
    } else {
        of_open = face::faces(mesh, topology, &open);
        &of_open
    };
    // What may end a body: the far sides of all parts, solids included.
    let far = covered(&all.0);
    let bounds = |(face, piece): &(usize, ConvexPolygon)| around(&all.0[*face].prism_W(piece, 0.0));
    let tree = BoundsTree::new(far.iter().map(bounds));
    let own = if topology.solids.is_empty() {
        far.clone()
    } else {
        covered(faces)
    };
    for (number, (i, piece)) in own.iter().enumerate() {
        let face = &faces[*i];
        let reach = around(&face.prism_W(piece, thickness_m));
        let behind = [column(piece)];
        let entry = |near: usize| {
            let (other, its) = &far[near];
            far_side_m(face, &behind, &all.0[*other], &[its.vertices()])
        };
        let near = tree.meeting(&reach, MERGE_OFFSET_M);
        let depth_m = near.filter_map(entry).fold(thickness_m, f64::min);
        bodies.push(frustum(
            face,
            piece,
            depth_m,
            format!("mesh/face{i}.{number}"),
        ));
    }
    for t in broken.iter().flatten() {
        bodies.push(prism(mesh, *t, thickness_m));
    }
    bodies
}

/// A region of more edges is halved before it is covered, which costs the square of its edges.
const EDGES_MAX: usize = 64;
/// A region smaller than this along both axes is not halved, m.
const HALVED_M: f64 = 0.01;

/// The whole of each face as convex pieces, however many it takes, with the number of the face.
fn covered(faces: &[Face]) -> Vec<(usize, ConvexPolygon)> {
    let mut pieces = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        let parts = if face.region.segments().count() <= EDGES_MAX {
            vec![face.region.clone()]
        } else {
            halved(Outline::from(&face.region))
        };
        let of_part = parts.iter().flat_map(whole);
        pieces.extend(of_part.map(|piece| (i, piece)));
    }
    pieces
}

/// The parts of a region that is cut in halves until each has few edges.
fn halved(region: Outline) -> Vec<Region> {
    let mut parts = Vec::new();
    let mut rest = region.parts();
    while let Some(part) = rest.pop() {
        let Some((low, high)) = part.bounds() else {
            continue;
        };
        let axis = (high - low).imax();
        if part.corners() <= EDGES_MAX || high[axis] - low[axis] <= HALVED_M {
            parts.extend(part.regions());
            continue;
        }
        let middle = 0.5 * (low[axis] + high[axis]);
        let (mut first, mut second) = ((low, high), (low, high));
        first.1[axis] = middle;
        second.0[axis] = middle;
        for (low, high) in [first, second] {
            let half = Outline::from_rectangles(&[(low.into(), high.into())]);
            rest.extend(part.common(&half).parts());
        }
    }
    parts
}

/// The whole of a region as convex pieces.
fn whole(region: &Region) -> Vec<ConvexPolygon> {
    let whole = cover::Config {
        coverage: 1.0 - 1e-6,
        // A square centimetre: what is left is smaller than what a robot's shape is known to. A face
        // smaller than that is covered all the same.
        gain_min_m2: f64::min(1e-4, 0.01 * region.area()),
        pieces_max: 256,
        vertices_max: usize::MAX,
        seeds_max: 48,
    };
    let pieces = cover::cover(region, &whole).pieces.into_iter();
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

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    #[test]
    fn a_region_of_many_edges_is_halved_and_nothing_of_it_is_lost() {
        // A disc with three hundred teeth.
        let tooth = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / 600.0;
            let radius = if k.is_multiple_of(2) { 1.0 } else { 0.95 };
            Point2::new(radius * angle.cos(), radius * angle.sin())
        };
        let disc = Region::new([(0..600).map(tooth).collect::<Vec<_>>()]).unwrap();
        let parts = halved(Outline::from(&disc));
        let edges = parts.iter().map(|part| part.segments().count());
        assert!(edges.max() <= Some(EDGES_MAX) && parts.len() > 5);
        let area: f64 = parts.iter().map(Region::area).sum();
        assert!((area - disc.area()).abs() < 1e-6, "{area}");
        // At most a square centimetre of each part is left bare.
        for part in &parts {
            let pieces = whole(part);
            let union =
                |all: Outline, piece: &ConvexPolygon| all.union(&Outline::from_polygon(piece));
            let covered = pieces.iter().fold(Outline::default(), union);
            assert!(part.area() - covered.area() < 2e-4);
        }
    }
}
