//! The robot's pose over the ground, from the places of its feet.
//!
//! Legs know where the feet are in the robot's frame R. The ground's frame G knows that they stand
//! on z = 0 and, once a first posture has been taken, where: feet do not move while the body does.
//!
//! * [`register`](crate::register): all feet at known places, the nearest pose.
//! * [`footprint`]: the places of the feet in G, from all postures together.

mod footprint;

pub use footprint::{Footprint, footprint};

use nalgebra::{Isometry3, Point3};

/// Root mean square distance of the feet from where they stand, m.
pub fn foot_error_m(X_GR: &Isometry3<f64>, feet_R: &[Point3<f64>], feet_G: &[Point3<f64>]) -> f64 {
    let square = |(r, g): (&Point3<f64>, &Point3<f64>)| (X_GR * r - g).norm_squared();
    let sum: f64 = feet_R.iter().zip(feet_G).map(square).sum();
    (sum / feet_R.len().max(1) as f64).sqrt()
}
