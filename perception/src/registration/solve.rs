//! The motion that brings matched planes together.

use nalgebra::{
    Isometry3, Matrix3x6, Matrix6, Point3, SymmetricEigen, Translation3, UnitQuaternion, Vector3,
    Vector6,
};

use super::RegistrationConfig;
use super::matching::Pair;

/// Steps of Gauss and Newton.
const STEPS: usize = 6;

/// A motion and what is known of it beforehand.
pub(super) struct Pose {
    /// The motion so far.
    pub X_W: Isometry3<f64>,
    /// The point that turns are about.
    pub about_W: Point3<f64>,
    /// Covariance of (turn, shift) of the pose that was given.
    pub given: Matrix6<f64>,
}

impl Pose {
    /// The pose as it was given: a turn about the sensor moves what it saw.
    pub fn given(eye_W: &Point3<f64>, about_W: Point3<f64>, config: &RegistrationConfig) -> Self {
        let [turn, shift] = [config.direction_sigma_rad, config.position_sigma_m].map(|s| s * s);
        let own = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
        let mut moved = Matrix6::identity();
        let lever = (eye_W - about_W).cross_matrix();
        moved.fixed_view_mut::<3, 3>(3, 0).copy_from(&lever);
        Self {
            X_W: Isometry3::identity(),
            about_W,
            given: moved * own * moved.transpose(),
        }
    }

    /// The turn about the point and the shift of the motion so far.
    pub fn off(&self) -> Vector6<f64> {
        coordinates(&self.X_W, &self.about_W)
    }

    /// How (turn, shift) changes a pair's (θ_x, θ_y, z).
    pub fn jacobian(&self, pair: &Pair) -> Matrix3x6<f64> {
        let axes = pair.X_WC.rotation.to_rotation_matrix();
        let [x, y, z] = [0, 1, 2].map(|i| axes.matrix().column(i).into_owned());
        let arm = pair.X_WC.translation.vector - self.about_W.coords;
        // z · (ω × arm) = ω · (arm × z)
        let lever = arm.cross(&z);
        Matrix3x6::new(
            x.x, x.y, x.z, 0.0, 0.0, 0.0, //
            y.x, y.y, y.z, 0.0, 0.0, 0.0, //
            lever.x, lever.y, lever.z, z.x, z.y, z.z,
        )
    }
}

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
        let off = coordinates(&(X_W * pose.X_W), &pose.about_W);
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
            let jacobian = pose.jacobian(pair);
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

/// The turn about a point and the shift of a motion.
fn coordinates(X_W: &Isometry3<f64>, about_W: &Point3<f64>) -> Vector6<f64> {
    let (turn, shift) = (X_W.rotation.scaled_axis(), X_W * about_W - about_W);
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
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
