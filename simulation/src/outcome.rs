//! What a simulation showed, as it is written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::criteria::Criterion;
use crate::perturbation::Perturbation;

/// How a stance held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Held {
    /// Every criterion.
    pub criteria: Vec<Criterion>,
    /// Whether all hold.
    pub pass: bool,
    /// Displacement of the centre of mass while the robot settled on the world as it is, mm.
    pub settled_com_mm: f64,
    /// Tilt of the base by that, deg.
    pub settled_tilt_deg: f64,
    /// Mean normal force of each contact, N.
    pub normal_n: Vec<(String, f64)>,
}

/// How a reference was executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Executed {
    /// Every criterion.
    pub criteria: Vec<Criterion>,
    /// Whether all hold.
    pub pass: bool,
    /// Whether it stands at the end: it did not fall, and its last contacts bear it.
    pub stands: bool,
    /// When the robot fell, s.
    pub fell_s: Option<f64>,
    /// The first thing that went wrong, in words.
    pub cause: Option<String>,
    /// What was disturbed.
    pub perturbation: Perturbation,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// How long of it the reference waited for the robot, s: times of criteria are the reference's.
    #[serde(default)]
    pub waited_s: f64,
}
