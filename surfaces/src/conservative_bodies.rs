//! Convex bodies that surely cover what may stand behind a face.
//!
//! What a robot may touch lies surely on the face: its edges are taken back. For collisions the
//! opposite must hold: bodies that surely cover the face. So each convex piece of a scanned face's
//! region is widened by what its edges may be off, and extruded against the normal.
//!
//! `brossette2013` extrudes each surface by a few centimetres. A distance algorithm that finds a link
//! past the middle of so thin a body pushes it out at the far side; nothing is known of what lies
//! behind a wall, so its body is as deep as what was seen allows: not into space that is known to be
//! free, and not through the far side of the object.
#![allow(non_snake_case)]

use std::cell::LazyCell;

use nalgebra::{Point2, Point3};

use crate::bounds::{Bounds, clip};
use crate::cover::{self, cover};
use crate::outline::Outline;
use crate::{ConvexPolygon, Face, HalfPlane, Region, Source, WALL_RAD};

/// A scanned face may go on beyond its region by this, m.
const EDGE_M: f64 = 0.005;
/// What is this near to a body touches it and does not end it, m: the noise of neighbouring faces,
/// such as the riser under the front edge of a tread.
const TOUCH_M: f64 = 0.02;
/// The least depth of a body whose far side is known, m: it must stay a body.
const DEPTH_MIN_M: f64 = 1e-3;
/// A piece that adds no more than this to those before it is left out, m²; of a body, what that leaves
/// bare is covered by triangles.
const REST_MAX_M2: f64 = 0.002;
/// What is left bare is widened by this at least, m: it must be a body.
const SLIVER_M: f64 = 5e-5;
/// What is smaller is left bare, m²: what rounding leaves between pieces.
const SPECK_M2: f64 = 1e-8;

impl Face {
    /// The corners of convex bodies that cover what is behind the face, in W, m: prisms behind convex
    /// pieces of its region, `thickness_m` deep or [`Self::depth_m`] where that is more. None behind
    /// the face of a mesh, which is among the obstacles itself.
    ///
    /// Shapes: of each body the n corners of its front, then the same n moved against the normal.
    /// Source: `brossette2013` section IV-B, widened by what the edges of a scanned face may be off.
    pub fn bodies_W(&self, thickness_m: f64) -> Vec<Vec<Point3<f64>>> {
        let edge_m = match self.source {
            Source::Mesh => return Vec::new(),
            Source::Scan => EDGE_M,
            Source::File | Source::Robot => 0.0,
        };
        let depth_m = thickness_m.max(self.depth_m);
        let mut fronts = fronts(self, edge_m);
        let bare = bare(&self.region, &fronts);
        fronts.extend(bare.iter().map(|part| part.grown(edge_m.max(SLIVER_M))));
        fronts
            .iter()
            .map(|front| self.prism_W(front, depth_m))
            .collect()
    }

    /// The prism behind a convex part of the plane, in W.
    pub(crate) fn prism_W(&self, front: &ConvexPolygon, depth_m: f64) -> Vec<Point3<f64>> {
        let at = |z: f64| {
            let corners = front.vertices().iter();
            corners.map(move |p| self.X_WF * Point3::new(p.x, p.y, z))
        };
        at(0.0).chain(at(-depth_m)).collect()
    }
}

/// Convex polygons that cover a face's region but for specks, each widened by `edge_m`.
fn fronts(face: &Face, edge_m: f64) -> Vec<ConvexPolygon> {
    let mut fronts: Vec<ConvexPolygon> = Vec::new();
    for piece in cover(&face.region, &cover::BODIES).pieces {
        if cover::area_outside(&piece.polygon, &fronts) > REST_MAX_M2 || fronts.is_empty() {
            fronts.push(piece.polygon.grown(edge_m));
        }
    }
    fronts
}

/// Triangles of what convex pieces leave bare of a region.
fn bare(region: &Region, fronts: &[ConvexPolygon]) -> Vec<ConvexPolygon> {
    let rings = fronts.iter().map(|front| front.vertices().to_vec());
    let left = Outline::from(region)
        .minus_all(rings)
        .without_specks(SPECK_M2);
    let triangles = left.regions().into_iter().flat_map(|part| part.triangles());
    triangles
        .filter_map(|t| ConvexPolygon::hull(&t).ok())
        .collect()
}

/// Deepens the bodies of scanned walls, up to `depth_max_m`, as far as nothing is known to be there.
///
/// - A face that looks the opposite way is the far side of the object: the body ends there.
/// - Before any other face under this one there is free space, at least in part: the body is as deep
///   as every body is taken to be.
/// - It ends before each of `free_W`, points that were seen, before which nothing stands.
///
/// Units: m.  Frames: W.
pub fn deepen_walls(faces: &mut [Face], free_W: &[Point3<f64>], depth_max_m: f64) {
    let is_wall = |face: &Face| face.normal_W().z.abs() <= WALL_RAD.cos();
    let walls =
        (0..faces.len()).filter(|i| faces[*i].source == Source::Scan && is_wall(&faces[*i]));
    let depth = |i: usize| (i, depth_m(&faces[i], faces, free_W, depth_max_m));
    let depths_m: Vec<(usize, f64)> = walls.map(depth).collect();
    for (index, depth_m) in depths_m {
        faces[index].depth_m = depth_m;
    }
}

/// How deep the body of a wall is. Little is in the box behind a face, and only where something is are the face's
/// convex parts needed.
fn depth_m(wall: &Face, faces: &[Face], free_W: &[Point3<f64>], depth_max_m: f64) -> f64 {
    let X_FW = wall.X_WF.inverse();
    let mut behind = Bounds::new(
        &wall
            .vertices_W()
            .iter()
            .map(|p_W| X_FW * p_W)
            .collect::<Vec<_>>(),
    );
    // Of a face wider than its rim nothing is left there.
    let length_m: f64 = (wall.region.segments())
        .map(|(_, [p, q])| (q - p).norm())
        .sum();
    if wall.region.area() > 2.0 * TOUCH_M * length_m {
        for axis in 0..2 {
            behind.low[axis] += TOUCH_M;
            behind.high[axis] -= TOUCH_M;
        }
    }
    behind.low.z = -depth_max_m;
    let columns =
        LazyCell::new(|| -> Vec<ConvexPolygon> { fronts(wall, 0.0).iter().map(column).collect() });
    let mut depth_m = depth_max_m;
    for other in faces {
        let far_side = is_far_side(wall, other);
        behind.high.z = if far_side { 0.0 } else { -TOUCH_M };
        let X_FO = X_FW * other.X_WF;
        let in_F = |p: &Point2<f64>| X_FO * Point3::new(p.x, p.y, 0.0);
        let outer = other.region.rings()[0].vertices.iter().map(in_F);
        if !behind.overlaps(&Bounds::new(&outer.collect::<Vec<_>>())) {
            continue;
        }
        let mut triangles = other.region.triangles();
        triangles.retain(|triangle| behind.cuts(&triangle.map(|p| in_F(&p))));
        if triangles.is_empty() {
            continue;
        }
        if far_side {
            let end_m = far_side_m(wall, &columns, other, &triangles);
            depth_m = depth_m.min(end_m.unwrap_or(depth_m));
        } else if entry_m(wall, &columns, other, &triangles, TOUCH_M)
            .is_some_and(|entry_m| entry_m < depth_max_m)
        {
            return 0.0;
        }
    }
    let (normal_W, origin_W) = (wall.normal_W(), wall.X_WF.translation.vector);
    for p_W in free_W {
        // Most are before the face, or farther behind it than another one.
        let beyond_m = normal_W.dot(&(origin_W - p_W.coords));
        if beyond_m <= 0.0 || beyond_m > depth_m {
            continue;
        }
        let p = wall.X_WF.inverse_transform_point(p_W);
        let within = |axis: usize| (behind.low[axis]..=behind.high[axis]).contains(&p[axis]);
        if -p.z > TOUCH_M
            && -p.z < depth_m
            && within(0)
            && within(1)
            && columns.iter().any(|column| column.contains(&p.xy(), 0.0))
        {
            depth_m = -p.z;
        }
    }
    depth_m
}

/// The column behind a convex part of a face, without the rim where neighbours touch it.
pub(crate) fn column(piece: &ConvexPolygon) -> ConvexPolygon {
    piece.inset(TOUCH_M).unwrap_or_else(|| piece.clone())
}

/// Whether another face looks the opposite way, to 60°: it may be the far side of the same object.
fn is_far_side(face: &Face, other: &Face) -> bool {
    other.normal_W().dot(&face.normal_W()) < -0.5
}

/// The depth at which the far side of the same object, by its convex parts, ends columns behind a face, where
/// it does, m.
pub(crate) fn far_side_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    parts: &[impl AsRef<[Point2<f64>]>],
) -> Option<f64> {
    // The two sides of a sheet may lie in one plane.
    let entry_m = || entry_m(face, columns, other, parts, -DEPTH_MIN_M);
    let found = is_far_side(face, other).then(entry_m).flatten();
    found.map(|entry_m| entry_m.max(DEPTH_MIN_M))
}

/// The least depth, not less than `from_m`, at which another face, by its convex parts, is in one of the columns
/// behind a face.
fn entry_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    parts: &[impl AsRef<[Point2<f64>]>],
    from_m: f64,
) -> Option<f64> {
    let X_FO = face.X_WF.inverse() * other.X_WF;
    let of_part = |part: &[Point2<f64>]| {
        let at = |p: &Point2<f64>| X_FO * Point3::new(p.x, p.y, 0.0);
        let ring: Vec<Point3<f64>> = part.iter().map(at).collect();
        let ring = clip(&ring, |p| p.z + from_m);
        let depth_m = |column: &ConvexPolygon| {
            let mut ring = ring.clone();
            for HalfPlane { n, b } in column.half_planes() {
                if ring.is_empty() {
                    break;
                }
                ring = clip(&ring, |p| n.dot(&p.xy().coords) - b);
            }
            ring.iter().map(|p| -p.z).reduce(f64::min)
        };
        columns.iter().filter_map(depth_m).reduce(f64::min)
    };
    let found = parts.iter().filter_map(|part| of_part(part.as_ref()));
    found.reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Isometry3, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::face::faces;

    /// A scanned square of the given half width whose normal is turned by `roll` about W's x axis.
    fn square(half: f64, at: [f64; 3], roll: f64) -> Face {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        let region = Region::new([corners.map(Point2::from).to_vec()]).unwrap();
        let pose = Isometry3::new(at.into(), Vector3::x() * roll);
        Face {
            source: Source::Scan,
            ..Face::new("f", pose, region)
        }
    }

    /// The depth of a wall that looks toward −y, 0.8 m square about the origin.
    fn depth(others: &[Face], free: &[Point3<f64>]) -> f64 {
        let mut faces = vec![square(0.4, [0.0; 3], FRAC_PI_2)];
        faces.extend_from_slice(others);
        deepen_walls(&mut faces, free, 1.0);
        faces[0].depth_m
    }

    #[test]
    fn unknown_space_behind_a_wall_is_filled_and_known_space_is_not() {
        let roll = |angle| FRAC_PI_2 + angle;
        // Parallel to it and farther away: behind its half, and beside it.
        let behind = square(0.5, [0.6, 0.7, 0.0], roll(0.0));
        let beside = square(0.5, [0.95, 0.7, 0.0], roll(0.0));
        let back = square(0.4, [0.0, 0.02, 0.0], roll(PI));
        // Square to it: its edge touches the rim of the column, or lies inside.
        let touching = square(0.35, [0.0, 0.35, 0.4], 0.0);
        let inside = square(0.35, [0.0, 0.35, 0.2], 0.0);
        assert_eq!(depth(&[], &[]), 1.0);
        assert_eq!(depth(&[beside, touching], &[]), 1.0);
        assert_eq!(depth(&[behind], &[]), 0.0);
        assert_eq!(depth(&[inside], &[]), 0.0);
        approx::assert_relative_eq!(depth(&[back], &[]), 0.02, epsilon = 1e-12);
        // Points behind, before and beside it.
        let points = [[0.1, 0.2, 0.1], [0.1, -0.2, 0.1], [0.5, 0.1, 0.1]].map(Point3::from);
        approx::assert_relative_eq!(depth(&[], &points), 0.2, epsilon = 1e-12);
        // A floor stays as thin as every body, and so does what no scan showed.
        for face in [
            square(0.4, [0.0; 3], 0.0),
            Face {
                source: Source::File,
                ..square(0.4, [0.0; 3], FRAC_PI_2)
            },
        ] {
            let mut faces = [face.clone()];
            deepen_walls(&mut faces, &[], 1.0);
            assert_eq!(faces, [face]);
        }
    }

    proptest! {
        /// Prisms whose fronts lie in the plane and cover the region widened by what a scanned edge
        /// may be off; nothing of a body is before the plane.
        #[test]
        fn bodies_cover_a_face(face in faces(), thickness in 0.01..0.5, scanned: bool) {
            let mut face = face;
            face.source = if scanned { Source::Scan } else { Source::File };
            let bodies = face.bodies_W(thickness);
            let mut fronts = Outline::default();
            for body in &bodies {
                let (front, back) = body.split_at(body.len() / 2);
                for (p, q) in front.iter().zip(back) {
                    prop_assert!(face.height_of(p).abs() < 1e-9);
                    prop_assert!((q - p + face.normal_W() * thickness).norm() < 1e-9);
                }
                prop_assert!(face.is_behind(body, 1e-9));
                let ring = front.iter().map(|p| face.X_WF.inverse_transform_point(p));
                let ring = ring.map(|p| [p.x, p.y]).collect();
                fronts = fronts.union(&Outline::from_rings(&[ring]));
            }
            let region = Outline::from(&face.region);
            let left = region.minus(&fronts).area();
            prop_assert!(left <= 1e-5 * (1.0 + region.area()), "{left} m² bare");
            if !scanned {
                prop_assert!(fronts.minus(&region).area() < 1e-3 * (1.0 + region.area()));
            }
            face.source = Source::Mesh;
            prop_assert!(face.bodies_W(thickness).is_empty());
        }
    }
}
