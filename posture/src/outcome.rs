//! What comes back: a posture, or the reason why not.

use nalgebra::{Isometry3, Vector3};
use robot_model::Configuration;

use crate::problem::Problem;
pub use crate::rows::Constraint;

/// The end of a posture problem.
#[derive(Clone, Debug)]
#[must_use]
pub enum Outcome {
    /// A posture that fulfils every constraint to the stated tolerance, as evaluated at the end.
    Feasible(Box<Posture>),
    /// No step makes the violation smaller: the constraint that stays violated most.
    Infeasible(Violation),
    /// The solver ran out of progress before it could tell.
    Undecided {
        /// What the solver said.
        status: String,
        /// The constraint that is violated most where it stopped.
        violation: Violation,
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
#[allow(non_snake_case)]
pub struct Posture {
    /// Base pose and joints.
    pub q: Configuration,
    /// One entry a contact of the problem.
    pub contacts: Vec<ContactState>,
    /// Centre of mass in W, m.
    pub com_W: Vector3<f64>,
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
#[allow(non_snake_case)]
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

/// How far a posture is from each limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Largest distance of a contact from its place, m (angles times 0.1 m).
    pub closure_m: f64,
    /// Smallest distance of a patch vertex from the edge of its effective polygon, m.
    pub inclusion_m: Option<f64>,
    /// Largest residual of force over the weight, and of moment over the weight, m.
    pub equilibrium: f64,
    /// Largest used part of the friction coefficient (cone).
    pub friction_use: f64,
    /// Largest used part of the torque limits.
    pub torque_use: f64,
    /// Smallest distance of a joint from its limits, rad (m where prismatic).
    pub joint_rad: f64,
    /// Smallest distance to the environment, contacts excepted, m; `None` beyond prediction.
    pub clearance_m: Option<f64>,
    /// Smallest distance between parts of the robot, m; `None` beyond prediction.
    pub self_clearance_m: Option<f64>,
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
        let contact = |i: usize| {
            let c = &problem.contacts[i];
            let patch = &problem.robot.patches[c.patch].name;
            match c.place.surface() {
                Some(s) => format!("{patch} on {}", problem.environment.surfaces[s].id),
                None => patch.clone(),
            }
        };
        match &self.constraint {
            Constraint::Closure(i) => format!("{} is out of reach by {mm:.1} mm", contact(*i)),
            Constraint::Inclusion(i) => {
                format!("{} sticks out of the surface by {mm:.1} mm", contact(*i))
            }
            Constraint::Equilibrium => {
                format!("no equilibrium: {percent:.1} % of the weight stays unbalanced")
            }
            Constraint::Balance => {
                format!("out of balance: the CoM is {mm:.1} mm outside what the contacts support")
            }
            Constraint::Friction(i) => {
                format!(
                    "{} slips: {percent:.1} % of the weight over the friction",
                    contact(*i)
                )
            }
            Constraint::Torque(b) => {
                let body = &problem.robot.bodies[*b];
                format!("torque of {} over its limit by {percent:.1} %", body.joint)
            }
            Constraint::JointLimit(b) => {
                let body = &problem.robot.bodies[*b];
                format!(
                    "{} beyond its limit by {:.2}°",
                    body.joint,
                    self.amount.to_degrees()
                )
            }
            Constraint::SelfClearance(a, b) => {
                format!("{a} is too near to {b} by {mm:.1} mm")
            }
            Constraint::Clearance(a, b) => {
                format!("{a} is too near to {b} by {mm:.1} mm")
            }
            Constraint::BaseGoal => format!("the base misses the goal by {mm:.1} mm"),
        }
    }
}
