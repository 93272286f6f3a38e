//! One posture problem: a contact set in an environment, with a reference and a guess.

use robot_model::{Configuration, Robot};

use crate::Error;
use crate::contact::Contact;
use crate::environment::Environment;

/// Where the base must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BaseGoal {
    /// Position in W, m; a coordinate without a value is free.
    pub position_m: [Option<f64>; 3],
    /// Largest distance from it, over the coordinates that have a value, m.
    pub tolerance_m: f64,
    /// Heading, rad.
    pub yaw_rad: Option<f64>,
    /// Largest distance from that heading, rad.
    pub yaw_tolerance_rad: f64,
}

/// Where joints must be, as in a posture that is wanted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointGoal {
    /// Value of every joint in the order of q, rad (m where prismatic); one without a value is free.
    pub wanted: Vec<Option<f64>>,
    /// Largest distance of each from its value, rad (m).
    pub tolerance_rad: f64,
}

/// A contact set for which a posture is wanted.
#[derive(Clone)]
pub struct Problem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// Where the base must be, if it matters.
    pub base_goal: Option<BaseGoal>,
    /// Where joints must be, if it matters.
    pub joint_goal: Option<&'a JointGoal>,
    /// The posture to stay near to where nothing else matters, heading included.
    pub reference: &'a Configuration,
    /// Where the search for the posture starts.
    pub guess: &'a Configuration,
}

impl<'a> Problem<'a> {
    /// A contact set in an environment, the base anywhere, near a configuration.
    pub fn new(
        robot: &'a Robot,
        environment: &'a Environment,
        contacts: Vec<Contact>,
        near: &'a Configuration,
    ) -> Self {
        Self {
            robot,
            environment,
            contacts,
            base_goal: None,
            joint_goal: None,
            reference: near,
            guess: near,
        }
    }
}

impl Problem<'_> {
    /// About which value the joint of body `i` must be, and how near to it.
    pub(crate) fn wanted(&self, i: usize) -> Option<(f64, f64)> {
        let goal = self.joint_goal?;
        let wanted = goal.wanted.get(i.checked_sub(1)?)?;
        wanted.map(|wanted| (wanted, goal.tolerance_rad))
    }

    /// Refuses what cannot be posed.
    ///
    /// # Errors
    /// [`Error`] naming the contact and the cause.
    pub fn validate(&self) -> Result<(), Error> {
        let refuse = |what: String, value: f64| Err(Error::Value { what, value });
        for (i, contact) in self.contacts.iter().enumerate() {
            if !(contact.friction > 0.0 && contact.friction.is_finite()) {
                return refuse(format!("friction of contact {i}"), contact.friction);
            }
            let position = &contact.X_WC.translation.vector;
            if let Some(&value) = position.iter().find(|x| !x.is_finite()) {
                return refuse(format!("position of contact {i}"), value);
            }
        }
        if !self.contacts.iter().any(|c| c.loaded) {
            return Err(Error::Unsupported);
        }
        Ok(())
    }
}
