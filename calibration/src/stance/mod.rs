//! The robot's pose over the ground, from the places of its feet.
//!
//! Legs know where the feet are in the robot's frame R. The ground's frame G knows that they stand
//! on z = 0 and, once a first posture has been taken, where: feet do not move while the body does.
//!
//! * [`register`]: all feet at known places, the nearest pose.
//! * [`trilateration`]: three feet at known places, as \[chai2015\] has it.
//! * [`footprint`]: the places of the feet in G, from all postures together.

mod footprint;
mod trilateration;

pub use footprint::{Footprint, footprint};
pub use trilateration::trilateration;

use nalgebra::{Isometry3, Point3};

use crate::{Error, register};

/// How a pose comes from feet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StanceMethod {
    /// The nearest pose to all feet.
    #[default]
    AllFeet,
    /// Trilateration with three feet, as in \[chai2015\].
    ThreeFeet,
}

/// The robot's pose over the ground from its feet's places in R and in G, one to one, m.
///
/// # Errors
/// [`Error::Feet`] for fewer than three feet, or feet that do not fit; [`Error::Collinear`].
pub fn stance(
    feet_R: &[Point3<f64>],
    feet_G: &[Point3<f64>],
    method: StanceMethod,
) -> Result<Isometry3<f64>, Error> {
    if feet_R.len() != feet_G.len() || feet_R.len() < 3 {
        let cause = format!(
            "{} in the robot's frame, {} on the ground; three at least are needed, and as many",
            feet_R.len(),
            feet_G.len()
        );
        return Err(Error::Feet { cause });
    }
    match method {
        StanceMethod::AllFeet => register(feet_R, feet_G, "feet"),
        StanceMethod::ThreeFeet => {
            let three = |feet: &[Point3<f64>]| spread_out(feet_G).map(|i| feet[i]);
            trilateration(&three(feet_R), &three(feet_G))
        }
    }
}

/// The three of the feet that span the greatest triangle.
fn spread_out(feet: &[Point3<f64>]) -> [usize; 3] {
    let n = feet.len();
    let area = |[i, j, k]: [usize; 3]| (feet[j] - feet[i]).cross(&(feet[k] - feet[i])).norm();
    let mut best = [0, 1, 2];
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                // A clear gain only: equal triangles keep the first, whatever the rounding.
                if area([i, j, k]) > area(best) * (1.0 + 1e-9) {
                    best = [i, j, k];
                }
            }
        }
    }
    best
}

/// Root mean square distance of the feet from where they stand, m.
pub fn foot_error_m(X_GR: &Isometry3<f64>, feet_R: &[Point3<f64>], feet_G: &[Point3<f64>]) -> f64 {
    let square = |(r, g): (&Point3<f64>, &Point3<f64>)| (X_GR * r - g).norm_squared();
    let sum: f64 = feet_R.iter().zip(feet_G).map(square).sum();
    (sum / feet_R.len().max(1) as f64).sqrt()
}
