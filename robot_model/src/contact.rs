//! Where a robot may touch the world.

use std::ops::Index;

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Translation3, Vector3};

/// One of a robot's patches, as [`Robot::patch_id`](crate::Robot::patch_id) finds it by name.
///
/// It belongs to the robot that gave it, whose `patches[id]` is the patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PatchId(pub(crate) usize);

impl PatchId {
    /// The patch's place in the robot's list of patches.
    pub fn index(self) -> usize {
        self.0
    }
}

impl Index<PatchId> for Vec<ContactPatch> {
    type Output = ContactPatch;

    fn index(&self, id: PatchId) -> &ContactPatch {
        &self[id.0]
    }
}

/// A patch of a robot's link that may bear contact.
///
/// An area's frame C has its origin in the patch's plane and z_C **outward from the environment**
/// (for a sole on the ground: up, into the robot). The contact holds when C lies in a surface's
/// plane with z_C = +z_S and the polygon lies inside the surface's polygon.
///
/// A point's frame C has its origin at the centre of a ball. The contact holds when that centre is
/// the ball's radius away from a surface's plane, on its outer side, and the ball's point nearest
/// to the plane lies inside the surface's polygon; how C is turned does not matter.
#[derive(Clone, Debug)]
pub struct ContactPatch {
    /// The patch's name, unique in the robot.
    pub name: String,
    /// The link it is given on.
    pub link: String,
    /// The body that link is lumped into.
    pub body: usize,
    /// Pose of C in that body.
    pub X_BC: Isometry3<f64>,
    /// Area or point.
    pub kind: PatchKind,
    /// Strictly convex vertices in C, counter-clockwise about z_C; m. A point has one vertex, C's
    /// origin.
    pub polygon: Vec<Point2<f64>>,
    /// What the patch may do: "foot", "hand", ….
    pub roles: Vec<String>,
    /// Coulomb friction coefficient of the patch.
    pub friction: f64,
}

/// How a patch touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PatchKind {
    /// With a flat polygon: it bears forces and moments.
    #[default]
    Area,
    /// With one point of a ball: it bears a force at that point and may roll.
    Point {
        /// Radius of the ball, m.
        radius_m: f64,
    },
}

impl ContactPatch {
    /// The ball's radius of a point patch, m; `None` for an area.
    pub fn point_radius_m(&self) -> Option<f64> {
        match self.kind {
            PatchKind::Area => None,
            PatchKind::Point { radius_m } => Some(radius_m),
        }
    }

    /// The pose of C that brings the patch into contact where X_WS is the pose of the touched
    /// place: its origin the touched point, its z outward from the environment.
    ///
    ///   p_WC = p_WS + radius · z_S   (point),   X_WC = X_WS   (area)
    pub fn touching(&self, X_WS: &Isometry3<f64>) -> Isometry3<f64> {
        let radius = self.point_radius_m().unwrap_or(0.0);
        X_WS * Translation3::new(0.0, 0.0, radius)
    }

    /// The point of the touched plane that is C's origin or nearest to it, in W, m, where X_WC has
    /// C's origin and, as its z, the touched surface's normal:
    ///
    ///   p_WC − radius · z   (point),   p_WC   (area)
    pub fn touched_W(&self, X_WC: &Isometry3<f64>) -> Vector3<f64> {
        let radius = self.point_radius_m().unwrap_or(0.0);
        (X_WC * Point3::new(0.0, 0.0, -radius)).coords
    }

    /// Whether the patch may take this role.
    pub fn has_role(&self, role: &str) -> bool {
        self.roles.iter().any(|r| r == role)
    }
}

/// A load nearer to the normal than this has no tangential part, sine of the angle.
const LEVEL: f64 = 1e-3;

/// The axes of the friction pyramid |f_x|, |f_y| ≤ μ/√2 f_z of a contact that is loaded along `load_W`
/// (down, for a weight): z is the normal, and where the load is not along it, the pyramid's edges, which
/// lie on the cone, are along its tangential part and across that. The load may then use the whole cone.
///
///   x = (t − s)/√2,   y = (t + s)/√2,   t the load's tangential part,   s = z × t
///
/// Without a tangential part the axes are `patch`'s.  Frames: all in W.
pub fn pyramid_axes_W(patch: &Matrix3<f64>, load_W: &Vector3<f64>) -> Matrix3<f64> {
    let z = patch.column(2).into_owned();
    let Some(t) = (load_W - z * z.dot(load_W)).try_normalize(LEVEL) else {
        return *patch;
    };
    let s = z.cross(&t);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Matrix3::from_columns(&[(t - s) * half, (t + s) * half, z])
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn a_weight_on_a_slope_may_use_the_whole_cone() {
        let turn = Rotation3::from_euler_angles(0.3, -0.2, 1.1);
        let axes = pyramid_axes_W(turn.matrix(), &-Vector3::z());
        assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-12);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
        assert!((axes.column(2) - turn.matrix().column(2)).amax() < 1e-12);
        let f = axes.transpose() * Vector3::z();
        let steepness = f.xy().norm() / f.z;
        // The pyramid's bound on either axis is μ/√2.
        let bound = steepness * std::f64::consts::FRAC_1_SQRT_2;
        assert!((f.x.abs() / f.z - bound).abs() < 1e-12);
        assert!((f.y.abs() / f.z - bound).abs() < 1e-12);
    }

    #[test]
    fn level_faces_keep_their_axes() {
        let turn = Rotation3::from_euler_angles(0.0, 0.0, 0.7);
        assert_eq!(
            pyramid_axes_W(turn.matrix(), &-Vector3::z()),
            *turn.matrix()
        );
    }
}
