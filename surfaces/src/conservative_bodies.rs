//! Convex bodies that surely cover what may stand behind a face.
//!
//! What a robot may touch lies surely on the face: its edges are taken back. For collisions the
//! opposite must hold. The **body** of a face is one solid, whatever pieces it is computed by: all
//! points of the plane within m = [`Face::body_margin_m`] of the region, as deep as d,
//!
//!   B = { p_F : dist(p_xy, region) ≤ m, −d ≤ p_z ≤ 0 },   d = max(thickness, [`Face::depth_m`])
//!
//! [`Face::bodies_W`] are convex and hold all of B; none of their points is farther than 2 m from the
//! region.
//!
//! `brossette2013` extrudes each surface by a few centimetres. A distance algorithm that finds a link
//! past the middle of so thin a body pushes it out at the far side; nothing is known of what lies
//! behind a wall, so its body is as deep as what was seen allows: not into space that is known to be
//! free, and not through the far side of the object.
#![allow(non_snake_case)]

use nalgebra::{Point2, Point3};

use crate::cover::around;
use crate::{ConvexPolygon, Face, HalfPlane, Source, WALL_RAD};

/// A scanned face may go on beyond its region by this, m.
const EDGE_M: f64 = 0.015;
/// Pockets of a scanned region that are this shallow are filled, as a part of what its edges may be
/// off: with √2 at widened corners, 1.09 / 2 + √2 < 2.
const POCKET: f64 = 0.5;
/// What is this near to a body touches it and does not end it, m: the noise of neighbouring faces,
/// such as the riser under the front edge of a tread.
const TOUCH_M: f64 = 0.02;
/// The least depth of a body whose far side is known, m: it must stay a body.
const DEPTH_MIN_M: f64 = 1e-3;

impl Face {
    /// How far the body behind the face reaches beyond its region, in the plane, m: by what the edges
    /// of a scanned face may be off.
    pub fn body_margin_m(&self) -> f64 {
        match self.source {
            Source::Scan => EDGE_M,
            Source::File | Source::Robot | Source::Mesh => 0.0,
        }
    }

    /// The corners of convex bodies that hold all of the body behind the face, in W, m: prisms
    /// `thickness_m` deep, or [`Self::depth_m`] where that is more, none of whose points is farther
    /// than twice [`Self::body_margin_m`] from the region. None behind the face of a mesh, which is
    /// among the obstacles itself.
    ///
    /// Shapes: of each body the n corners of its front, then the same n moved against the normal.
    /// Source: `brossette2013` section IV-B, widened by what the edges of a scanned face may be off.
    pub fn bodies_W(&self, thickness_m: f64) -> Vec<Vec<Point3<f64>>> {
        self.prisms_W(thickness_m, self.body_margin_m())
    }

    /// The bodies of [`Self::bodies_W`], one by one, before they are widened by
    /// [`Self::body_margin_m`].
    pub fn cores_W(&self, thickness_m: f64) -> Vec<Vec<Point3<f64>>> {
        self.prisms_W(thickness_m, 0.0)
    }

    fn prisms_W(&self, thickness_m: f64, margin_m: f64) -> Vec<Vec<Point3<f64>>> {
        if self.source == Source::Mesh {
            return Vec::new();
        }
        let depth_m = thickness_m.max(self.depth_m);
        let fronts = self.pieces_around();
        let widened = fronts.iter().map(|front| front.grown(margin_m));
        widened.map(|front| self.prism_W(&front, depth_m)).collect()
    }

    /// Convex polygons that hold the region, and of a scanned one shallow pockets beside it.
    fn pieces_around(&self) -> Vec<ConvexPolygon> {
        around(&self.region, POCKET * self.body_margin_m())
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

/// Deepens the bodies of scanned walls, up to `depth_max_m`, as far as nothing is known to be there.
///
/// - A face that looks the opposite way is the far side of the object: the body ends there.
/// - Before any other face under this one there is free space, at least in part: the body is as deep
///   as every body is taken to be.
/// - It ends before each of `free_W`, points that were seen, before which nothing stands.
///
/// Units: m.  Frames: W.
pub fn deepen_walls(faces: &mut [Face], free_W: &[Point3<f64>], depth_max_m: f64) {
    let pieces: Vec<Vec<ConvexPolygon>> = faces.iter().map(Face::pieces_around).collect();
    for index in 0..faces.len() {
        let face = &faces[index];
        let wall = face.normal_W().z.abs() <= WALL_RAD.cos();
        if face.source != Source::Scan || !wall {
            continue;
        }
        let columns: Vec<ConvexPolygon> = pieces[index].iter().map(column).collect();
        let mut depth_m = depth_max_m;
        for (other, pieces) in faces.iter().zip(&pieces) {
            let limit_m = if is_far_side(face, other) {
                far_side_m(face, &columns, other, pieces)
            } else {
                let entry_m = entry_m(face, &columns, other, pieces, TOUCH_M);
                entry_m
                    .filter(|entry_m| *entry_m < depth_max_m)
                    .map(|_| 0.0)
            };
            depth_m = depth_m.min(limit_m.unwrap_or(depth_m));
        }
        for p_W in free_W {
            let p = face.X_WF.inverse_transform_point(p_W);
            if -p.z > TOUCH_M && columns.iter().any(|column| column.contains(&p.xy(), 0.0)) {
                depth_m = depth_m.min(-p.z);
            }
        }
        faces[index].depth_m = depth_m;
    }
}

/// The column behind a convex part of a face, without the rim where neighbours touch it.
pub(crate) fn column(piece: &ConvexPolygon) -> ConvexPolygon {
    piece.inset(TOUCH_M).unwrap_or_else(|| piece.clone())
}

/// Whether another face looks the opposite way, to 60°: it may be the far side of the same object.
fn is_far_side(face: &Face, other: &Face) -> bool {
    other.normal_W().dot(&face.normal_W()) < -0.5
}

/// The depth at which the far side of the same object ends columns behind a face, where it does, m.
pub(crate) fn far_side_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    pieces: &[ConvexPolygon],
) -> Option<f64> {
    // The two sides of a sheet may lie in one plane.
    let entry_m = || entry_m(face, columns, other, pieces, -DEPTH_MIN_M);
    let found = is_far_side(face, other).then(entry_m).flatten();
    found.map(|entry_m| entry_m.max(DEPTH_MIN_M))
}

/// The least depth, not less than `from_m`, at which another face is in one of the columns behind a
/// face.
fn entry_m(
    face: &Face,
    columns: &[ConvexPolygon],
    other: &Face,
    pieces: &[ConvexPolygon],
    from_m: f64,
) -> Option<f64> {
    let X_FO = face.X_WF.inverse() * other.X_WF;
    let of_pair = |(column, piece): (&ConvexPolygon, &ConvexPolygon)| {
        let at = |p: &Point2<f64>| X_FO * Point3::new(p.x, p.y, 0.0);
        let mut ring: Vec<Point3<f64>> = piece.vertices().iter().map(at).collect();
        for HalfPlane { n, b } in column.half_planes() {
            ring = clip(&ring, |p| n.dot(&p.xy().coords) - b);
        }
        ring = clip(&ring, |p| p.z + from_m);
        ring.iter().map(|p| -p.z).reduce(f64::min)
    };
    let pairs = columns
        .iter()
        .flat_map(|column| pieces.iter().map(move |piece| (column, piece)));
    pairs.filter_map(of_pair).reduce(f64::min)
}

/// The part of a convex ring in space where a linear function is not positive.
fn clip(ring: &[Point3<f64>], value: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (value_a, value_b) = (value(a), value(b));
        if value_a <= 0.0 {
            kept.push(*a);
        }
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            kept.push(a + (b - a) * (value_a / (value_a - value_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Isometry3, Vector2, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::Region;
    use crate::cover::distance_to_segment;
    use crate::face::faces;
    use crate::outline::Outline;
    use crate::polygon::tests::points;

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
        /// Prisms whose fronts lie in the plane; every point of the body is in one of them, and none of
        /// theirs is farther than twice the margin from the region.
        #[test]
        fn bodies_hold_the_body_and_little_else(
            face in faces(), size in prop_oneof![Just(1.0), 0.05..1.0_f64],
            thickness in 0.01..0.5, scanned: bool, places in points(40..41), turn in -3.0..3.0_f64,
        ) {
            let mut face = scaled(face, size);
            face.source = if scanned { Source::Scan } else { Source::File };
            let margin_m = face.body_margin_m();
            let whole = Outline::from(&face.region);
            let mut fronts = Vec::new();
            for body in face.bodies_W(thickness) {
                let (front, back) = body.split_at(body.len() / 2);
                for (p, q) in front.iter().zip(back) {
                    prop_assert!(face.height_of(p).abs() < 1e-9);
                    prop_assert!((q - p + face.normal_W() * thickness).norm() < 1e-9);
                }
                prop_assert!(face.is_behind(&body, 1e-9));
                let ring = front.iter().map(|p| face.X_WF.inverse_transform_point(p).xy());
                fronts.push(ConvexPolygon::hull(&ring.collect::<Vec<_>>()).unwrap());
            }
            let held = |p: &Point2<f64>| fronts.iter().any(|front| front.contains(p, 2e-6));
            let off_m = |p: &Point2<f64>| {
                if whole.contains(p) {
                    return 0.0;
                }
                let edges = face.region.segments();
                let gaps = edges.map(|(_, [a, b])| distance_to_segment(p, a, b));
                gaps.fold(f64::INFINITY, f64::min)
            };
            // Of the body: inside, on the edges, and as far beside them as it reaches.
            let inside = places.iter().map(|p| p * size).filter(|p| off_m(p) <= margin_m);
            let across = Vector2::new(turn.cos(), turn.sin());
            let edges = face.region.segments().flat_map(|(_, [a, b])| {
                let normal = HalfPlane::left_of(a, b).n;
                let along = [0.0, 0.3, 0.7].map(|part| a + (b - a) * part);
                along.into_iter().flat_map(move |p| [p, p + normal * margin_m, p + across * margin_m])
            });
            for p in inside.chain(edges) {
                prop_assert!(held(&p), "{p} is {} m off and bare", off_m(&p));
            }
            // Of the pieces: corners, and points between them and anywhere around.
            for front in &fronts {
                for (a, b) in front.edges() {
                    for part in [0.0, 0.2, 0.5, 0.8] {
                        let off_m = off_m(&(a + (b - a) * part));
                        prop_assert!(off_m <= 2.0 * margin_m + 2e-6, "{off_m} m off");
                    }
                }
            }
            for p in places.iter().map(|p| p * size).filter(held) {
                prop_assert!(off_m(&p) <= 2.0 * margin_m + 2e-6);
            }
            face.source = Source::Mesh;
            prop_assert!(face.bodies_W(thickness).is_empty());
        }
    }

    /// A face whose region is larger by a factor.
    fn scaled(mut face: Face, factor: f64) -> Face {
        let rings = face.region.rings().iter();
        let rings = rings.map(|ring| ring.vertices.iter().map(|p| p * factor).collect::<Vec<_>>());
        face.region = Region::new(rings).unwrap();
        face
    }

    #[test]
    fn teeth_as_shallow_as_a_pocket_are_no_bodies_of_their_own() {
        // 1 m × 0.3 m around a hole, with teeth along one side.
        let bodies = |tooth_m: f64| {
            let teeth = (0..=40).map(|k| {
                let y = 0.3 + tooth_m * f64::from(k % 2);
                Point2::new(1.0 - 0.025 * f64::from(k), y)
            });
            let corners = [[0.0, 0.0], [1.0, 0.0]].map(Point2::from);
            let hole = [[0.4, 0.1], [0.6, 0.1], [0.6, 0.2], [0.4, 0.2]].map(Point2::from);
            let outer = corners.into_iter().chain(teeth).collect();
            let mut face = Face::new(
                "f",
                Isometry3::identity(),
                Region::new([outer, hole.to_vec()]).unwrap(),
            );
            face.source = Source::Scan;
            face.bodies_W(0.03).len()
        };
        assert_eq!(bodies(0.0), 4);
        assert!(bodies(0.005) <= 6 && bodies(0.02) > 20);
    }
}
