//! The goal and the path toward it, as the planner takes them.

use anyhow::{Context, Result, bail};
use nalgebra::{Point3, Vector3};
use plan::{GoalContact, GoalRecord};
use planner::Guide;
use posture::{BaseGoal, Environment, FaceIndex};
use robot_model::{PatchId, Robot};
use scenes::scene_file;
use surfaces::Face;

use crate::mistakes;
use crate::start::{StartState, ground};

/// Largest heading error at the goal, rad: less than the verifier allows (0.1) by what solvers leave.
const YAW_TOLERANCE_RAD: f64 = 0.095;
/// Farthest that a face may be from the point that names it, m.
const POINT_TOLERANCE_M: f64 = 0.05;

/// The goal that a scene asks for, on the faces that there are.
///
/// With a base position all patches that stood at the start must stand again.
///
/// # Errors
/// Unknown patches or faces; points with no face near them.
pub fn goal(
    asked: &scene_file::Goal,
    robot: &Robot,
    environment: &Environment,
    stand: &StartState,
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
    Ok(planner::Goal {
        base,
        contacts,
        patches: match asked.base_position_m {
            Some(_) => stand.patches.clone(),
            None => Vec::new(),
        },
    })
}

/// Whether there are the patches and faces that a goal names, as far as that can be told before the robot
/// stands: the ground under its feet is not there yet.
///
/// # Errors
/// Unknown patches and faces.
pub fn named(asked: &scene_file::Goal, robot: &Robot, environment: &Environment) -> Result<()> {
    let all = mistakes::all(asked.contact.iter().map(|contact| {
        let patch = robot.patch_id(&contact.patch).context("the goal");
        let seen = contact.surface.iter().filter(|id| !ground::is_name(id));
        let faces = mistakes::all(seen.map(|id| environment.face(id).context("the goal")));
        mistakes::both(patch, faces)
    }));
    all.map(drop)
}

/// The face that a goal contact names or points at.
fn wanted_face(contact: &scene_file::GoalContact, environment: &Environment) -> Result<FaceIndex> {
    if let Some(id) = &contact.surface {
        return environment.face(id).context("the goal");
    }
    let point = contact.point_m;
    let point = Point3::from(point.context("the goal: a contact without a place")?);
    let faces = environment.faces();
    let distances = faces.map(|f| (f, distance_m(&environment[f], &point)));
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

/// Distance of a point from a face, m.
fn distance_m(face: &Face, p_W: &Point3<f64>) -> f64 {
    let p = face.X_WF.inverse_transform_point(p_W);
    (face.region.nearest(&p.xy()) - p.xy()).norm().hypot(p.z)
}

/// The path that the base should follow: through the key postures, or straight to the goal.
///
/// # Errors
/// A key posture that is not finite.
pub fn guide(
    asked: Option<&scene_file::Guide>,
    goal: &planner::Goal,
    stand: &StartState,
    environment: &Environment,
    standing_on: Option<FaceIndex>,
) -> Result<Guide> {
    let start = stand.configuration.p_WB;
    let mut points = vec![start];
    match asked {
        Some(guide) => {
            let key_postures = guide.key_postures.iter();
            points.extend(key_postures.map(|&[x, y, z, _]| Vector3::new(x, y, z)));
            // Places to pass lead on to the goal.
            if let ([Some(x), Some(y), _], Some(last)) = (goal.base.position_m, points.last())
                && (x - last.x).hypot(y - last.y) > goal.base.tolerance_m
            {
                points.push(end(goal, &start, environment, standing_on));
            }
        }
        None => points.push(end(goal, &start, environment, standing_on)),
    }
    // A path to where the robot stands has two points too.
    if points.len() == 1 {
        points.push(start);
    }
    Ok(Guide::new(points)?)
}

/// The middle of a face, in W.
fn middle_W(face: &Face) -> Vector3<f64> {
    face.point_W(&face.region.centroid()).coords
}

/// Where the base is at the goal, as far as one can tell without a posture.
fn end(
    goal: &planner::Goal,
    start: &Vector3<f64>,
    environment: &Environment,
    standing_on: Option<FaceIndex>,
) -> Vector3<f64> {
    let ground = |face: &Face, x: f64, y: f64| {
        // The height of the plane over (x, y).
        let n = face.normal_W();
        let o = face.X_WF.translation.vector;
        o.z - (n.x * (x - o.x) + n.y * (y - o.y)) / n.z
    };
    let over_ground = standing_on.map_or(0.0, |face| {
        start.z - ground(&environment[face], start.x, start.y)
    });
    match goal.base.position_m {
        [Some(x), Some(y), Some(z)] => Vector3::new(x, y, z),
        [x, y, _] => {
            let first = goal.contacts.first();
            let aim = first.map(|&(_, face)| middle_W(&environment[face]));
            let x = x.or(aim.map(|p| p.x)).unwrap_or(start.x);
            let y = y.or(aim.map(|p| p.y)).unwrap_or(start.y);
            // The highest level face under the goal carries the feet there.
            let level = environment.faces().map(|f| &environment[f]);
            let under = level.filter(|f| f.normal_W().z > 0.7).filter_map(|f| {
                let height = ground(f, x, y);
                let p = f.X_WF.inverse_transform_point(&Point3::new(x, y, height));
                f.region.contains(&p.xy()).then_some(height)
            });
            let height = under.max_by(f64::total_cmp);
            Vector3::new(x, y, height.map_or(start.z, |height| height + over_ground))
        }
    }
}

/// The goal as it is written in the plan.
pub fn record(goal: &planner::Goal, robot: &Robot, environment: &Environment) -> GoalRecord {
    let position = goal.base.position_m;
    let contact = |&(patch, face): &(PatchId, FaceIndex)| GoalContact {
        patch: robot.patches[patch].name.clone(),
        face: environment[face].id.clone(),
    };
    GoalRecord {
        base_position_m: position.iter().any(Option::is_some).then_some(position),
        tolerance_m: goal.base.tolerance_m,
        yaw_rad: goal.base.yaw_rad,
        contacts: goal.contacts.iter().map(contact).collect(),
    }
}
