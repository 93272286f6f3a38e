//! Settings of the posture generator.

use serde::{Deserialize, Serialize};

/// Margins, weights and limits of one posture problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Part of the friction coefficient that planned forces may use, (0, 1].
    pub friction_use: f64,
    /// Part of the torque limits that holding the posture may use, (0, 1].
    pub torque_use: f64,
    /// Distance of every joint from its limits, rad (m where prismatic).
    pub joint_margin_rad: f64,
    /// Smallest distance between the robot and the environment, contacts excepted, m.
    pub clearance_m: f64,
    /// Smallest distance between two parts of the robot, m.
    pub self_clearance_m: f64,
    /// Distance by which the patches are shrunk where the forces act, m: with coplanar contacts
    /// the distance of the centre of mass from the edge of the support region. On balls alone, on
    /// faces of less than 45°, every one bears what it takes for the same distance.
    pub com_margin_m: f64,
    /// Distance of the patch (of a ball: of its whole shadow) from the edge of the effective surface
    /// polygon, m: beside the inset for what is not known of the surface's edges
    /// ([`Surface::insets_m`](surfaces::Surface::insets_m)), what a controller may miss.
    pub patch_margin_m: f64,
    /// Largest violation of a constraint that still counts as fulfilled: m for lengths, the
    /// limit's part for torques, the weight's part for forces; angles count times 0.1 m.
    pub tolerance: f64,
    /// Largest number of SQP iterations from one start.
    pub max_iterations: usize,
    /// Number of attempts from other starts where the first fails.
    pub restarts: usize,
    /// Part of the cost that may be left to gain at the end: small for the posture nearest to
    /// comfort, large for a quick one.
    pub optimality: f64,
    /// Largest change of a joint or of the base's rotation in one iteration, rad.
    pub step_max_rad: f64,
    /// Largest move of the base in one iteration, m.
    pub step_max_m: f64,
    /// Weight of the ℓ1 penalty on violated constraints (elastic mode).
    pub elastic_weight: f64,
    /// Distance within which pairs of bodies are looked at, m.
    pub prediction_m: f64,
    /// Weight of the joints' distance from the reference posture, 1/rad².
    pub weight_posture: f64,
    /// Weight of the base's tilt from upright and turn from the reference, 1/rad².
    pub weight_base: f64,
    /// Weight of the contact forces over the robot's weight.
    pub weight_forces: f64,
    /// Weight of the used part of the friction, squared, at each force point, over the normal
    /// force's: forces keep to the middle of their cones where something else can bear.
    pub weight_friction: f64,
    /// Weight of the distance of a free contact from its wanted place, 1/m².
    pub weight_placement: f64,
    /// Weight of the heading of a free contact, where one is wanted, 1/rad².
    pub weight_heading: f64,
    /// The QP engine.
    pub engine: Engine,
}

/// Which solver takes the quadratic programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Engine {
    /// Dense dual active set (Goldfarb and Idnani), warm-started: the fast one.
    #[default]
    ActiveSet,
    /// Clarabel's interior point: the robust one, and the cross-check.
    InteriorPoint,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            friction_use: 0.8,
            torque_use: 0.8,
            joint_margin_rad: 0.03,
            clearance_m: 0.020,
            self_clearance_m: 0.005,
            com_margin_m: 0.040,
            patch_margin_m: 0.010,
            tolerance: 1e-5,
            max_iterations: 60,
            restarts: 3,
            optimality: 5e-2,
            step_max_rad: 0.4,
            step_max_m: 0.3,
            elastic_weight: 100.0,
            prediction_m: 0.10,
            weight_posture: 0.1,
            weight_base: 0.5,
            weight_forces: 1e-2,
            weight_friction: 0.0,
            weight_placement: 5.0,
            weight_heading: 1.0,
            engine: Engine::ActiveSet,
        }
    }
}

impl Config {
    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`crate::Error::Config`] with the field, its value and what is allowed.
    pub fn validate(&self) -> Result<(), crate::Error> {
        let unit = |field: &'static str, value: f64| {
            if value > 0.0 && value <= 1.0 {
                Ok(())
            } else {
                Err(crate::Error::Config {
                    field,
                    value,
                    allowed: "(0, 1]",
                })
            }
        };
        unit("friction_use", self.friction_use)?;
        unit("torque_use", self.torque_use)?;
        for (field, value) in [
            ("joint_margin_rad", self.joint_margin_rad),
            ("clearance_m", self.clearance_m),
            ("self_clearance_m", self.self_clearance_m),
            ("com_margin_m", self.com_margin_m),
            ("patch_margin_m", self.patch_margin_m),
            ("weight_posture", self.weight_posture),
            ("weight_base", self.weight_base),
            ("weight_friction", self.weight_friction),
            ("weight_placement", self.weight_placement),
            ("weight_heading", self.weight_heading),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed: "≥ 0",
                });
            }
        }
        for (field, value) in [
            ("tolerance", self.tolerance),
            ("optimality", self.optimality),
            ("step_max_rad", self.step_max_rad),
            ("step_max_m", self.step_max_m),
            ("elastic_weight", self.elastic_weight),
            ("prediction_m", self.prediction_m),
            ("weight_forces", self.weight_forces),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed: "> 0",
                });
            }
        }
        Ok(())
    }
}
