//! Where faces may go on that the image's border cuts.
//!
//! A wall that leaves the image does not end there: such edges of its outline are labelled
//! [`EdgeKind::FieldOfView`]. Nothing was seen of the rest, so a body is assumed in its plane, as far as a robot could reach into it. Faces that one could stand on are
//! let be: their edges are found again by the robot's own feet, and a body in their plane would
//! stand in no one's way.
#![allow(non_snake_case)]

use nalgebra::{Point3, Vector2};
use surfaces::{EdgeKind, Face, Obstacle, UNSEEN_DEPTH_M, WALL_RAD};

/// Shorter edges are corners that the border rounds off, m.
const EDGE_MIN_M: f64 = 0.03;

/// A body beyond every edge of a steep face that the view's border cuts, in W.
pub(super) fn bodies(faces: &[Face], reach_m: f64) -> Vec<Obstacle> {
    let steep = |face: &&Face| reach_m > 0.0 && face.normal_W().z.abs() <= WALL_RAD.cos();
    let of_face = |face: &Face| -> Vec<Obstacle> {
        // The outer ring, which runs counter-clockwise.
        let segments = face.region.rings()[0].segments().enumerate();
        let cut = segments.filter(|(_, (edge, [a, b]))| {
            edge.kind == EdgeKind::FieldOfView && (*b - *a).norm() >= EDGE_MIN_M
        });
        cut.map(|(number, (_, [a, b]))| {
            let along = (b - a).normalize();
            let far = Vector2::new(along.y, -along.x) * reach_m;
            let ring = [*a, *b, b + far, a + far];
            let at = |z: f64| ring.map(|p| face.X_WF * Point3::new(p.x, p.y, z));
            Obstacle {
                id: format!("{}/beyond{number}", face.id),
                points_W: [at(0.0), at(-UNSEEN_DEPTH_M)].concat(),
                surface: None,
                assumed: true,
            }
        })
        .collect()
    };
    faces.iter().filter(steep).flat_map(of_face).collect()
}
