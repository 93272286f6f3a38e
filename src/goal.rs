//! The goal and the path toward it, as the planner takes them.

mod guide;
mod joints;
mod suggested;

pub use guide::guide;
pub use suggested::suggested;

use anyhow::{Context, Result, bail};
use nalgebra::{Point3, Vector3};
use plan::{GoalContact, GoalJoints, GoalRecord};
use posture::{BaseGoal, Environment, FaceIndex};
use robot_model::{PatchId, Robot};
use scenes::scene_file;
use surfaces::Face;

use self::guide::Limb;
use self::joints::{joint_goal, wanted_joints};
use crate::mistakes;
use crate::start::ground;

/// Largest heading error at the goal, rad: less than the verifier allows (0.1) by what solvers leave.
const YAW_TOLERANCE_RAD: f64 = 0.095;
/// The part of a limb's easy reach by which its base may be beside where it reaches best.
const BESIDE: f64 = 0.5;
/// Farthest that a face may be from the point that names it, m.
const POINT_TOLERANCE_M: f64 = 0.05;

/// The goal that a scene asks for, on the faces that there are.
///
/// With a base position or joints all patches that the robot stood on at the start must stand again.
///
/// # Errors
/// Unknown patches, faces, postures or joints; points with no face near them; joints out of their range.
pub fn goal(
    asked: &scene_file::Goal,
    robot: &Robot,
    environment: &Environment,
    (start, config): (&planner::Start, &posture::Config),
) -> Result<planner::Goal> {
    let position = asked.base_position_m.as_deref().unwrap_or_default();
    let base = BaseGoal {
        position_m: [0, 1, 2].map(|i| position.get(i).copied()),
        tolerance_m: asked.tolerance_m,
        yaw_rad: asked.yaw_rad,
        yaw_tolerance_rad: YAW_TOLERANCE_RAD,
    };
    let contacts = mistakes::all(asked.contact.iter().map(|contact| {
        let patch = robot.patch_id(&contact.patch).context("the goal");
        mistakes::both(patch, wanted_face(contact, environment))
    }))?;
    let joints = joint_goal(asked, robot, config)?;
    // What a hand is to touch it touches from many places.
    let first = contacts.first().filter(|_| position.is_empty());
    let limb = first.and_then(|&(patch, _)| Limb::new(robot, patch, &start.configuration));
    Ok(planner::Goal {
        beside_m: limb.map_or(base.tolerance_m, |limb| BESIDE * limb.reach_m),
        base,
        patches: match asked.base_position_m.is_some() || joints.is_some() {
            true => start.feet.clone(),
            false => Vec::new(),
        },
        joints,
        contacts,
    })
}

/// Distance of a point from a face, m.
fn apart_m(face: &Face, p_W: &Point3<f64>) -> f64 {
    let p = face.X_WF.inverse_transform_point(p_W);
    ((face.region.nearest(&p.xy()) - p.xy()).norm_squared() + p.z * p.z).sqrt()
}

/// Whether there are the patches, faces, postures and joints that a goal names, as far as that can be told before the robot
/// stands: the ground under its feet is not there yet.
///
/// # Errors
/// Those that there are not.
pub fn named(asked: &scene_file::Goal, robot: &Robot, environment: &Environment) -> Result<()> {
    let all = mistakes::all(asked.contact.iter().map(|contact| {
        let patch = robot.patch_id(&contact.patch).context("the goal");
        let seen = contact.surface.iter().filter(|id| !ground::is_name(id));
        let faces = mistakes::all(seen.map(|id| environment.face(id).context("the goal")));
        mistakes::both(patch, faces)
    }));
    mistakes::both(all, wanted_joints(asked, robot)).map(drop)
}

/// The face that a goal contact names or points at.
fn wanted_face(contact: &scene_file::GoalContact, environment: &Environment) -> Result<FaceIndex> {
    if let Some(id) = &contact.surface {
        return environment.face(id).context("the goal");
    }
    let point = contact.point_m;
    let point = Point3::from(point.context("the goal: a contact without a place")?);
    let faces = environment.faces();
    let distances = faces.map(|f| (f, apart_m(&environment[f], &point)));
    match distances.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((face, distance)) if distance <= POINT_TOLERANCE_M => Ok(face),
        Some((face, distance)) => bail!(
            "the goal: no face at ({}, {}, {}); the nearest, {}, is {distance:.3} m away",
            point.x,
            point.y,
            point.z,
            environment[face].id
        ),
        None => bail!("the goal: there is no face to touch"),
    }
}

/// The middle of a face, in W.
fn middle_W(face: &Face) -> Vector3<f64> {
    face.point_W(&face.region.centroid()).coords
}

/// The goal as it is written in the plan.
pub fn record(goal: &planner::Goal, robot: &Robot, environment: &Environment) -> GoalRecord {
    let position = goal.base.position_m;
    let contact = |&(patch, face): &(PatchId, FaceIndex)| GoalContact {
        patch: robot.patches[patch].name.clone(),
        face: environment[face].id.clone(),
    };
    let joints = goal.joints.as_ref().map(|joints| {
        let named = robot.joint_names().zip(&joints.wanted);
        let named = named.filter_map(|(name, wanted)| Some((name.to_owned(), (*wanted)?)));
        GoalJoints {
            wanted: named.collect(),
            tolerance_rad: joints.tolerance_rad,
        }
    });
    GoalRecord {
        base_position_m: position.iter().any(Option::is_some).then_some(position),
        tolerance_m: goal.base.tolerance_m,
        yaw_rad: goal.base.yaw_rad,
        contacts: goal.contacts.iter().map(contact).collect(),
        joints,
    }
}
