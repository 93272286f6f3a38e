//! The usual posture with its base lowered over the feet, legs bent.

use nalgebra::{Isometry3, Vector3};
use robot_model::kinematics::{PointTarget, reach};
use robot_model::{Configuration, Kinematics};

use crate::context::SearchContext;

/// How near the soles come to their places, m.
const PLACED_M: f64 = 1e-3;
/// The base is lowered by this part of the legs' height at most, and so many depths are tried.
const LOWEST: f64 = 0.6;
const TRIALS: usize = 6;

/// The configuration with its base lowered by `low_m` and the soles where they are; nothing where legs do
/// not bend that far.
pub(crate) fn lowered(
    context: &SearchContext,
    usual: &Configuration,
    low_m: f64,
) -> Option<Configuration> {
    let robot = context.request.robot;
    let kinematics = Kinematics::new(robot, usual);
    let mut targets = Vec::new();
    for &foot in &context.feet {
        let patch = &robot.patches[foot];
        let X_WC = kinematics.X_WC(patch);
        let X_BC = kinematics.X_WB[patch.body].inverse() * X_WC;
        // Three points hold a sole's place and how it is turned.
        let points = match patch.point_radius_m() {
            Some(_) => &[Vector3::zeros()][..],
            None => &[0.1 * Vector3::x(), 0.1 * Vector3::y(), Vector3::zeros()][..],
        };
        targets.extend(points.iter().map(|p_C| PointTarget {
            body: patch.body,
            p_B: (X_BC * nalgebra::Point3::from(*p_C)).coords,
            p_W: (X_WC * nalgebra::Point3::from(*p_C)).coords,
        }));
    }
    let down = Isometry3::translation(0.0, 0.0, -low_m);
    let base = Isometry3::from_parts(usual.p_WB.into(), usual.R_WB);
    let start = usual.clone().with_base(&(down * base));
    reach(robot, &start, &targets, PLACED_M)
}

/// How much lower than usual the base can be, m.
pub(crate) fn deepest_m(context: &SearchContext, legs_m: f64) -> f64 {
    let depths = (1..=TRIALS)
        .rev()
        .map(|k| LOWEST * legs_m * k as f64 / TRIALS as f64);
    let mut can = depths.filter(|&depth_m| lowered(context, &context.upright, depth_m).is_some());
    can.next().unwrap_or(0.0)
}
