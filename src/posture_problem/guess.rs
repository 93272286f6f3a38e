//! Where the search for the posture of a problem starts.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use posture::{Contact, Environment, Place};
use robot_model::{Configuration, Kinematics, Robot};

/// Weight of a contact's heading against a squared lever arm of a decimetre, m².
const HEADING_WEIGHT_M2: f64 = 0.01;

/// The posture with its base upright where the contacts would have it.
///
///   yaw = atan2(Σ a × b, Σ a · b),   p = mean of (target − R(yaw) place)
///
/// over a = a patch's place relative to the mean in `posture`, b = the same of its target, both
/// horizontal, and the headings of level contacts as unit vectors of small weight.
#[allow(non_snake_case)]
pub fn place_base(
    robot: &Robot,
    posture: &Configuration,
    contacts: &[Contact],
    environment: &Environment,
) -> Configuration {
    let kinematics = Kinematics::new(robot, posture);
    let base = Isometry3::from_parts(posture.p_WB.into(), posture.R_WB).inverse();
    let pairs: Vec<(Isometry3<f64>, Isometry3<f64>, bool)> = contacts
        .iter()
        .filter_map(|contact| {
            let place = base * kinematics.X_WC(&robot.patches[contact.patch]);
            match &contact.place {
                Place::Fixed { X_WC, yaw_free, .. } => {
                    // A ball has no heading.
                    let is_ball = robot.patches[contact.patch].point_radius_m().is_some();
                    Some((place, *X_WC, *yaw_free || is_ball))
                }
                // The middle of the surface stands for a place on it.
                Place::OnSurface { surface, .. } => {
                    let surface = environment.surfaces.get(*surface)?;
                    let c = surface.polygon.centroid();
                    let middle = surface.X_WS * Translation3::new(c.x, c.y, 0.0);
                    let middle = robot.patches[contact.patch].touching(&middle);
                    Some((place, middle, true))
                }
            }
        })
        .collect();
    if pairs.is_empty() {
        return posture.clone();
    }
    let n = pairs.len() as f64;
    let mean_place = pairs
        .iter()
        .map(|p| p.0.translation.vector)
        .sum::<Vector3<f64>>()
        / n;
    let mean_target = pairs
        .iter()
        .map(|p| p.1.translation.vector)
        .sum::<Vector3<f64>>()
        / n;
    let (mut sin, mut cos) = (0.0, 0.0);
    for (place, target, yaw_free) in &pairs {
        let a = (place.translation.vector - mean_place).xy();
        let b = (target.translation.vector - mean_target).xy();
        sin += a.perp(&b);
        cos += a.dot(&b);
        let level = |x: &Isometry3<f64>| (x.rotation * Vector3::z()).z > 0.5;
        if !yaw_free && level(place) && level(target) {
            let a = (place.rotation * Vector3::x()).xy();
            let b = (target.rotation * Vector3::x()).xy();
            sin += HEADING_WEIGHT_M2 * a.perp(&b);
            cos += HEADING_WEIGHT_M2 * a.dot(&b);
        }
    }
    let yaw = if sin == 0.0 && cos == 0.0 {
        0.0
    } else {
        f64::atan2(sin, cos)
    };
    let R_WB = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    let p_WB = mean_target - R_WB * mean_place;
    posture
        .clone()
        .with_base(&Isometry3::from_parts(p_WB.into(), R_WB))
}
