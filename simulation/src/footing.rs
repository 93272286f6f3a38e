//! The reference of legs that stand on balls, put on the feet where they are.
//!
//! A plan keeps a ball's centre in place while its leg turns; the ball rolls instead, by its radius
//! times the angle. Where the posture task drew its joints to the plan, they would draw the base along.
//! So the joints of a leg that stands follow from the planned base and the foot as it is:
//!
//!   p(q_B*, q_leg) = p        one damped Gauss–Newton step from the plan's joints at every instant
//!
//! Once the foot is in the air, the correction fades.

use nalgebra::DVector;
use robot_model::{Configuration, Kinematics, Robot};

use crate::reference::ReferenceState;

/// Time in which the correction of a leg in the air falls to a third, s.
const FADE_S: f64 = 0.3;
/// Damping of the step, m/rad: far below a leg's length, so that only stretched legs feel it.
const DAMPING: f64 = 0.02;

/// The corrections of the joints, with their memory.
pub(crate) struct Footing<'a> {
    robot: &'a Robot,
    planned: Kinematics,
    actual: Kinematics,
    correction: DVector<f64>,
}

impl<'a> Footing<'a> {
    /// No correction yet.
    pub fn new(robot: &'a Robot) -> Self {
        let start = robot.neutral();
        Self {
            robot,
            planned: Kinematics::new(robot, &start),
            actual: Kinematics::new(robot, &start),
            correction: DVector::zeros(robot.nj()),
        }
    }

    /// What is wanted, with the legs that stand on balls put on them; `dt_s` after the last time.
    pub fn followed(
        &mut self,
        state: &Configuration,
        wanted: &ReferenceState,
        touching: &[bool],
        dt_s: f64,
    ) -> ReferenceState {
        let robot = self.robot;
        let mut followed = wanted.clone();
        if robot.patches.iter().all(|p| p.point_radius_m().is_none()) {
            return followed;
        }
        self.planned.update(robot, &wanted.configuration);
        self.actual.update(robot, state);
        self.correction *= (-dt_s / FADE_S).exp();
        for contact in &wanted.contacts {
            let patch = &robot.patches[contact.patch];
            if patch.point_radius_m().is_none() || !touching[contact.patch] {
                continue;
            }
            let p = |k: &Kinematics| k.X_WC(patch).translation.vector;
            let off = p(&self.actual) - p(&self.planned);
            let at = p(&self.planned);
            let step = self
                .planned
                .point_step(robot, patch.body, &at, &off, DAMPING);
            let Some(step) = step else { continue };
            for (j, correction) in self.correction.iter_mut().enumerate() {
                if robot.supports(j + 1, patch.body) {
                    *correction = step[j];
                }
            }
        }
        followed.configuration.joints += &self.correction;
        followed
    }
}
