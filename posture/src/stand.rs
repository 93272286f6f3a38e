//! Postures to begin with: a robot put on the ground or over its contacts.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, Kinematics, PatchId, Robot};

use crate::contact::{Contact, Freedom};

/// Weight of a contact's heading against a squared lever arm of a decimetre, m².
const HEADING_WEIGHT_M2: f64 = 0.01;

/// The posture with its base upright over the origin, the lowest vertex or ball of the patches at
/// z = 0; as high as it is where there are none.
pub fn on_level_ground(
    robot: &Robot,
    posture: &Configuration,
    patches: &[PatchId],
) -> Configuration {
    let upright = posture.clone().with_base(&Isometry3::identity());
    let kinematics = Kinematics::new(robot, &upright);
    let heights = patches.iter().flat_map(|&p| {
        let patch = &robot.patches[p];
        let pose = kinematics.X_WC(patch);
        let radius = patch.point_radius_m().unwrap_or(0.0);
        let vertices = patch.polygon.iter();
        vertices.map(move |v| (pose * Point3::new(v.x, v.y, 0.0)).z - radius)
    });
    let lowest = heights.fold(f64::INFINITY, f64::min);
    let height = if lowest.is_finite() { -lowest } else { 0.0 };
    upright.with_base(&Translation3::new(0.0, 0.0, height).into())
}

/// The posture with its base upright where the contacts would have it.
///
///   yaw = atan2(Σ a × b, Σ a · b),   p = mean of (target − R(yaw) place)
///
/// over a = a patch's place relative to the mean in `posture`, b = the same of its target, both
/// horizontal, and the headings of level contacts as unit vectors of small weight.
pub fn over_contacts(
    robot: &Robot,
    posture: &Configuration,
    contacts: &[Contact],
) -> Configuration {
    if contacts.is_empty() {
        return posture.clone();
    }
    let kinematics = Kinematics::new(robot, posture);
    let base = Isometry3::from_parts(posture.p_WB.into(), posture.R_WB).inverse();
    let place = |contact: &Contact| base * kinematics.X_WC(&robot.patches[contact.patch]);
    let places: Vec<Isometry3<f64>> = contacts.iter().map(place).collect();
    let mean = |poses: &mut dyn Iterator<Item = &Isometry3<f64>>| {
        poses.map(|x| x.translation.vector).sum::<Vector3<f64>>() / contacts.len() as f64
    };
    let mean_place = mean(&mut places.iter());
    let mean_target = mean(&mut contacts.iter().map(|contact| &contact.X_WC));
    let (mut sin, mut cos) = (0.0, 0.0);
    for (place, contact) in places.iter().zip(contacts) {
        let target = &contact.X_WC;
        let a = (place.translation.vector - mean_place).xy();
        let b = (target.translation.vector - mean_target).xy();
        sin += a.perp(&b);
        cos += a.dot(&b);
        // A ball has no heading, nor has a patch that may turn.
        let is_ball = robot.patches[contact.patch].point_radius_m().is_some();
        let has_heading = contact.freedom == Freedom::Fixed && !is_ball;
        let level = |x: &Isometry3<f64>| (x.rotation * Vector3::z()).z > 0.5;
        if has_heading && level(place) && level(target) {
            let a = (place.rotation * Vector3::x()).xy();
            let b = (target.rotation * Vector3::x()).xy();
            sin += HEADING_WEIGHT_M2 * a.perp(&b);
            cos += HEADING_WEIGHT_M2 * a.dot(&b);
        }
    }
    // Without any heading there is no turn: atan2(0, 0) = 0.
    let R_WB = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::atan2(sin, cos));
    let p_WB = mean_target - R_WB * mean_place;
    let base = Isometry3::from_parts(p_WB.into(), R_WB);
    posture.clone().with_base(&base)
}
