//! The convex bodies of a mesh, for collision avoidance.
//!
//! A closed convex part is one body, exactly: there is no far side to be pushed out of. Of every
//! other part each face is a body of its own, the face covered by convex pieces and each piece
//! extruded inward. A piece is extruded to a smaller polygon: a prism behind the last face before
//! an edge would stick out of the next one where they meet at less than a right angle.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::face::{self, Face};
use super::topology::Topology;
use super::weld::Welded;
use super::{Config, piece_surface};
use crate::{Obstacle, Surface, cover, thin_body};

/// The cover of faces that only have to be avoided: all of it, however many pieces it takes.
fn whole_cover() -> cover::Config {
    cover::Config {
        coverage: 1.0 - 1e-6,
        // A square centimetre: what is left is smaller than what a robot's shape is known to.
        gain_min_m2: 1e-4,
        pieces_max: 256,
        vertices_max: usize::MAX,
        seeds_max: 48,
    }
}

/// The bodies of the whole mesh: solids first, then faces, then single triangles.
pub(super) fn bodies(
    mesh: &Welded,
    topology: &Topology,
    all_faces: &[Face],
    config: &Config,
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
    let (faces, broken) = face::faces(mesh, topology, &open, config);
    // What may end a body: the far sides of all parts, solids included.
    let far: Vec<(Bounds, Surface)> = all_faces
        .iter()
        .flat_map(|face| pieces(face, "far"))
        .map(|piece| (Bounds::new(&piece.vertices_W()), piece))
        .collect();
    let depth = thin_body::Config {
        thickness_m: config.thickness_m,
        depth_max_m: config.thickness_m,
        ..thin_body::Config::default()
    };
    for (i, face) in faces.iter().enumerate() {
        let name = format!("mesh/face{i}");
        for (j, piece) in pieces(face, &name).into_iter().enumerate() {
            let reach = Bounds::new(&piece.thin_body(config.thickness_m).points_W);
            let near = far.iter().filter(|(bounds, _)| bounds.overlaps(&reach));
            let near: Vec<Surface> = near.map(|(_, piece)| piece.clone()).collect();
            let depth_m = thin_body::depth_m(&piece, &near, &[], &depth);
            bodies.push(frustum(&piece, depth_m, format!("{name}.{j}")));
        }
    }
    for t in broken.into_iter().flatten() {
        bodies.push(prism(mesh, t, config.thickness_m));
    }
    bodies
}

/// The whole of a face as convex pieces.
fn pieces(face: &Face, name: &str) -> Vec<Surface> {
    let mut config = whole_cover();
    // A face smaller than the least gain is covered all the same.
    config.gain_min_m2 = config.gain_min_m2.min(0.01 * face.region.area());
    let cover = cover::cover(&face.region, &config);
    let surfaces = cover.pieces.iter();
    surfaces
        .filter_map(|p| piece_surface(face, name.into(), &p.polygon))
        .collect()
}

/// The vertices of a convex part at which it has a corner.
#[allow(non_snake_case)]
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
#[allow(non_snake_case)]
fn frustum(piece: &Surface, depth_m: f64, id: String) -> Obstacle {
    let (_, radius) = piece.polygon.inscribed_circle();
    // A narrow piece gets a ridge, not a point: nine tenths of what would leave nothing.
    let inset = depth_m.min(0.9 * radius);
    let back = piece
        .polygon
        .inset(inset)
        .unwrap_or_else(|| piece.polygon.clone());
    let behind = Surface {
        polygon: back,
        ..piece.clone()
    };
    let inward = -piece.normal_W() * depth_m;
    let mut points_W = piece.vertices_W();
    points_W.extend(behind.vertices_W().iter().map(|p| p + inward));
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

/// A box along the axes of W.
struct Bounds {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Bounds {
    fn new(points: &[Point3<f64>]) -> Self {
        let fold = |pick: fn(f64, f64) -> f64, start: f64| {
            let init = Point3::from([start; 3]);
            points
                .iter()
                .fold(init, |a, b| Point3::from(a.coords.zip_map(&b.coords, pick)))
        };
        Self {
            low: fold(f64::min, f64::INFINITY),
            high: fold(f64::max, f64::NEG_INFINITY),
        }
    }

    /// Whether two boxes have a point in common, up to a millimetre.
    fn overlaps(&self, other: &Self) -> bool {
        let apart =
            |i: usize| self.low[i] > other.high[i] + 1e-3 || other.low[i] > self.high[i] + 1e-3;
        !(0..3).any(apart)
    }
}
