//! The page of a robot: its patches as faces, with names and frames, and where they reach.

use anyhow::Result;
use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};
use plan::{PLAN_FORMAT, Plan, RequiredMargins};
use posture::stand;
use robot_model::{ContactPatch, Kinematics, PatchId, Robot, propose};
use surfaces::{Face, Region};

use super::ViewInput;
use crate::propose::standing;

/// Drawn postures whose patches show where they reach.
const POSTURES: u64 = 1500;
/// Corners of a ball's disc.
const ROUND: usize = 16;

/// The page of a robot as it rests, on its feet.
///
/// # Errors
/// A patch that is no face.
pub fn robot_page(robot: &Robot) -> Result<String> {
    let is_foot = |p: &PatchId| robot.patches[*p].has_role("foot");
    let feet: Vec<PatchId> = robot.patch_ids().filter(is_foot).collect();
    let mut stands = stand::on_level_ground(robot, &robot.resting(), &feet);
    // With the forces that hold it, where it stands.
    let posture = posture::Config::default();
    let held = standing::solve(robot, &feet, &stands, &posture).ok();
    let stances = match &held {
        Some((environment, stance)) => {
            stands = stance.posture.q.clone();
            planner::record::stances(robot, environment, std::slice::from_ref(stance))
        }
        None => Vec::new(),
    };
    let kinematics = Kinematics::new(robot, &stands);
    let faces = robot
        .patches
        .iter()
        .map(|patch| face(patch, &kinematics.X_WC(patch)));
    let faces = faces.collect::<Result<Vec<Face>>>()?;
    // Where patches come, the base as it stands.
    let mut cloud_W = Vec::new();
    for number in 1..=POSTURES {
        let mut drawn = propose::drawn(robot, number);
        (drawn.p_WB, drawn.R_WB) = (stands.p_WB, stands.R_WB);
        let kinematics = Kinematics::new(robot, &drawn);
        let places = robot
            .patches
            .iter()
            .map(|p| kinematics.X_WC(p).translation.vector);
        cloud_W.extend(places.map(|p| [p.x as f32, p.y as f32, p.z as f32]));
    }
    let plan = Plan {
        format: PLAN_FORMAT.to_owned(),
        program: crate::program(),
        scene: format!("{}: where it may touch", robot.name),
        robot: crate::posed::summary(robot),
        faces,
        required: RequiredMargins::from(&posture),
        stances,
        ..Plan::default()
    };
    let input = ViewInput {
        cloud_W: &cloud_W,
        ..ViewInput::new(&plan, robot)
    };
    super::page_of("robot", &input)
}

/// A patch as a face that looks out of the robot.
fn face(patch: &ContactPatch, X_WC: &Isometry3<f64>) -> Result<Face> {
    let out = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let (X_WF, ring): (Isometry3<f64>, Vec<Point2<f64>>) = match patch.point_radius_m() {
        None => {
            let turned = patch.polygon.iter().rev().map(|p| Point2::new(p.x, -p.y));
            (X_WC * out, turned.collect())
        }
        Some(radius_m) => {
            let down = Translation3::from(X_WC.translation.vector - Vector3::z() * radius_m);
            let angle = |k: usize| std::f64::consts::TAU * k as f64 / ROUND as f64;
            let at = |a: f64| Point2::new(radius_m * a.cos(), radius_m * a.sin());
            (down * out, (0..ROUND).map(angle).map(at).collect())
        }
    };
    Ok(Face::new(patch.name.as_str(), X_WF, Region::new([ring])?))
}
