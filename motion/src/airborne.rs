//! How near a patch in the air may come to what it passes.

use nalgebra::{Isometry3, Point3, Vector3};
use posture::{FaceIndex, PlacedShape};
use robot_model::PatchId;
use robot_model::collision::Shape;

use crate::problem::{MotionContext, Swing, Task};
use crate::swing_path::STRAIGHT_M;

/// Cosine of 45°: a body is under the patch where the normal between them leans less from the patch's.
const OVER: f64 = 0.7;

/// Where a patch in the air is on its path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Airborne {
    patch: PatchId,
    leaves: Option<FaceIndex>,
    lands: Option<FaceIndex>,
    /// Height over the planes of the faces that it leaves and lands on, m.
    heights: (f64, f64),
    /// Distance from the nearer end, m.
    from_end: f64,
    /// The patch's normal; of a ball, which has none, that of the faces.
    normal: Vector3<f64>,
}

impl Airborne {
    pub fn new(context: &MotionContext, swing: &Swing, X_WC: &Isometry3<f64>) -> Self {
        let p = X_WC.translation.vector;
        let environment = context.environment;
        let radius = context.robot.patches[swing.patch].point_radius_m();
        // A ball touches a radius below its centre.
        let height = |face: Option<FaceIndex>| {
            face.map_or(f64::INFINITY, |f| {
                environment[f].height_of(&Point3::from(p)) - radius.unwrap_or(0.0)
            })
        };
        let ends = [swing.leaves, swing.lands].into_iter().flatten();
        let normal: Vector3<f64> = match radius {
            Some(_) => ends.map(|f| environment[f].normal_W()).sum(),
            None => X_WC.rotation * Vector3::z(),
        };
        let distance = |end: &Isometry3<f64>| (p - end.translation.vector).norm();
        let zone = 2.0 * STRAIGHT_M;
        let near = |end: &Isometry3<f64>| distance(end) < zone;
        Self {
            patch: swing.patch,
            // A face is excepted near the end that lies on it, not elsewhere.
            leaves: swing.leaves.filter(|_| near(&swing.from)),
            lands: swing.lands.filter(|_| near(&swing.to)),
            heights: (height(swing.leaves), height(swing.lands)),
            from_end: distance(&swing.from).min(distance(&swing.to)),
            normal: normal.try_normalize(1e-3).unwrap_or_else(Vector3::z),
        }
    }

    /// The face that the patch leaves or lands on, while it is near: what lies behind its plane need
    /// not be cleared.
    pub fn face(&self) -> Option<FaceIndex> {
        let near = |face: Option<FaceIndex>, height: f64| face.filter(|_| height < STRAIGHT_M);
        near(self.leaves, self.heights.0).or(near(self.lands, self.heights.1))
    }

    /// Whether a body of the environment is one that the patch may touch here.
    pub fn may_touch(&self, context: &MotionContext, obstacle: usize) -> bool {
        self.near_faces(context, obstacle).next().is_some()
    }

    /// The faces at the ends of the way of which a body is one to touch, with the height over the body, m: what rises
    /// over the plane a little is left that much later, or the way from touching it to being clear of it had a gap.
    fn near_faces(
        &self,
        context: &MotionContext,
        obstacle: usize,
    ) -> impl Iterator<Item = (FaceIndex, f64)> {
        let ends = [(self.leaves, self.heights.0), (self.lands, self.heights.1)];
        let over = move |(face, height): (Option<FaceIndex>, f64)| {
            let rise_m = context.environment.rise_m(face?, obstacle)?;
            Some((face?, height - rise_m)).filter(|(_, over)| *over < STRAIGHT_M)
        };
        ends.into_iter().filter_map(over)
    }

    /// The least distance, m, of a shape of the patch's body, or of one that carries it, to a body of the environment that
    /// the patch may touch here; nothing where it may not. A shank with a ball that moves by `moves_m` from one sample to
    /// the next keeps its clearance at the first sample below where it may touch: above that it was not looked at since the
    /// last one, and it may lie almost flat. A sole has nothing below it.
    pub fn contact_distance_m(
        &self,
        context: &MotionContext,
        shape: &Shape,
        obstacle: usize,
        moves_m: f64,
    ) -> Option<f64> {
        let patch = &context.robot.patches[self.patch];
        let near = self.near_faces(context, obstacle);
        let least_m = near.filter_map(|(face, over_m)| {
            let environment = context.environment;
            let least_m = environment.contact_distance_m(
                context.robot,
                (patch, face),
                shape,
                obstacle,
                context.posture.carrying_clearance_m(),
            )?;
            let is_sole = patch.point_radius_m().is_none();
            Some(match is_sole || over_m + moves_m < STRAIGHT_M {
                true => least_m,
                false => context.posture.clearance_m,
            })
        });
        least_m.min_by(f64::total_cmp)
    }

    /// The same of a body that rises gently beside where the patch leaves or lands.
    pub fn beside_contact_m(
        &self,
        context: &MotionContext,
        shape: &PlacedShape,
        obstacle: usize,
        moves_m: f64,
    ) -> Option<f64> {
        let patch = &context.robot.patches[self.patch];
        let ends = [(self.leaves, self.heights.0), (self.lands, self.heights.1)];
        let near = ends
            .into_iter()
            .filter(|(_, height)| height + moves_m < STRAIGHT_M);
        let least_m = near.filter_map(|(face, _)| {
            let on = (patch, face?);
            (context.environment).beside_contact_m(on, shape, obstacle)
        });
        least_m.min_by(f64::total_cmp)
    }

    /// The clearance, m, that is required to a body from which `normal_W` points to the patch, with `extra_m` where
    /// the path is free to go: the straight ends have what the postures there have.
    pub fn required_m(
        &self,
        context: &MotionContext,
        normal_W: &Vector3<f64>,
        extra_m: f64,
    ) -> f64 {
        let zones = self.from_end / (2.0 * STRAIGHT_M);
        let beside = context.posture.clearance_m;
        let extra_m = extra_m * (zones - 0.5).clamp(0.0, 1.0);
        if normal_W.dot(&self.normal) < OVER {
            return beside + extra_m;
        }
        beside + zones.min(1.0) * (context.config.swing_clearance_m - beside).max(0.0) + extra_m
    }
}

/// The least distance, m, of a shape to a body of the environment that a patch of its link, or of one that it carries, touches
/// or may touch in the air; nothing where there is none.
pub(crate) fn touching_m(
    context: &MotionContext,
    task: &Task,
    air: Option<&Airborne>,
    shape: &Shape,
    obstacle: usize,
    moves_m: f64,
) -> Option<f64> {
    let in_air = air.and_then(|air| air.contact_distance_m(context, shape, obstacle, moves_m));
    let closed = task.contact_distance_m(context, shape, obstacle);
    let least_m = in_air.into_iter().chain(closed);
    least_m.min_by(f64::total_cmp)
}
