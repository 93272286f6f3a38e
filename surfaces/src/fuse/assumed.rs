//! Bodies that stand for what was not seen give way to what another view saw.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::growing::GrowingFace;
use super::{TILT_MAX_RAD, TOLERANCE_M};
use crate::config::FACE_AREA_MIN_M2;
use crate::cover::{self, cover};
use crate::free_space::FreeSpace;
use crate::outline::Outline;
use crate::{ConvexPolygon, Obstacle};

/// A face of the set is that of an assumed body where it lies this near to its front, m.
const SAME_PLANE_M: f64 = 0.03;

/// The bodies, each with the number of its view: of the assumed prisms what no other view looked
/// through, and what is not on a face of the set by now; all others as they are.
pub(super) fn refuted(
    bodies: Vec<(usize, Obstacle)>,
    free_spaces: &[FreeSpace],
    set: &[GrowingFace],
) -> Vec<Obstacle> {
    let mut left = Vec::new();
    for (view, body) in bodies {
        let prism = Prism::of(&body).filter(|_| body.assumed && body.surface.is_none());
        let Some(prism) = prism else {
            left.push(body);
            continue;
        };
        let mut rest = prism.front.clone();
        let others = free_spaces.iter().enumerate().filter(|(i, _)| *i != view);
        for (_, free_space) in others {
            let carved = free_space.carved(&prism.X_WP, &rest, &|_| 0.0);
            rest = rest.minus(&carved.through);
        }
        for face in set.iter().filter(|face| face.changed) {
            if let Some(known) = prism.known_by(face) {
                rest = rest.minus(&known);
            }
        }
        if rest == prism.front {
            left.push(body);
            continue;
        }
        let rest = rest
            .simplified(TOLERANCE_M)
            .without_specks(FACE_AREA_MIN_M2);
        let regions = rest.regions();
        let pieces = regions
            .iter()
            .flat_map(|region| cover(region, &cover::BODIES).pieces);
        for (number, piece) in pieces.enumerate() {
            let id = match number {
                0 => body.id.clone(),
                _ => format!("{}.{number}", body.id),
            };
            left.push(Obstacle {
                id,
                points_W: prism.extruded(&piece.polygon),
                surface: None,
                assumed: true,
            });
        }
    }
    left
}

/// A body whose points are a convex ring and the same ring moved along its normal.
struct Prism {
    /// Frame on the front, z away from the body.
    X_WP: Isometry3<f64>,
    front: Outline,
    depth_m: f64,
}

impl Prism {
    fn of(body: &Obstacle) -> Option<Self> {
        let count = body.points_W.len() / 2;
        let (front, back) = body.points_W.split_at(count);
        let inward = back.first()? - front.first()?;
        let moved = |(a, b): (&Point3<f64>, &Point3<f64>)| (b - a - inward).norm() < 1e-6;
        if count < 3 || back.len() != count || !front.iter().zip(back).all(moved) {
            return None;
        }
        let z = -inward.try_normalize(1e-9)?;
        let x = (front[1] - front[0]).try_normalize(1e-9)?;
        let x = (x - z * z.dot(&x)).try_normalize(1e-9)?;
        let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let X_WP = Isometry3::from_parts(Translation3::from(front[0].coords), turn);
        let ring: Vec<_> = front
            .iter()
            .map(|p| X_WP.inverse_transform_point(p).xy())
            .collect();
        Some(Self {
            X_WP,
            front: Outline::from_polygon(&ConvexPolygon::hull(&ring).ok()?),
            depth_m: inward.norm(),
        })
    }

    /// The outline of a face that lies in the plane of the front, in P.
    fn known_by(&self, face: &GrowingFace) -> Option<Outline> {
        let z = self.X_WP.rotation * Vector3::z();
        let (low, high) = self.front.bounds()?;
        let middle = Point3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, 0.0);
        let near = face.in_P(&(self.X_WP * middle)).z.abs() < SAME_PLANE_M;
        let alike = z.dot(&face.normal_W()) >= TILT_MAX_RAD.cos();
        (near && alike).then(|| face.outline.moved(&(self.X_WP.inverse() * face.X_WP)))
    }

    fn extruded(&self, piece: &ConvexPolygon) -> Vec<Point3<f64>> {
        let at = |z: f64| {
            let corners = piece.vertices().iter();
            corners.map(move |p| self.X_WP * Point3::new(p.x, p.y, z))
        };
        at(0.0).chain(at(-self.depth_m)).collect()
    }
}
