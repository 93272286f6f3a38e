//! Which posture to add: the one that reduces the covariance of the mount most.

use nalgebra::{Isometry3, Matrix6};

use super::PlanePair;
use super::refine::whitening;
use super::residual::Residual;
use crate::GroundPlane;

/// Standard deviation that the mount is known to before any pose: 1 rad, 1 m.
///
/// It makes poses comparable that do not yet determine the mount.
const PRIOR_SIGMA: f64 = 1.0;

/// Distance from the sensor at which an error of the mount counts, m.
pub const REACH_M: f64 = 2.0;

/// A posture that could be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Pose of the robot over the ground.
    pub X_GR: Isometry3<f64>,
    /// The ground as the robot would know it.
    pub robot: GroundPlane,
    /// The ground as the sensor would see it, with the covariance to expect.
    pub sensor: GroundPlane,
}

/// The posture to add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextPose {
    /// Index among the candidates.
    pub candidate: usize,
    /// Root mean square error of a point seen at the reach, before and after, m.
    pub error_m: [f64; 2],
}

/// What the poses so far tell of the mount: Σ Jᵀ Σᵢ⁻¹ J and the prior.
pub fn information(pairs: &[PlanePair], X_RV: &Isometry3<f64>) -> Matrix6<f64> {
    let prior = Matrix6::identity() / (PRIOR_SIGMA * PRIOR_SIGMA);
    let each = pairs.iter().map(|pair| information_of(pair, X_RV));
    each.fold(prior, |sum, one| sum + one)
}

fn information_of(pair: &PlanePair, X_RV: &Isometry3<f64>) -> Matrix6<f64> {
    let residual = Residual::of(pair, X_RV);
    let J = whitening(&residual.covariance) * residual.jacobian;
    J.transpose() * J
}

/// Mean square displacement of a point at distance L = [`REACH_M`] from the sensor, in a direction at random:
///
///   tr Σ_pp + ⅔ L² tr Σ_θθ,   m²
fn criterion(information: &Matrix6<f64>) -> f64 {
    let Some(covariance) = information.try_inverse() else {
        return f64::INFINITY;
    };
    let trace = |first: usize| -> f64 { (first..first + 3).map(|k| covariance[(k, k)]).sum() };
    trace(3) + 2.0 / 3.0 * REACH_M * REACH_M * trace(0)
}

/// The candidate after which a point seen at [`REACH_M`] is known best; `None` without
/// candidates.
///
/// Source: \[pukelsheim2006\], the A-criterion.
pub fn next_pose(
    pairs: &[PlanePair],
    X_RV: &Isometry3<f64>,
    candidates: &[Candidate],
) -> Option<NextPose> {
    let known = information(pairs, X_RV);
    let after = |candidate: &Candidate| {
        let pair = PlanePair::new(candidate.robot, candidate.sensor);
        criterion(&(known + information_of(&pair, X_RV)))
    };
    let before = criterion(&known);
    let errors = candidates.iter().map(after).enumerate();
    let (candidate, after) = errors.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(NextPose {
        candidate,
        error_m: [before.sqrt(), after.sqrt()],
    })
}

#[cfg(test)]
mod tests {
    use super::super::residual::tests::{mount, stance};
    use super::*;
    use nalgebra::Matrix3;

    fn pair(roll_deg: f64, pitch_deg: f64) -> (Isometry3<f64>, PlanePair) {
        let X_GR = stance(roll_deg.to_radians(), pitch_deg.to_radians(), 0.68);
        let robot = GroundPlane::ground(&X_GR, Matrix3::identity() * 9e-6);
        let sensor = GroundPlane {
            covariance: Matrix3::identity() * 1e-7,
            ..robot.seen_from(&mount())
        };
        (X_GR, PlanePair::new(robot, sensor))
    }

    #[test]
    fn after_pitching_the_next_pose_rolls() {
        let known: Vec<PlanePair> = (-3..=3).map(|k| pair(0.0, 6.0 * f64::from(k)).1).collect();
        let tilts = [(0.0, 20.0), (0.0, -20.0), (5.0, 0.0), (20.0, 0.0)];
        let candidates = tilts.map(|(roll, pitch)| {
            let (X_GR, pair) = self::pair(roll, pitch);
            Candidate {
                X_GR,
                robot: pair.robot,
                sensor: pair.sensor,
            }
        });
        let next = next_pose(&known, &mount(), &candidates).unwrap();
        assert_eq!(next.candidate, 3);
        // Unknown along y to a metre before, to centimetres after.
        assert!(next.error_m[0] > 0.9 && next.error_m[1] < 0.1, "{next:?}");
        assert_eq!(next_pose(&known, &mount(), &[]), None);
    }
}
