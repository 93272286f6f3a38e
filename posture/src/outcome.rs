//! What comes back: a posture, or the reason why not.

use nalgebra::{Isometry3, Vector3};
use plan::Margins;
use robot_model::Configuration;

use crate::config::Upright;
use crate::problem::Problem;
pub use crate::rows::Constraint;

/// The end of a posture problem.
#[derive(Clone, Debug)]
#[must_use]
pub enum Outcome {
    /// A posture that fulfils every constraint to the stated tolerance, as evaluated at the end.
    Feasible(Box<Posture>),
    /// It is proved that no posture exists: the constraint that none fulfils.
    Infeasible(Violation),
    /// No posture was found, and none was excluded.
    Undecided {
        /// The constraint that is violated most where it stopped.
        violation: Violation,
        /// Where it stopped: no posture, but the nearest to one that was seen.
        nearest: Box<Posture>,
    },
}

impl Outcome {
    /// The posture, where there is one.
    pub fn posture(&self) -> Option<&Posture> {
        match self {
            Outcome::Feasible(posture) => Some(posture),
            _ => None,
        }
    }

    /// Where the search came nearest to a posture, where it found none.
    pub fn nearest(&self) -> Option<&Posture> {
        match self {
            Outcome::Undecided { nearest, .. } => Some(nearest),
            _ => None,
        }
    }

    /// The violated constraint, where there is no posture.
    pub fn violation(&self) -> Option<&Violation> {
        match self {
            Outcome::Feasible(_) => None,
            Outcome::Infeasible(violation) | Outcome::Undecided { violation, .. } => {
                Some(violation)
            }
        }
    }
}

/// A whole-body posture with the forces that hold it.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// Base pose and joints.
    pub q: Configuration,
    /// One entry a contact of the problem.
    pub contacts: Vec<ContactState>,
    /// Centre of mass in W, m.
    pub com_W: Vector3<f64>,
    /// How far the base was to tilt at most, where there was a bound.
    pub upright: Option<Upright>,
    /// Holding torque of every joint, in the order of `q`, N·m (N where prismatic).
    pub torques: Vec<f64>,
    /// Distance from every limit.
    pub margins: Margins,
    /// Value of the cost.
    pub cost: f64,
    /// SQP iterations over all starts.
    pub iterations: usize,
}

/// Where a contact ended up and what it carries.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactState {
    /// Pose of the patch frame in W. Of a point patch: the ball's centre with the contact's axes, z
    /// being the touched surface's normal.
    pub X_WC: Isometry3<f64>,
    /// Vertices of the patch in W, m; of a point patch the touched point.
    pub vertices_W: Vec<Vector3<f64>>,
    /// Points where the forces act, in W, m.
    pub force_points_W: Vec<Vector3<f64>>,
    /// Force on the robot at each of them, in W, N; zero where the contact is not loaded.
    pub forces_W: Vec<Vector3<f64>>,
}

/// A constraint and by how much it is violated.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The constraint.
    pub constraint: Constraint,
    /// By how much, scaled: m for lengths (angles times 0.1 m), the limit's part for torques,
    /// the weight's part for forces.
    pub amount: f64,
}

impl Violation {
    /// The violation in words: which constraint of which contact, joint or body, by how much.
    pub fn describe(&self, problem: &Problem) -> String {
        let mm = 1e3 * self.amount;
        let percent = 100.0 * self.amount;
        let joint = |b: usize| problem.robot.bodies[b].joint.as_str();
        let contact = |i: usize| problem.contacts[i].describe(problem.robot, problem.environment);
        match &self.constraint {
            Constraint::Closure(i) => format!("{} is out of reach by {mm:.1} mm", contact(*i)),
            Constraint::Inclusion(i) => {
                format!("{} sticks out of the face by {mm:.1} mm", contact(*i))
            }
            Constraint::Equilibrium => {
                format!("no equilibrium: {percent:.1} % of the weight stays unbalanced")
            }
            Constraint::Balance => {
                format!("out of balance: the CoM is {mm:.1} mm outside what the contacts support")
            }
            Constraint::Friction(i) => {
                let over = format!("{percent:.1} % of the weight over the friction");
                format!("{} slips: {over}", contact(*i))
            }
            Constraint::Torque(b) => {
                format!("torque of {} over its limit by {percent:.1} %", joint(*b))
            }
            Constraint::JointLimit(b) => {
                let degrees = self.amount.to_degrees();
                let what = match problem.wanted(*b) {
                    Some(_) => "off the goal's posture",
                    None => "beyond its limit",
                };
                format!("{} {what} by {degrees:.2}°", joint(*b))
            }
            Constraint::SelfClearance(a, b) => {
                let mut at_rest = problem.robot.meeting_at_rest.iter();
                let hint = match at_rest.any(|pair| pair.is_of(a, b)) {
                    true => " (at rest, too: robot_model.disable_colliding_at_rest excepts them)",
                    false => "",
                };
                format!("{a} is too near to {b} by {mm:.1} mm{hint}")
            }
            Constraint::Clearance(a, b) => format!("{a} is too near to {b} by {mm:.1} mm"),
            Constraint::BaseGoal => format!("the base misses the goal by {mm:.1} mm"),
            Constraint::BaseTilt => "the base would tilt too far".to_owned(),
        }
    }
}
