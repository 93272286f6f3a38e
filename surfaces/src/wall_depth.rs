//! How deep the bodies of scanned walls are: as far as nothing is known to be there.
#![allow(non_snake_case)]

use nalgebra::{Point2, Point3};

use crate::bounds::Bounds;
use crate::conservative_bodies::{DEPTH_MIN_M, TOUCH_M, is_far_side};
use crate::cover::distance_to_segment;
use crate::{Face, Region, Source, WALL_RAD};

/// Places of a face so far apart tell where it is, m.
const APART_M: f64 = 0.02;

/// Deepens the bodies of scanned walls, up to `depth_max_m`, as far as nothing is known to be there.
///
/// - A face that looks the opposite way is the far side of the object: the body ends there.
/// - Before any other face under this one there is free space, at least in part: the body is as deep
///   as every body is taken to be.
/// - It ends before each of `free_W`, points that were seen, before which nothing stands; asked for
///   where there is a wall.
///
/// Units: m.  Frames: W.
pub fn deepen_walls(
    faces: &mut [Face],
    free_W: impl FnOnce() -> Vec<Point3<f64>>,
    depth_max_m: f64,
) {
    let is_wall =
        |face: &Face| face.source == Source::Scan && face.normal_W().z.abs() <= WALL_RAD.cos();
    let walls: Vec<usize> = (0..faces.len()).filter(|i| is_wall(&faces[*i])).collect();
    if walls.is_empty() {
        return;
    }
    let places_W = |face: &Face| -> Vec<Point3<f64>> {
        let places = face.region.lattice(APART_M).into_iter();
        places.map(|p| face.point_W(&p)).collect()
    };
    let shown_W: Vec<Vec<Point3<f64>>> = faces.iter().map(places_W).collect();
    let free_W = free_W();
    for wall in walls {
        faces[wall].depth_m = depth_m(&faces[wall], faces, &shown_W, &free_W, depth_max_m);
    }
}

/// How deep the body of a wall is, by places of all faces and by points before which nothing stands.
fn depth_m(
    wall: &Face,
    faces: &[Face],
    shown_W: &[Vec<Point3<f64>>],
    free_W: &[Point3<f64>],
    depth_max_m: f64,
) -> f64 {
    let column = Column::new(wall);
    let mut depth_m = depth_max_m;
    for (other, places_W) in faces.iter().zip(shown_W) {
        if !column.may_hold(other, depth_max_m) {
            continue;
        }
        if is_far_side(wall, other) {
            // The two sides of a sheet may lie in one plane.
            let end_m = column.nearest_m(places_W, -DEPTH_MIN_M, depth_m);
            depth_m = end_m.map_or(depth_m, |end_m| end_m.max(DEPTH_MIN_M));
        } else if column.nearest_m(places_W, TOUCH_M, depth_max_m).is_some() {
            return 0.0;
        }
    }
    column
        .nearest_m(free_W, TOUCH_M, depth_m)
        .unwrap_or(depth_m)
}

/// What is straight behind a wall, but for the rim, where neighbours touch it.
struct Column<'a> {
    wall: &'a Face,
    bounds: Bounds,
    /// Width of the rim, m; none where nothing else would be left.
    rim_m: f64,
}

impl<'a> Column<'a> {
    fn new(wall: &'a Face) -> Self {
        let outer = wall.region.rings()[0].vertices.iter();
        let corners: Vec<Point3<f64>> = outer.map(|p| Point3::new(p.x, p.y, 0.0)).collect();
        let lengths = wall.region.segments().map(|(_, [p, q])| (q - p).norm());
        let is_wide = wall.region.area() > 2.0 * TOUCH_M * lengths.sum::<f64>();
        Self {
            wall,
            bounds: Bounds::new(&corners),
            rim_m: if is_wide { TOUCH_M } else { 0.0 },
        }
    }

    /// Whether places of a face may be in the column down to a depth: it is not all to one side of it.
    fn may_hold(&self, face: &Face, to_m: f64) -> bool {
        let outer = face.region.rings()[0].vertices.iter();
        let X_FO = self.wall.X_WF.inverse() * face.X_WF;
        let corners: Vec<_> = outer.map(|p| X_FO * Point3::new(p.x, p.y, 0.0)).collect();
        let mut column = self.bounds.clone();
        (column.low.z, column.high.z) = (-to_m, DEPTH_MIN_M);
        Bounds::new(&corners).overlaps(&column)
    }

    /// The least depth behind the wall of points in the column, from one depth on and less than another.
    fn nearest_m(&self, points_W: &[Point3<f64>], from_m: f64, to_m: f64) -> Option<f64> {
        let X_WF = &self.wall.X_WF;
        let R = X_WF.rotation.to_rotation_matrix();
        let (x, y, z) = (
            R * nalgebra::Vector3::x(),
            R * nalgebra::Vector3::y(),
            self.wall.normal_W(),
        );
        let depth_m = |p_W: &Point3<f64>| {
            let p = p_W.coords - X_WF.translation.vector;
            let depth_m = -z.dot(&p);
            // Most are before the wall, or far behind it.
            (depth_m >= from_m
                && depth_m < to_m
                && self.contains(&Point2::new(x.dot(&p), y.dot(&p))))
            .then_some(depth_m)
        };
        points_W.iter().filter_map(depth_m).reduce(f64::min)
    }

    fn contains(&self, p: &Point2<f64>) -> bool {
        let (low, high) = (self.bounds.low, self.bounds.high);
        let within =
            |axis: usize| (low[axis] + self.rim_m..=high[axis] - self.rim_m).contains(&p[axis]);
        let clear = |region: &Region| {
            region
                .segments()
                .all(|(_, [a, b])| distance_to_segment(p, a, b) >= self.rim_m)
        };
        within(0) && within(1) && self.wall.region.contains(p) && clear(&self.wall.region)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use nalgebra::{Isometry3, Vector3};

    use super::*;

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
        deepen_walls(&mut faces, || free.to_vec(), 1.0);
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
            deepen_walls(&mut faces, Vec::new, 1.0);
            assert_eq!(faces, [face]);
        }
    }
}
