//! The controller's configuration as types: keys and their order as in its own samples.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use serde_saphyr::FlowSeq;

/// The document.
#[derive(Serialize)]
pub(super) struct Document {
    pub states: States,
    #[serde(rename = "LimbTaskList")]
    pub limb_tasks: Vec<LimbTask>,
    #[serde(rename = "LimbManagerSet")]
    pub limb_managers: LimbManagers,
    #[serde(rename = "Contacts")]
    pub contacts: Contacts,
    pub robots: BTreeMap<String, RobotConfig>,
}

#[derive(Serialize)]
pub(super) struct States {
    #[serde(rename = "MCC::Initial_")]
    pub initial: State<Initial>,
    #[serde(rename = "MCC::ConfigMotion_")]
    pub motion: State<Motion>,
    #[serde(rename = "MCC::Main_")]
    pub main: Parallel,
}

#[derive(Serialize)]
pub(super) struct State<T> {
    pub base: &'static str,
    pub configs: T,
}

#[derive(Serialize)]
pub(super) struct Parallel {
    pub base: &'static str,
    pub states: FlowSeq<[&'static str; 1]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Initial {
    pub auto_start_time: f64,
    pub initial_contacts: Vec<InitialContact>,
}

#[derive(Serialize)]
pub(super) struct InitialContact {
    pub limb: String,
    #[serde(flatten)]
    pub constraint: Constraint,
}

#[derive(Serialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct LimbManagers {
    pub limb_manager: BTreeMap<String, LimbManager>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct LimbManager {
    #[serde(rename = "touchDownForceZ")]
    pub touch_down_force_z: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Motion {
    pub base_time: &'static str,
    pub step_command_list: Vec<StepCommand>,
    pub nominal_centroidal_pose_list: Vec<TimedPose>,
    pub nominal_posture_list: Vec<TimedPosture>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct StepCommand {
    pub limb: String,
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub start_time: f64,
    pub end_time: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub constraint: Option<Constraint>,
    pub swing_config: SwingConfig,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Constraint {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub fric_coeff: f64,
}

#[derive(Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SwingConfig {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub withdraw_duration_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub withdraw_offset: Option<Triple>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub approach_duration_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub approach_offset: Option<Triple>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swing_offset: Option<Triple>,
}

pub(super) type Triple = FlowSeq<[f64; 3]>;

#[derive(Serialize)]
pub(super) struct Pose {
    pub translation: Triple,
    pub rotation: Triple,
}

#[derive(Serialize)]
pub(super) struct TimedPose {
    pub time: f64,
    pub pose: Pose,
}

#[derive(Serialize)]
pub(super) struct TimedPosture {
    pub time: f64,
    pub target: Target,
}

/// Joint values by name, in the robot's order; the controller takes a list a joint.
pub(super) struct Target(pub Vec<(String, f64)>);

impl Serialize for Target {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let lists = self
            .0
            .iter()
            .map(|(joint, value)| (joint, FlowSeq([*value])));
        serializer.collect_map(lists)
    }
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct LimbTask {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub limb: String,
    pub frame: String,
    pub cutoff_period: f64,
    pub weight: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct Contacts {
    pub surface: Vec<Vertices>,
}

#[derive(Serialize)]
pub(super) struct Vertices {
    pub name: String,
    pub vertices: FlowSeq<Vec<[f64; 3]>>,
}

#[derive(Serialize)]
pub(super) struct RobotConfig {
    pub frames: Vec<Frame>,
    #[serde(rename = "BaseOrientationTask")]
    pub base_orientation: BaseOrientation,
    #[serde(rename = "CentroidalManager")]
    pub centroidal: Centroidal,
}

#[derive(Serialize)]
pub(super) struct Frame {
    pub name: String,
    pub parent: String,
    pub X_p_f: Pose,
}

#[derive(Serialize)]
pub(super) struct BaseOrientation {
    pub frame: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Centroidal {
    pub nominal_centroidal_pose_base_frame: &'static str,
    pub nominal_centroidal_pose: Pose,
}
