//! Finds where a sensor sits on a body that leans over the ground, and which leans do not tell it.
//!
//!   cargo run -p scandent-calibration --example mount

use calibration::GroundPlane;
use calibration::camera::{CameraConfig, PlanePair, identify};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

fn main() {
    let mount = Isometry3::new(Vector3::new(0.1, 0.0, 0.3), Vector3::new(-2.2, 0.0, 0.0));
    // The ground as the feet and as the sensor have it, at a roll and a pitch, rad.
    let pair = |[roll, pitch]: [f64; 2]| {
        let lean = UnitQuaternion::from_euler_angles(roll, pitch, 0.0);
        let over_ground = Isometry3::from_parts(Vector3::new(0.0, 0.0, 0.8).into(), lean);
        let feet = GroundPlane::ground(&over_ground, 1e-6 * Matrix3::identity());
        PlanePair::new(feet, feet.seen_from(&mount))
    };
    let pitches = [[0.0, 0.1], [0.0, 0.0], [0.0, -0.1]];
    let all_ways = [[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]];
    for leans in [&pitches[..], &all_ways[..]] {
        let pairs: Vec<PlanePair> = leans.iter().copied().map(pair).collect();
        match identify(&pairs, &CameraConfig::default()) {
            Ok(found) => println!("the sensor is at {:.4}", found.X_RV.translation.vector),
            Err(error) => println!("not known: {error}"),
        }
    }
}
