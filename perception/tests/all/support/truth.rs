//! The true faces of a world of boxes, and how those that were found compare.

use nalgebra::{Point2, Point3, Vector3};
use perception::Scan;
use surfaces::outline::Outline;

use super::camera::{Block, HEIGHT, WIDTH};

/// A face of one or more blocks: those of them that are coplanar make up one face.
pub struct Face<'a> {
    pub blocks: Vec<&'a Block>,
    /// Axis of the blocks along which the face looks, and its sign.
    pub axis: usize,
    pub sign: f64,
}

/// The upward face of the named blocks.
pub fn top<'a>(blocks: &'a [Block], names: &[&str]) -> Face<'a> {
    let blocks: Vec<&Block> = blocks.iter().filter(|b| names.contains(&b.name)).collect();
    assert_eq!(blocks.len(), names.len());
    Face {
        blocks,
        axis: 2,
        sign: 1.0,
    }
}

impl Face<'_> {
    pub fn normal_W(&self) -> Vector3<f64> {
        let mut axis = Vector3::zeros();
        axis[self.axis] = self.sign;
        self.blocks[0].pose.rotation * axis
    }

    /// Signed distance of a point from the face's plane.
    pub fn height(&self, p: &Point3<f64>) -> f64 {
        let local = self.blocks[0].pose.inverse_transform_point(p);
        self.sign * local[self.axis] - self.blocks[0].half[self.axis]
    }

    /// Whether the foot of the point on the face's plane lies on the face: on one of its blocks,
    /// and not inside another block that stands on it.
    pub fn holds(&self, p: &Point3<f64>, world: &[Block]) -> bool {
        let foot = p - self.normal_W() * self.height(p);
        let inside = |block: &&Block| block.holds(&foot, Some(self.axis));
        self.blocks.iter().any(inside) && !self.is_covered(p, world)
    }

    /// Whether something stands on the face's plane there.
    pub fn is_covered(&self, p: &Point3<f64>, world: &[Block]) -> bool {
        let above = p + self.normal_W() * (0.005 - self.height(p));
        world.iter().any(|block| block.holds(&above, None))
    }
}

/// The whole region of a face, in F.
pub fn whole(face: &surfaces::Face) -> Outline {
    Outline::from(&face.region)
}

/// The part of a face that may be touched: inside of two standard deviations of its edges, in F.
pub fn touchable(face: &surfaces::Face) -> Outline {
    face.inset_region(2.0, 0.0)
}

/// Lattice points in W of a part of a face with the given pitch.
pub fn lattice(face: &surfaces::Face, part: &Outline, pitch: f64) -> Vec<Point3<f64>> {
    let Some((low, high)) = part.bounds() else {
        return Vec::new();
    };
    let steps = |low: f64, high: f64| (low / pitch).ceil() as i64..=(high / pitch).floor() as i64;
    let mut points = Vec::new();
    for i in steps(low.x, high.x) {
        for j in steps(low.y, high.y) {
            let p = Point2::new(i as f64 * pitch, j as f64 * pitch);
            if part.contains(&p) {
                points.push(face.point_W(&p));
            }
        }
    }
    points
}

/// Whether a face lies on a true one: within 5° and, at its centroid, 3 cm of its plane, and with most of
/// its area on it.
pub fn lies_on(found: &surfaces::Face, face: &Face, world: &[Block]) -> bool {
    let points = || lattice(found, &whole(found), 0.03);
    let near = |points: Vec<Point3<f64>>| {
        let on = points.iter().filter(|p| face.holds(p, world)).count();
        2 * on > points.len()
    };
    found.normal_W().dot(&face.normal_W()) > 5.0_f64.to_radians().cos()
        && face.height(&found.point_W(&found.region.centroid())).abs() < 0.03
        && near(points())
}

/// The faces that lie on the true one, the largest first.
pub fn on_face<'a>(
    found: &'a [surfaces::Face],
    face: &Face,
    world: &[Block],
) -> Vec<&'a surfaces::Face> {
    let mut on: Vec<_> = found.iter().filter(|f| lies_on(f, face, world)).collect();
    on.sort_by(|a, b| b.region.area().total_cmp(&a.region.area()));
    on
}

/// Ratio of the area of parts of faces that is off the true one, root mean square distance of the parts
/// from its plane, and area of the union.
pub fn against(
    found: &[&surfaces::Face],
    part: fn(&surfaces::Face) -> Outline,
    face: &Face,
    world: &[Block],
) -> (f64, f64, f64) {
    let pitch = 0.01;
    let (mut off, mut square, mut count) = (0, 0.0, 0);
    let mut cells = std::collections::BTreeSet::new();
    for of in found {
        for p in lattice(of, &part(of), pitch) {
            off += usize::from(!face.holds(&p, world));
            square += face.height(&p).powi(2);
            count += 1;
            let local = face.blocks[0].pose.inverse_transform_point(&p);
            cells.insert([local.x, local.y].map(|c| (c / pitch).round() as i64));
        }
    }
    let n = count.max(1) as f64;
    (
        off as f64 / n,
        (square / n).sqrt(),
        cells.len() as f64 * pitch * pitch,
    )
}

/// How far a face is taken back before its coverage is measured, px: the drop-outs take 2 px off
/// an edge in the air, and where an edge is can be told to 1 px.
pub const EDGE_PX: usize = 3;

/// Points of the face, one a pixel that sees it and nothing else within [`EDGE_PX`], and the area
/// that each stands for but for a factor.
pub fn eroded(exact: &Scan, face: &Face, world: &[Block]) -> Vec<(Point3<f64>, f64)> {
    let depth = exact.depth.as_ref().unwrap();
    let (width, height) = (depth.width, depth.height);
    let point = |i: usize| {
        let p = exact.cloud.points[i].map(f64::from);
        exact.X_WV * Point3::from(p)
    };
    let on: Vec<bool> = (0..width * height)
        .map(|i| {
            let p = point(i);
            depth.z_m[i] > 0.0 && face.height(&p).abs() < 2e-3 && face.holds(&p, world)
        })
        .collect();
    let near = |k: usize, end: usize| k.saturating_sub(EDGE_PX)..(k + EDGE_PX + 1).min(end);
    (0..width * height)
        .filter(|i| {
            let (u, v) = (i % width, i / width);
            near(v, height).all(|v| near(u, width).all(|u| on[v * width + u]))
        })
        .map(|i| (point(i), f64::from(depth.z_m[i]).powi(3)))
        .collect()
}

/// Squared error of a face's (rotation about x_F, about y_F, offset along z_F), in units of its
/// covariance.
pub fn nees(found: &surfaces::Face, face: &Face) -> f64 {
    let n = found.X_WF.rotation.inverse() * face.normal_W();
    let height = face.height(&Point3::from(found.X_WF.translation.vector));
    let error = Vector3::new(-n.y / n.z, n.x / n.z, -height / n.z);
    let rows = found.plane_covariance.unwrap();
    let covariance = nalgebra::Matrix3::from_fn(|i, j| rows[i][j]);
    error.dot(&(covariance.try_inverse().unwrap() * error))
}
