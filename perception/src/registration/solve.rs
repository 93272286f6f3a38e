//! The motion that brings matched planes together.

use nalgebra::{
    Isometry3, Matrix6, Point3, SymmetricEigen, Translation3, UnitQuaternion, Vector3, Vector6,
};

use super::RegistrationConfig;
use super::matching::Pair;
use super::pose::Pose;

/// Steps of Gauss and Newton.
const STEPS: usize = 6;

pub(super) struct Solved {
    pub X_W: Isometry3<f64>,
    pub covariance: Matrix6<f64>,
    pub misfit: f64,
}

/// The motion after `pose` of which planes and the pose that was given are the most likely.
///
/// `None` where numbers are beyond reckoning.
pub(super) fn solve(pairs: &[Pair], pose: &Pose) -> Option<Solved> {
    let mut X_W = Isometry3::identity();
    let prior = pose.given.try_inverse()?;
    for step in 0..=STEPS {
        let off = pose.coordinates(&(X_W * pose.X_W));
        let mut information = prior;
        let mut gradient = prior * off;
        let mut square = 0.0;
        for pair in pairs {
            let Some((d, s)) = pair.difference(&X_W) else {
                continue;
            };
            let Some(weight) = s.try_inverse() else {
                continue;
            };
            let jacobian = pose.jacobian(&pair.X_WC);
            information += jacobian.transpose() * weight * jacobian;
            gradient += jacobian.transpose() * weight * d;
            square += d.dot(&(weight * d));
        }
        let covariance = information.try_inverse()?;
        if step == STEPS {
            let freedom = (3 * pairs.len()).saturating_sub(6).max(1) as f64;
            return Some(Solved {
                X_W,
                covariance,
                misfit: square / freedom,
            });
        }
        X_W = motion(&-(covariance * gradient), &pose.about_W) * X_W;
    }
    None
}

/// Root mean square distance between the planes of pairs after a motion, m.
pub(super) fn offset_rms_m(pairs: &[Pair], moved: &Isometry3<f64>) -> f64 {
    let offsets = pairs.iter().filter_map(|pair| pair.difference(moved));
    let square: f64 = offsets.map(|(d, _)| d.z * d.z).sum();
    (square / pairs.len().max(1) as f64).sqrt()
}

/// The motion of a turn about a point and a shift.
fn motion(change: &Vector6<f64>, about_W: &Point3<f64>) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(change.fixed_rows::<3>(0).into_owned());
    let shift = change.fixed_rows::<3>(3).into_owned();
    let place = about_W.coords + shift - turn * about_W.coords;
    Isometry3::from_parts(Translation3::from(place), turn)
}

/// What planes leave open, in words: directions of which hardly more is known than of a pose that is given.
pub(super) fn open(covariance: &Matrix6<f64>, config: &RegistrationConfig) -> Vec<String> {
    let mut open = Vec::new();
    for (what, at, sigma) in [
        ("turn about", 0, config.direction_sigma_rad),
        ("shift along", 3, config.position_sigma_m),
    ] {
        let block = covariance.fixed_view::<3, 3>(at, at).into_owned();
        let eigen = SymmetricEigen::new(block);
        for (axis, variance) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
            if *variance > (0.5 * sigma).powi(2) {
                open.push(format!("the {what} {}", named(&axis.into_owned())));
            }
        }
    }
    open
}

/// A direction in words: an axis where it is one, else its coordinates, the largest positive.
fn named(direction: &Vector3<f64>) -> String {
    let main = direction.iamax();
    if direction[main].abs() > 0.99 {
        return ["x", "y", "z"][main].to_owned();
    }
    let d = direction * direction[main].signum();
    format!("({:.2}, {:.2}, {:.2})", d.x, d.y, d.z)
}
