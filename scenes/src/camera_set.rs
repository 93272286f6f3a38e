//! A simulated set to find a sensor's mount from: joint readings and frames of a robot that stands
//! on flat ground in many postures.

use std::fmt::Write;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot_model::kinematics::{PointTarget, reach};
use robot_model::{Configuration, ContactPatch, Kinematics, Robot};

use crate::Error;
use crate::simulator::rng::Stream;

/// How near the feet must come to where they stand, m.
const REACHED_M: f64 = 1e-9;
/// Stream of the errors of the robot's poses; the sensor's begin at 0.
const POSE_STREAM: u64 = 100;

/// How far the body is from where its joints say: manufacture, backlash, bending; nowhere by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseNoise {
    /// Standard deviation of the tilt about each level axis, rad.
    pub tilt_sigma_rad: f64,
    /// Standard deviation of the height, m.
    pub height_sigma_m: f64,
}

impl PoseNoise {
    /// What the residuals of \[chai2015\] match: 0.17° about each axis, 1 mm.
    pub fn published() -> Self {
        Self {
            tilt_sigma_rad: 0.17_f64.to_radians(),
            height_sigma_m: 0.001,
        }
    }

    /// Where the body really is when its joints say `X_GR`; `pose` counts the draws of `seed`.
    pub fn disturb(&self, X_GR: &Isometry3<f64>, seed: u64, pose: u64) -> Isometry3<f64> {
        let draw = Stream::new(seed, POSE_STREAM);
        let normal = |k: u64| draw.normal(3 * pose + k);
        let tilt = Vector3::new(normal(0), normal(1), 0.0) * self.tilt_sigma_rad;
        let turn = UnitQuaternion::from_scaled_axis(tilt);
        let mut p_GR = X_GR.translation.vector;
        p_GR.z += self.height_sigma_m * normal(2);
        Isometry3::from_parts(p_GR.into(), turn * X_GR.rotation)
    }
}

/// The mount of \[chai2015\] Eq. 32, as X_RV: optical frame V in the robot's body R.
pub fn published_extrinsics() -> Isometry3<f64> {
    let [alpha, beta, gamma] = [-0.4398_f64, -37.4072, -3.0471].map(f64::to_radians);
    // The paper's axes turn as in `stances`; V's optical axes are x right, y down, z forward.
    let ahead = UnitQuaternion::from_euler_angles(gamma, -beta, alpha);
    let optical =
        UnitQuaternion::from_basis_unchecked(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    Isometry3::from_parts(
        Vector3::new(0.527_888_5, 0.033_400_3, 0.364_800_7).into(),
        ahead * optical,
    )
}

/// The joint readings of a robot that stands at `X_GR` with its feet where they are in the posture
/// `standing` over the origin.
///
/// # Errors
/// [`Error::Field`] with the pose that the legs do not reach; a robot without that posture.
pub fn readings(
    robot: &Robot,
    standing: &str,
    X_GR: &Isometry3<f64>,
) -> Result<Configuration, Error> {
    let posture = robot
        .posture(standing)
        .map_err(|error| Error::field("standing", error.to_string()))?;
    let kinematics = Kinematics::new(robot, &posture);
    let feet = || robot.patches.iter().filter(|patch| patch.has_role("foot"));
    // The ground is under the lowest point of the feet.
    let bottom = |patch: &ContactPatch| {
        kinematics.X_WC(patch).translation.z - patch.point_radius_m().unwrap_or(0.0)
    };
    let lowest = feet().map(bottom).fold(f64::INFINITY, f64::min);
    let target = |patch: &ContactPatch| PointTarget {
        body: patch.body,
        p_B: patch.X_BC.translation.vector,
        p_W: kinematics.X_WC(patch).translation.vector - Vector3::z() * lowest,
    };
    let targets: Vec<PointTarget> = feet().map(target).collect();
    reach(robot, &posture.with_base(X_GR), &targets, REACHED_M).ok_or_else(|| {
        let (name, height) = (&robot.name, X_GR.translation.z);
        let (roll, pitch, _) = X_GR.rotation.euler_angles();
        let (roll, pitch) = (roll.to_degrees(), pitch.to_degrees());
        let reason = format!(
            "{name} does not reach its footholds with the body {height:.3} m high, rolled by \
             {roll:.1}° and pitched by {pitch:.1}°"
        );
        Error::field("stance", reason)
    })
}

/// The table of stances with the joint readings of `configurations`: a column a joint, and the
/// frames' names where there are any.
pub fn table(robot: &Robot, configurations: &[Configuration], frames: &[String]) -> String {
    let mut text = String::new();
    let names: Vec<&str> = robot.joint_names().collect();
    if !frames.is_empty() {
        text.push_str("frame,");
    }
    text.push_str(&names.join(","));
    text.push('\n');
    for (i, configuration) in configurations.iter().enumerate() {
        if let Some(frame) = frames.get(i) {
            let _ = write!(text, "{frame},");
        }
        let values: Vec<String> = configuration
            .joints
            .iter()
            .map(|value| format!("{value:.9}"))
            .collect();
        text.push_str(&values.join(","));
        text.push('\n');
    }
    text
}
