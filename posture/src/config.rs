//! Settings of the posture generator.

use nalgebra::{UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Margins that a posture keeps, and what it prefers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Part of the friction coefficient that planned forces may use.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub friction_use: f64,
    /// Part of the torque limits that holding the posture may use.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub torque_use: f64,
    /// Distance of every joint from its limits, rad (m where prismatic).
    #[schemars(range(min = 0.0, max = 0.5))]
    pub joint_margin_rad: f64,
    /// Smallest distance between the robot and the environment, contacts excepted, m. Links within two joints of a sole or
    /// a palm keep `self_clearance_m` from the ground that it touches.
    #[schemars(range(min = 0.001, max = 0.5))]
    pub clearance_m: f64,
    /// Smallest distance between two parts of the robot, m.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub self_clearance_m: f64,
    /// Distance by which the patches are shrunk where the forces act, m: with coplanar contacts
    /// the distance of the centre of mass from the edge of the support region. On balls alone, on
    /// faces of less than 45°, every one bears what it takes for the same distance. Of a narrow patch 10 mm of the
    /// half width, or 40 % of it where that is less, are left.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub com_margin_m: f64,
    /// Distance of the patch (of a ball: of its whole shadow) from the edge of the inset face, m:
    /// what a controller may miss, beside the inset for what is not known of the face's edges.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub patch_margin_m: f64,
    /// Standard deviations by which faces are taken back at edges that are not known exactly.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub edge_sigmas: f64,
    /// Number of attempts from other seeds where the first fails.
    #[schemars(range(min = 0, max = 100))]
    pub restarts: usize,
    /// Weight of the base's tilt from upright and turn from the reference, 1/rad²; 50 holds the
    /// body level rather than the legs in their middle.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub weight_base: f64,
    /// Weight of the used part of the friction, squared, at each force point, over the normal
    /// force's: forces keep to the middle of their cones where something else can bear.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub weight_friction: f64,
    /// How the problem is solved: chosen by the calling code, not a setting.
    #[serde(skip)]
    pub solver: Solver,
}

/// How a posture problem is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Which solver takes the quadratic programs.
    pub engine: Engine,
    /// Part of the cost that may be left to gain at the end: small for the posture nearest to the
    /// reference, large for a quick one.
    pub optimality: f64,
    /// Part of the largest step that an iteration may take; next to nothing leaves the
    /// configuration at the guess and seeks the forces alone.
    pub step_scale: f64,
    /// How far the base may tilt, where there is a bound.
    pub upright: Option<Upright>,
    /// Whether, where two attempts failed, proofs are sought and more attempts made, which cost several times as much.
    /// Such a proof rests on all margins: it says nothing of smaller ones.
    pub thorough: bool,
}

/// The cone about a direction that the base's z axis keeps inside of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upright {
    /// The direction, in W, of length 1.
    pub z_W: Vector3<f64>,
    /// Largest angle between the two, rad; less than π/2.
    pub tilt_max_rad: f64,
}

impl Upright {
    /// The angle of a base from the direction, rad.
    pub fn tilt_rad(&self, R_WB: &UnitQuaternion<f64>) -> f64 {
        self.z_W.angle(&(R_WB * Vector3::z()))
    }
}

/// Which solver takes the quadratic programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
            edge_sigmas: 2.0,
            restarts: 3,
            weight_base: 0.5,
            weight_friction: 0.0,
            solver: Solver::default(),
        }
    }
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            engine: Engine::ActiveSet,
            optimality: 5e-2,
            step_scale: 1.0,
            upright: None,
            thorough: false,
        }
    }
}

impl Config {
    /// The least distance of what carries a sole or a palm from what that touches, m.
    pub fn carrying_clearance_m(&self) -> f64 {
        self.self_clearance_m.min(self.clearance_m)
    }

    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`crate::Error::Config`] with the field, its value and what is allowed.
    pub fn validate(&self) -> Result<(), crate::Error> {
        let part: fn(f64) -> bool = |value| value > 0.0 && value <= 1.0;
        let length = |value: f64| value >= 0.0 && value.is_finite();
        for (field, value, fine, allowed) in [
            ("friction_use", self.friction_use, part, "(0, 1]"),
            ("torque_use", self.torque_use, part, "(0, 1]"),
            ("joint_margin_rad", self.joint_margin_rad, length, "≥ 0"),
            ("clearance_m", self.clearance_m, length, "≥ 0"),
            ("self_clearance_m", self.self_clearance_m, length, "≥ 0"),
            ("com_margin_m", self.com_margin_m, length, "≥ 0"),
            ("patch_margin_m", self.patch_margin_m, length, "≥ 0"),
            ("edge_sigmas", self.edge_sigmas, length, "≥ 0"),
            ("weight_base", self.weight_base, length, "≥ 0"),
            ("weight_friction", self.weight_friction, length, "≥ 0"),
        ] {
            if !fine(value) {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed,
                });
            }
        }
        Ok(())
    }
}

impl From<&Config> for plan::RequiredMargins {
    /// The margins that the posture generator keeps.
    fn from(config: &Config) -> Self {
        Self {
            friction_use: config.friction_use,
            torque_use: config.torque_use,
            joint_rad: config.joint_margin_rad,
            clearance_m: config.clearance_m,
            self_clearance_m: config.self_clearance_m,
            com_m: config.com_margin_m,
            edge_sigmas: config.edge_sigmas,
        }
    }
}
