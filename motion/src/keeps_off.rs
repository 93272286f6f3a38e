//! Whether what was computed before bodies were there keeps off them.

use std::ops::Range;

use nalgebra::{Point3, Vector3};
use robot_model::collision::closest;
use robot_model::{Configuration, Kinematics};

use crate::clearance::TOLERANCE_M;
use crate::problem::MotionContext;
use crate::segment::Segment;

/// Whether every link keeps the clearance of postures from bodies of the world, by index, in all of these configurations.
pub fn keeps_off<'q>(
    context: &MotionContext,
    configurations: impl IntoIterator<Item = &'q Configuration>,
    bodies: &Range<usize>,
) -> bool {
    let (shapes, world) = (
        context.robot.collision.shapes(),
        context.environment.world(),
    );
    let least_m = context.posture.clearance_m - TOLERANCE_M;
    let balls: Vec<(Point3<f64>, f64)> = (shapes.iter())
        .map(|shape| shape.geometry.bounds())
        .map(|(centre_G, half)| (centre_G, half.norm()))
        .collect();
    let mut kinematics = None;
    configurations.into_iter().all(|q| {
        let kinematics = kinematics.get_or_insert_with(|| Kinematics::new(context.robot, q));
        kinematics.update(context.robot, q);
        shapes
            .iter()
            .zip(&balls)
            .all(|(shape, (centre_G, radius_m))| {
                let X_WG = kinematics.X_WB[shape.body] * shape.X_BG;
                let (centre_W, reach) = (X_WG * centre_G, Vector3::repeat(*radius_m));
                let near = world.near(&(centre_W - reach), &(centre_W + reach), least_m);
                let mut near = near.into_iter().filter(|body| bodies.contains(body));
                near.all(|body| {
                    let body = &world.obstacles()[body];
                    let found = closest(
                        &shape.geometry,
                        &X_WG,
                        body.geometry(),
                        body.pose(),
                        least_m,
                    );
                    found.is_none_or(|found| found.distance >= least_m)
                })
            })
    })
}

impl Segment {
    /// Whether every sample of it keeps the clearance of postures from bodies of the world, by index.
    pub fn keeps_off(&self, context: &MotionContext, bodies: &Range<usize>) -> bool {
        let samples = self.configurations();
        let configurations: Result<Vec<_>, _> =
            samples.map(|q| context.robot.configuration(q)).collect();
        configurations.is_ok_and(|all| keeps_off(context, &all, bodies))
    }
}
