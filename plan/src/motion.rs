//! The motion as it is written: phases, and samples of the whole body in time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Contact, Error};

/// The value of [`Motion::format`] that this version writes and reads.
pub const MOTION_FORMAT: &str = "scandent-motion/3";

/// The motion of a plan, sampled in time at equal steps, from rest to rest.
///
/// Phases abut, and begin and end on samples. A sample at the border of two phases belongs to the
/// later one. Configuration and forces are continuous over the borders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Always [`MOTION_FORMAT`].
    pub format: String,
    /// Name of the robot.
    pub robot: String,
    /// Time between two samples, s.
    pub dt_s: f64,
    /// What the motion keeps to.
    pub limits: Limits,
    /// What is done when, in the order of time.
    pub phases: Vec<Phase>,
    /// The samples, at t = 0, `dt_s`, 2 `dt_s`, … to the end of the last phase inclusive.
    pub samples: Vec<Sample>,
}

/// What a motion keeps to at every instant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest part of the joints' speed limits.
    pub joint_speed_use: f64,
    /// Largest acceleration of a joint, rad/s² (m/s² where prismatic).
    pub joint_acceleration_rad_s2: f64,
    /// Largest part of the torque limits.
    pub torque_use: f64,
    /// Largest part of the friction coefficients.
    pub friction_use: f64,
    /// Part of the margin of the centre of mass by which forces act nearer to the edges of their patches
    /// than at rest.
    pub margin_use: f64,
}

/// What a phase does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PhaseKind {
    /// Nothing moves.
    Hold,
    /// All contacts stay closed; the centre of mass moves and load goes from contact to contact.
    Shift,
    /// One patch moves through the air.
    Swing,
}

/// A part of the motion during which the set of closed contacts stays the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// What it does.
    pub kind: PhaseKind,
    /// When it begins, s; a multiple of `dt_s`.
    pub t_start_s: f64,
    /// When it ends, s; a multiple of `dt_s`.
    pub t_end_s: f64,
    /// Index of the plan's stance that the phase comes from.
    pub from_stance: usize,
    /// Index of the plan's stance that the phase leads to.
    pub to_stance: usize,
    /// The contacts that are closed during the phase, with the points at which their forces act.
    pub contacts: Vec<Contact>,
    /// The patch that the phase moves through the air.
    pub swing: Option<String>,
}

/// The whole body at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Time since the start, s.
    pub t_s: f64,
    /// Configuration `[p_WB, quat_xyzw, joints…]`, m and rad; neighbouring quaternions have a
    /// positive scalar product.
    pub q: Vec<f64>,
    /// Velocity `[v_B, ω_B, joint rates…]`, v_B that of B's origin, both in W; m/s, rad/s.
    pub v: Vec<f64>,
    /// Its derivative, m/s², rad/s².
    pub a: Vec<f64>,
    /// What the joints exert, N·m (N where prismatic): `M(q) a + h(q, v) = (0, τ) + Σ Jᵀ f`.
    pub tau: Vec<f64>,
    /// Centre of mass in W, m.
    pub com_W: [f64; 3],
    /// Force on the robot at each force point in W, N; contact by contact in the order of the
    /// phase's contacts, point by point in the order of `force_points_W`.
    pub forces_W: Vec<Vec<[f64; 3]>>,
}

impl Motion {
    /// When the motion ends, s.
    pub fn duration_s(&self) -> f64 {
        self.phases.last().map_or(0.0, |phase| phase.t_end_s)
    }

    /// Index of the phase that a time belongs to: the later one at a border, the last one after
    /// the end.
    pub fn phase_at(&self, t_s: f64) -> Option<usize> {
        // Borders are multiples of dt: half a step less than that is rounding.
        let slack = 1e-6 * self.dt_s;
        let later = self
            .phases
            .partition_point(|phase| phase.t_start_s <= t_s + slack);
        later.checked_sub(1)
    }

    /// Refuses a record that contradicts itself: times, lengths, numbers that are not finite.
    ///
    /// # Errors
    /// [`Error::Motion`] with the place and the cause.
    pub fn validate(&self) -> Result<(), Error> {
        let refuse = |cause: String| Err(Error::Motion { cause });
        if self.format != MOTION_FORMAT {
            return refuse(format!(
                "the format is {:?}, not {MOTION_FORMAT:?}",
                self.format
            ));
        }
        if !(self.dt_s > 0.0 && self.dt_s.is_finite()) {
            return refuse(format!("dt_s = {} is no time step", self.dt_s));
        }
        let slack = 1e-6 * self.dt_s;
        let mut border = 0.0;
        for (i, phase) in self.phases.iter().enumerate() {
            let steps = (phase.t_end_s / self.dt_s).round() * self.dt_s;
            if !(phase.t_end_s > phase.t_start_s
                && (phase.t_start_s - border).abs() <= slack
                && (phase.t_end_s - steps).abs() <= slack)
            {
                return refuse(format!(
                    "phase {i} from {} s to {} s does not follow on {border} s in whole steps",
                    phase.t_start_s, phase.t_end_s
                ));
            }
            border = phase.t_end_s;
        }
        let wanted = (border / self.dt_s).round() as usize + 1;
        if self.phases.is_empty() || self.samples.len() != wanted {
            return refuse(format!(
                "{} samples for {border} s of phases, {wanted} wanted",
                self.samples.len()
            ));
        }
        let length = self.samples[0].q.len();
        for (i, sample) in self.samples.iter().enumerate() {
            let t = i as f64 * self.dt_s;
            if (sample.t_s - t).abs() > slack || sample.t_s.is_nan() {
                return refuse(format!("sample {i} is at {} s, not {t} s", sample.t_s));
            }
            if sample.q.len() != length || length < 7 {
                return refuse(format!(
                    "sample {i} has {} coordinates, the first {length}",
                    sample.q.len()
                ));
            }
            if [sample.v.len() + 1, sample.a.len() + 1, sample.tau.len() + 7] != [length; 3] {
                return refuse(format!("sample {i} has not a rate for every coordinate"));
            }
            let forces = sample.forces_W.iter().flatten().flatten();
            let rates = sample.v.iter().chain(&sample.a).chain(&sample.tau);
            let mut all = sample
                .q
                .iter()
                .chain(&sample.com_W)
                .chain(rates)
                .chain(forces);
            if !all.all(|x| x.is_finite()) {
                return refuse(format!("sample {i} has a number that is not finite"));
            }
            let phase = self.phase_at(sample.t_s).map(|phase| &self.phases[phase]);
            let contacts = phase.map_or(&[][..], |phase| &phase.contacts);
            let points = contacts.iter().map(|c| c.force_points_W.len());
            if !points.eq(sample.forces_W.iter().map(Vec::len)) {
                return refuse(format!(
                    "sample {i} has not a force for every force point of its phase's contacts"
                ));
            }
        }
        Ok(())
    }
}
