//! What postures keep to spare for the motion between them.

use posture::{Config, Constraint, Error, Outcome, Problem};

/// Part of the torques that is used of what is allowed.
const TORQUE: f64 = 0.92;
/// Kept of the joints' ranges beyond what is asked for, rad.
const JOINT_RAD: f64 = 3e-3;
/// Kept of all distances beyond what is asked for, m.
const CLEARANCE_M: f64 = 2e-3;
/// A posture that lacks more than this of what is asked for with the reserve lacks it without, as
/// [`posture::Violation::amount`].
const MADE_UP_MAX: f64 = 0.02;

/// The posture of a problem with something to spare, as far as there is one: the motion between two
/// postures strays from what both keep, and of postures on their bounds it is beyond them by a hair
/// somewhere.
///
/// Where the reserve is more than there is (a finger beside the fist is 22 mm from whatever the
/// fist touches, however it turns), the posture that comes nearest is brought inside the bounds
/// themselves; those of torques last, which pushes need.
///
/// # Errors
/// As [`posture::solve`].
pub(crate) fn solve_with_reserve(problem: &Problem, asked: &Config) -> Result<Outcome, Error> {
    let reserved = Config {
        torque_use: asked.torque_use * TORQUE,
        joint_margin_rad: asked.joint_margin_rad + JOINT_RAD,
        clearance_m: asked.clearance_m + CLEARANCE_M,
        self_clearance_m: asked.self_clearance_m + CLEARANCE_M,
        ..asked.clone()
    };
    let (violation, nearest) = match posture::solve(problem, &reserved)? {
        Outcome::Undecided {
            violation, nearest, ..
        } if violation.amount < MADE_UP_MAX => (violation, nearest),
        Outcome::Feasible(mut posture) => {
            // Ground beside a ball counts as far as what is kept from things; that is promised without the reserve.
            let stated_m = &mut posture.margins.clearance_m;
            if *stated_m == Some(reserved.clearance_m) {
                *stated_m = Some(asked.clearance_m);
            }
            return Ok(Outcome::Feasible(posture));
        }
        outcome => return Ok(outcome),
    };
    let from_there = Problem {
        guess: &nearest.q,
        ..problem.clone()
    };
    let asked = Config {
        restarts: 0,
        ..asked.clone()
    };
    // Torques are spared where it is not they that lack.
    if !matches!(violation.constraint, Constraint::Torque(_)) {
        let spared = Config {
            torque_use: reserved.torque_use,
            ..asked.clone()
        };
        let outcome = posture::solve(&from_there, &spared)?;
        if matches!(outcome, Outcome::Feasible(_)) {
            return Ok(outcome);
        }
    }
    posture::solve(&from_there, &asked)
}
