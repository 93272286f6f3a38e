//! `scene.toml`: what to plan, from which data, with which robot.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, UnitQuaternion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::Error;

mod check;

/// A scene as it is written; paths in it are relative to the file.
///
/// The environment comes from exactly one of `scan` (one or more), `surfaces_file` and `mesh_file`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Name; the output folder is called after it.
    pub name: String,
    /// What the scene shows.
    #[serde(default)]
    pub description: String,
    /// Scans with the poses they were taken from.
    #[serde(default)]
    pub scan: Vec<ScanSource>,
    /// A surface set that was extracted before (`surfaces.json`).
    pub surfaces_file: Option<String>,
    /// A mesh of the environment in W, metres (STL, OBJ, PLY, DAE, glTF).
    pub mesh_file: Option<String>,
    /// The robot.
    pub robot: RobotSource,
    /// Where and how the robot starts; in its resting posture over the origin, its soles on z = 0,
    /// where nothing is said.
    #[serde(default)]
    pub start: Start,
    /// Where it should go.
    pub goal: Goal,
    /// A path for the base to follow; a line from start to goal where there is none.
    pub guide: Option<Guide>,
    /// Which surfaces may carry which role: one table a role, with the fields of the surface
    /// crate's role filter.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub roles: toml::Table,
    /// Coefficients of friction.
    #[serde(default)]
    pub friction: Friction,
    /// Overrides of the perception's configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub perception: toml::Table,
    /// Overrides of the settings of the ground under the feet.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub ground: toml::Table,
    /// Overrides of the surfaces' configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub surfaces: toml::Table,
    /// Overrides of how the robot is read.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub robot_model: toml::Table,
    /// Overrides of the posture generator's configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub posture: toml::Table,
    /// Overrides of the motion's configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub motion: toml::Table,
    /// Overrides of the exporters' configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub export: toml::Table,
    /// Overrides of the planner's configuration.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub planner: toml::Table,
}

/// One scan: a depth image or a point cloud, and the sensor's pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScanSource {
    /// Depth image (16-bit PNG, TIFF, npy, npz).
    pub depth: Option<String>,
    /// Point cloud (npy, npz, PCD, PLY, LAS, E57, text), or a ROS 2 bag (MCAP).
    pub cloud: Option<String>,
    /// Name of a known sensor; replaces the intrinsics below.
    pub sensor: Option<String>,
    /// Focal length along the columns, pixels.
    pub fx: Option<f64>,
    /// Focal length along the rows, pixels.
    pub fy: Option<f64>,
    /// Column of the principal point.
    pub cx: Option<f64>,
    /// Row of the principal point.
    pub cy: Option<f64>,
    /// Depth of one unit of the image, m.
    pub depth_scale_m: Option<f64>,
    /// Where the sensor stood in the frame of a cloud that was moved after the scan, m. The pose below
    /// is then that of the cloud's frame.
    pub eye_m: Option<[f64; 3]>,
    /// The topic of a bag, the scan of an E57 file (name, or number from 0), or the array of an npz, that is the scan.
    pub topic: Option<String>,
    /// Time of its message, s after the bag's first.
    pub at_s: Option<f64>,
    /// The frame of the bag's tf that is W; then, or with `level`, the pose below may be left out.
    pub frame: Option<String>,
    /// Calibration of a `vlp16` (as `calibrate lidar` writes it); the pose below is then that of the
    /// calibration's world.
    pub calibration: Option<String>,
    /// Position of the sensor's frame V (optical: x right, y down, z forward; of a `vlp16`: x forward,
    /// y left, z up) in W, m.
    pub position_m: Option<[f64; 3]>,
    /// Orientation of V in W.
    pub quat_xyzw: Option<[f64; 4]>,
    /// In the place of both: the ground that the scan shows; W's origin is on it below the sensor, x ahead. Of
    /// scans with both, the first is put so, and the others keep their places to it.
    #[serde(default)]
    pub level: bool,
    /// With `level`: which way is up in V, as an accelerometer at rest there measures it, at any length.
    pub up: Option<[f64; 3]>,
    /// In the place of both: the file of the sensor's mount on the robot, which stands as at the
    /// start (`scandent calibrate` writes such files).
    pub extrinsics: Option<String>,
}

/// The robot: `urdf = "builtin:NAME"`, or files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotSource {
    /// A path, or `builtin:NAME`.
    pub urdf: String,
    /// Postures and disabled pairs.
    pub srdf: Option<String>,
    /// Contact patches.
    pub contacts: Option<String>,
}

/// The robot before its first step: a posture with the base at a place, a posture over a place
/// (`over_m`), where the feet stand on whatever ground there is, or patches at their poses
/// (`contact`); for the last two a posture is sought.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Name of a posture in the SRDF.
    pub posture: Option<String>,
    /// Values of joints by their names, in the place of the posture's, rad (m where prismatic): as they are measured.
    #[serde(default)]
    pub joints_rad: BTreeMap<String, f64>,
    /// Position of the base in W, m.
    pub base_position_m: Option<[f64; 3]>,
    /// Orientation of the base in W: roll, pitch, yaw about fixed axes.
    #[serde(default)]
    pub base_rpy_rad: [f64; 3],
    /// In the place of both: where the base is over the ground, x and y in W, m.
    pub over_m: Option<[f64; 2]>,
    /// Its heading there, rad.
    #[serde(default)]
    pub yaw_rad: f64,
    /// In the place of all of these: over W's origin, x ahead, moved on to just before the floor that is seen there
    /// and onto its plane; so it is, too, where nothing is said and a scan is levelled.
    #[serde(default)]
    pub before_floor: bool,
    /// Patches that touch the ground in that posture.
    #[serde(default)]
    pub contacts: Vec<String>,
    /// Patches and their poses, in the place of all of the above.
    #[serde(default)]
    pub contact: Vec<StartContact>,
}

/// A patch at a pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartContact {
    /// The robot's contact patch.
    pub patch: String,
    /// Position of the patch frame C in W, m.
    pub position_m: [f64; 3],
    /// Orientation of C in W: roll, pitch, yaw about fixed axes.
    #[serde(default)]
    pub rpy_rad: [f64; 3],
}

/// What the last stance must fulfil.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// Position of the base in W: x, y or x, y, z, m.
    pub base_position_m: Option<Vec<f64>>,
    /// Largest distance from it, m.
    #[serde(default = "default_tolerance_m")]
    pub tolerance_m: f64,
    /// Heading of the base, rad.
    pub yaw_rad: Option<f64>,
    /// Contacts that it must have.
    #[serde(default)]
    pub contact: Vec<GoalContact>,
    /// Name of a posture in the SRDF: every joint that it states must be as it is there.
    pub posture: Option<String>,
    /// Values of joints by their names, in the place of the posture's, rad (m where prismatic).
    #[serde(default)]
    pub joints_rad: BTreeMap<String, f64>,
    /// Largest distance of a joint from its value, rad (m).
    #[serde(default = "default_joint_tolerance_rad")]
    pub joint_tolerance_rad: f64,
}

impl Default for Goal {
    /// Nothing that is wanted.
    fn default() -> Self {
        Self {
            base_position_m: None,
            tolerance_m: default_tolerance_m(),
            yaw_rad: None,
            contact: Vec::new(),
            posture: None,
            joints_rad: BTreeMap::new(),
            joint_tolerance_rad: default_joint_tolerance_rad(),
        }
    }
}

fn default_tolerance_m() -> f64 {
    0.10
}

fn default_joint_tolerance_rad() -> f64 {
    0.05
}

/// A wanted contact: the surface by its name, or the surface at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalContact {
    /// The robot's contact patch.
    pub patch: String,
    /// Id of the surface.
    pub surface: Option<String>,
    /// A point in W on the surface, m.
    pub point_m: Option<[f64; 3]>,
}

/// Places that the base should pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Guide {
    /// x, y, z (m) and yaw (rad) of the base in W, from the start on.
    pub key_postures: Vec<[f64; 4]>,
}

/// Coefficients of friction; a patch without a value keeps that of the contacts file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// For every patch that has none of its own here.
    pub default: Option<f64>,
    /// By the patch's name.
    #[serde(default)]
    pub patch: BTreeMap<String, f64>,
}

impl SceneFile {
    /// Reads and checks a scene.
    ///
    /// # Errors
    /// [`Error::Syntax`] with the line; [`Error::Field`] for a value that makes no sense.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let read = robot_model::toml_file::parse::<Self>(text);
        let scene = read.map_err(|mistakes| {
            Error::several(mistakes.into_iter().map(Error::Syntax).collect())
        })?;
        match scene.mistakes() {
            mistakes if mistakes.is_empty() => Ok(scene),
            mistakes => Err(Error::several(mistakes)),
        }
    }
}

impl ScanSource {
    /// Pose of the sensor's frame V in W; the identity where nothing states it.
    pub fn X_WV(&self) -> Isometry3<f64> {
        let quat_xyzw = self.quat_xyzw.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let rotation = UnitQuaternion::from_quaternion(quat_xyzw.into());
        Isometry3::from_parts(self.position_m.unwrap_or_default().into(), rotation)
    }

    /// Puts the sensor's optical frame at `X_WV`, whatever was said of it before.
    pub fn place(&mut self, X_WV: &Isometry3<f64>) {
        self.position_m = Some(X_WV.translation.vector.into());
        self.quat_xyzw = Some(X_WV.rotation.coords.into());
        self.extrinsics = None;
    }
}
