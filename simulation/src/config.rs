//! Settings of the simulation, of the controllers, of the perturbations and of the criteria.
//!
//! The defaults are those with which plans of a 58 kg humanoid were executed; thresholds of the
//! criteria were set from what those executions measured.

use serde::{Deserialize, Serialize};

/// Every setting of this crate. The defaults work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// What executes a motion.
    pub controller: Controller,
    /// Time step, contact softness, joints.
    pub physics: Physics,
    /// The joint servo with feed-forward.
    pub servo: Servo,
    /// The whole-body controller.
    pub whole_body: WholeBody,
    /// When a stance holds.
    pub hold: Hold,
    /// When a motion is executed.
    pub execution: Execution,
    /// What the robust runs change.
    pub perturbation: Spread,
}

/// What executes a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Controller {
    /// Whole-body torques at every step from the measured state, and a soft joint servo.
    #[default]
    WholeBody,
    /// A stiff joint servo with the torques that the whole-body controller would give on the
    /// reference: no measured state is used.
    Servo,
}

/// What MuJoCo simulates with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Physics {
    /// Time step, s.
    pub dt_s: f64,
    /// Ratio of frictional to normal constraint impedance; high values keep contacts from
    /// creeping on slopes.
    pub impratio: f64,
    /// Time constant of contacts, s.
    pub contact_time_s: f64,
    /// Damping ratio of contacts.
    pub contact_damping: f64,
    /// Rotor inertia that every joint has besides its bodies', kg·m² (kg where prismatic).
    pub armature: f64,
    /// Viscous friction of every joint, N·m·s/rad.
    pub damping: f64,
    /// Coefficient of friction of bodies that carry no contact patch.
    pub friction_elsewhere: f64,
}

impl Default for Physics {
    fn default() -> Self {
        Self {
            dt_s: 0.001,
            impratio: 100.0,
            contact_time_s: 0.004,
            contact_damping: 1.0,
            armature: 0.05,
            damping: 0.5,
            friction_elsewhere: 0.6,
        }
    }
}

/// Gains of the joint servo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Servo {
    /// Stiffness, N·m/rad.
    pub kp: f64,
    /// Damping, N·m·s/rad.
    pub kv: f64,
}

impl Default for Servo {
    fn default() -> Self {
        Self {
            kp: 5000.0,
            kv: 100.0,
        }
    }
}

/// Gains and weights of the whole-body controller; accelerations in m/s² and rad/s².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WholeBody {
    /// Time between two solutions, s.
    pub period_s: f64,
    /// Stiffness of the joint servo beside it, N·m/rad.
    pub joint_kp: f64,
    /// Damping of the joint servo beside it, N·m·s/rad.
    pub joint_kv: f64,
    /// The centre of mass follows its reference.
    pub com: Task,
    /// The base keeps its orientation.
    pub base: Task,
    /// The patch in the air follows its reference, position and orientation.
    pub swing: Task,
    /// Weight with which patches that are in the air and on their way to nothing follow their
    /// reference, with the gains of `swing`.
    pub aloft_weight: f64,
    /// The joints follow their reference.
    pub posture: Task,
    /// Weight of contacts that do not accelerate.
    pub contact_weight: f64,
    /// Damping of contacts, 1/s.
    pub contact_damping: f64,
    /// Weight of the distance of the corner forces from those of the plan, 1/N².
    pub force_weight: f64,
    /// Part of the coefficients of friction that the controller counts on: what plans use.
    pub friction_use: f64,
    /// Distance by which the corners, at which forces act, lie inside the patch, m.
    pub corner_inset_m: f64,
    /// Speed at which a patch that should touch and does not is moved on toward its place, m/s.
    pub search_speed_m_s: f64,
    /// Normal force from which on a patch is taken to touch, N.
    pub touch_n: f64,
}

/// A second-order task: a* = a_ref + kp·e + kd·ė.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Weight of the squared deviation from a*.
    pub weight: f64,
    /// 1/s².
    pub kp: f64,
    /// 1/s.
    pub kd: f64,
}

impl Default for WholeBody {
    fn default() -> Self {
        let task = |weight, kp, kd| Task { weight, kp, kd };
        Self {
            period_s: 0.002,
            joint_kp: 200.0,
            joint_kv: 5.0,
            com: task(20.0, 60.0, 15.0),
            base: task(10.0, 80.0, 18.0),
            swing: task(200.0, 300.0, 35.0),
            aloft_weight: 20.0,
            posture: task(1.0, 60.0, 12.0),
            contact_weight: 1e4,
            contact_damping: 20.0,
            force_weight: 1e-4,
            friction_use: 0.8,
            corner_inset_m: 0.01,
            search_speed_m_s: 0.08,
            touch_n: 5.0,
        }
    }
}

/// When a stance holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hold {
    /// Time given to settle on the world as it is before anything is measured, s.
    pub settle_s: f64,
    /// Time over which the stance is held, s.
    pub duration_s: f64,
    /// Largest drift of the centre of mass, m.
    pub com_drift_m: f64,
    /// Largest drift of the centre of mass in the last second, m.
    pub com_drift_last_m: f64,
    /// Largest drift of the centre of mass where the robot is pushed, m.
    pub com_drift_pushed_m: f64,
    /// Largest slip of a contact, m.
    pub slip_m: f64,
    /// Largest tilt of the base, rad.
    pub tilt_rad: f64,
    /// Largest norm of the joint velocities at the end, rad/s.
    pub joint_speed_rad_s: f64,
    /// Least mean normal force of a loaded contact, N.
    pub contact_n: f64,
    /// Largest relative difference of the mean vertical force from the weight.
    pub weight_error: f64,
    /// Largest use of the torque limits.
    pub torque_use: f64,
    /// Deepest penetration, m.
    pub penetration_m: f64,
    /// Force of a push, N.
    pub push_n: f64,
    /// Duration of a push, s.
    pub push_s: f64,
}

impl Default for Hold {
    fn default() -> Self {
        Self {
            settle_s: 0.5,
            duration_s: 2.0,
            com_drift_m: 0.003,
            com_drift_last_m: 0.001,
            com_drift_pushed_m: 0.005,
            slip_m: 0.002,
            tilt_rad: 0.5_f64.to_radians(),
            joint_speed_rad_s: 0.02,
            contact_n: 5.0,
            weight_error: 0.01,
            torque_use: 0.8,
            penetration_m: 0.001,
            push_n: 20.0,
            push_s: 0.2,
        }
    }
}

/// When a motion is executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Execution {
    /// Time held at the end of the motion, s.
    pub rest_s: f64,
    /// Deviation of the centre of mass from which on the robot is taken to fall, m.
    pub fall_m: f64,
    /// Largest deviation of the centre of mass from its reference, m.
    pub com_error_m: f64,
    /// Largest deviation at the end, m.
    pub com_error_final_m: f64,
    /// Largest slip of a contact, m.
    pub slip_m: f64,
    /// Largest deviation of the base's orientation, rad.
    pub tilt_rad: f64,
    /// Largest deviation of a patch in the air from its reference, m.
    pub swing_error_m: f64,
    /// Largest use of the torque limits.
    pub torque_use: f64,
    /// Deepest penetration, m.
    pub penetration_m: f64,
    /// Largest delay after which a contact bears `contact_n`, s.
    pub contact_delay_s: f64,
    /// Force that a contact bears once it is made, N.
    pub contact_n: f64,
}

impl Default for Execution {
    fn default() -> Self {
        Self {
            rest_s: 1.0,
            fall_m: 0.25,
            com_error_m: 0.020,
            com_error_final_m: 0.010,
            slip_m: 0.010,
            tilt_rad: 3.0_f64.to_radians(),
            swing_error_m: 0.020,
            torque_use: 0.95,
            penetration_m: 0.001,
            contact_delay_s: 0.3,
            contact_n: 5.0,
        }
    }
}

/// What the robust runs change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spread {
    /// Factor of every coefficient of friction.
    pub friction_factor: f64,
    /// Largest relative change of the robot's mass.
    pub mass: f64,
    /// Largest displacement of a touched body along the contact's normal, m; what carries the
    /// robot at the start stays where it is.
    pub surface_m: f64,
    /// Horizontal force of a push on the base, N.
    pub push_n: f64,
    /// Duration of a push, s.
    pub push_s: f64,
    /// Time in which one push falls, s.
    pub push_every_s: f64,
    /// Part of the runs that must end with the robot standing.
    pub standing_min: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            friction_factor: 0.75,
            mass: 0.05,
            surface_m: 0.010,
            push_n: 60.0,
            push_s: 0.2,
            push_every_s: 10.0,
            standing_min: 0.9,
        }
    }
}
