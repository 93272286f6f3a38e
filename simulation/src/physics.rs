//! What the robot and its world are simulated with: time step, joints, servos, and how they differ
//! from what was planned with.

use robot_model::Body;

use crate::config::Config;

/// What MuJoCo simulates with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Time step, s.
    pub dt_s: f64,
    /// Coefficient of friction of bodies that carry no contact patch.
    pub friction_elsewhere: f64,
    /// Rotor inertia of a strong joint, besides its bodies', kg·m² (kg where prismatic); see [`Self::armature_of`].
    pub armature: f64,
    /// Viscous friction of a strong joint, N·m·s/rad; see [`Self::damping_of`].
    pub damping: f64,
}

impl From<&Config> for Physics {
    fn from(config: &Config) -> Self {
        Self {
            dt_s: config.dt_s,
            friction_elsewhere: config.friction_elsewhere,
            armature: 0.05,
            damping: 0.5,
        }
    }
}

/// The effort of a joint turns its rotor alone at this rate at least, rad/s²: motors of fingers are small.
const ROTOR_RAD_S2: f64 = 400.0;
/// Part of its effort that friction takes at most of a joint at its rated speed: no motor is rated for what it cannot
/// turn.
const FRICTION_PART: f64 = 0.25;
/// Least rotor inertia, kg·m²: of joints without effort or mass too the equations of motion have a solution.
const ARMATURE_MIN: f64 = 0.002;

impl Physics {
    /// Rotor inertia of a joint with this effort, kg·m² (kg where prismatic).
    pub fn armature_of(&self, effort: f64) -> f64 {
        (effort / ROTOR_RAD_S2).max(ARMATURE_MIN).min(self.armature)
    }

    /// Viscous friction of a body's joint, N·m·s/rad (N·s/m where prismatic).
    pub fn damping_of(&self, body: &Body) -> f64 {
        let rated = FRICTION_PART * body.effort / body.velocity;
        // Without an effort or a speed nothing is rated.
        match rated.is_finite() && rated > 0.0 {
            true => self.damping.min(rated),
            false => self.damping,
        }
    }
}

/// Gains of the joint servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Stiffness, N·m/rad.
    pub kp: f64,
    /// Damping, N·m·s/rad.
    pub kv: f64,
}

impl Servo {
    /// Holds a stance or follows a motion by itself, with torques fed forward.
    pub const STIFF: Self = Self {
        kp: 5000.0,
        kv: 100.0,
    };
    /// Stands beside the whole-body controller.
    pub const SOFT: Self = Self { kp: 200.0, kv: 5.0 };
}

/// What the simulated robot differs in from the planned one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Factor of all masses and inertias.
    pub mass: f64,
    /// Factor of all coefficients of friction.
    pub friction: f64,
}

impl Default for Scales {
    fn default() -> Self {
        Self {
            mass: 1.0,
            friction: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_leaves_every_joint_most_of_its_effort_at_its_rated_speed() {
        let physics = Physics::from(&Config::default());
        for name in scenes::robot_names() {
            let robot = scenes::robot(name).expect("it ships");
            for body in robot.joint_bodies() {
                let friction = physics.damping_of(body) * body.velocity;
                let most = FRICTION_PART * body.effort + 1e-9;
                assert!(friction <= most, "{name}: {}: {friction}", body.joint);
            }
        }
    }
}
