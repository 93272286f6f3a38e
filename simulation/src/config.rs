//! Settings of the simulation: the controller and what runs are disturbed by.
//!
//! The defaults are those with which plans of a 58 kg humanoid were executed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Every setting of this crate. The defaults work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What executes a motion.
    pub controller: Controller,
    /// Time step of the physics, s.
    #[schemars(range(min = 0.0001, max = 0.01))]
    pub dt_s: f64,
    /// Coefficient of friction of bodies that carry no contact patch.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub friction_elsewhere: f64,
    /// Time over which a stance is held, s.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub hold_s: f64,
    /// Force of the pushes on a held stance, N.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub hold_push_n: f64,
    /// What the robust runs change.
    pub perturbation: Spread,
}

/// What executes a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Controller {
    /// Whole-body torques at every step from the measured state, and a soft joint servo.
    #[default]
    WholeBody,
    /// A stiff joint servo with the torques that the whole-body controller would give on the
    /// reference: no measured state is used.
    Servo,
}

/// What the robust runs change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Spread {
    /// Factor of every coefficient of friction.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub friction_factor: f64,
    /// Largest relative change of the robot's mass.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub mass: f64,
    /// Largest displacement of a touched body along each axis, m, and of its contacts where it is turned as well,
    /// by 1° about each axis at most; what carries the robot at the start stays where it is.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub surface_m: f64,
    /// Horizontal force of a push on the base, N.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub push_n: f64,
    /// Time in which one push falls, s: the motion is parted into as many equal times as are nearest to that.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub push_every_s: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            controller: Controller::default(),
            dt_s: 0.001,
            friction_elsewhere: 0.6,
            hold_s: 2.0,
            hold_push_n: 20.0,
            perturbation: Spread::default(),
        }
    }
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            friction_factor: 0.75,
            mass: 0.05,
            surface_m: 0.010,
            push_n: 60.0,
            push_every_s: 10.0,
        }
    }
}
