//! The goal and the path toward it, as the planner takes them.

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::{Point3, Vector3};
use planner::Guide;
use planner::plan::{GoalContact, GoalRecord};
use posture::BaseGoal;
use robot_model::Robot;
use scenes::scene_file;
use surfaces::{Surface, SurfaceSet};

use crate::start::Stand;

/// Largest heading error at the goal, rad: what the verifier allows.
const YAW_TOLERANCE_RAD: f64 = 0.1;
/// Farthest that a surface may be from the point that names it, m.
const POINT_TOLERANCE_M: f64 = 0.05;

/// The goal that a scene asks for, on the surfaces that there are.
///
/// With a base position all patches that stood at the start must stand again.
///
/// # Errors
/// An unknown patch or surface; a point with no surface near it.
pub fn goal(
    asked: &scene_file::Goal,
    robot: &Robot,
    set: &SurfaceSet,
    stand: &Stand,
) -> Result<planner::Goal> {
    let coordinate = |i: usize| {
        asked
            .base_position_m
            .as_ref()
            .and_then(|p| p.get(i).copied())
    };
    let base = BaseGoal {
        position_m: [coordinate(0), coordinate(1), coordinate(2)],
        tolerance_m: asked.tolerance_m,
        yaw_rad: asked.yaw_rad,
        yaw_tolerance_rad: YAW_TOLERANCE_RAD,
    };
    let contacts = asked
        .contact
        .iter()
        .map(|contact| {
            let patch = robot.patch_index(&contact.patch).context("the goal")?;
            Ok((patch, wanted_surface(contact, set)?))
        })
        .collect::<Result<_>>()?;
    let patches = if asked.base_position_m.is_some() {
        stand.patches.clone()
    } else {
        Vec::new()
    };
    Ok(planner::Goal {
        base,
        patches,
        contacts,
    })
}

/// Index of the surface that a goal contact names or points at.
fn wanted_surface(contact: &scene_file::GoalContact, set: &SurfaceSet) -> Result<usize> {
    if let Some(id) = &contact.surface {
        return set
            .surfaces
            .iter()
            .position(|s| &s.id == id)
            .ok_or_else(|| {
                let known: Vec<&str> = set.surfaces.iter().map(|s| s.id.as_str()).collect();
                anyhow!(
                    "the goal: no surface is called {id:?}; there are: {}",
                    known.join(", ")
                )
            });
    }
    let point = Point3::from(
        contact
            .point_m
            .context("the goal: a contact without a place")?,
    );
    let nearest = set
        .surfaces
        .iter()
        .map(|surface| distance_m(surface, &point))
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1));
    match nearest {
        Some((index, distance)) if distance <= POINT_TOLERANCE_M => Ok(index),
        Some((index, distance)) => bail!(
            "the goal: no surface at ({}, {}, {}); the nearest, {}, is {distance:.3} m away",
            point.x,
            point.y,
            point.z,
            set.surfaces[index].id
        ),
        None => bail!("the goal: there is no surface to touch"),
    }
}

/// Distance of a point from a surface's polygon, m.
#[allow(non_snake_case)]
fn distance_m(surface: &Surface, p_W: &Point3<f64>) -> f64 {
    let p = surface.X_WS.inverse_transform_point(p_W);
    surface.polygon.signed_distance(&p.xy()).max(0.0).hypot(p.z)
}

/// The path that the base should follow: through the key postures, or straight to the goal.
///
/// # Errors
/// A key posture that is not finite.
pub fn guide(
    asked: Option<&scene_file::Guide>,
    goal: &planner::Goal,
    stand: &Stand,
    set: &SurfaceSet,
    standing_on: &[usize],
) -> Result<Guide> {
    let start = stand.configuration.p_WB;
    let mut points = vec![start];
    match asked {
        Some(guide) => {
            points.extend(
                guide
                    .key_postures
                    .iter()
                    .map(|[x, y, z, _]| Vector3::new(*x, *y, *z)),
            );
            // Places to pass lead on to the goal.
            if let ([Some(x), Some(y), _], Some(last)) = (goal.base.position_m, points.last())
                && (x - last.x).hypot(y - last.y) > goal.base.tolerance_m
            {
                points.push(end(goal, &start, set, standing_on));
            }
        }
        None => points.push(end(goal, &start, set, standing_on)),
    }
    // A path to where the robot stands has two points too.
    if points.len() == 1 {
        points.push(start);
    }
    Ok(Guide::new(points)?)
}

/// Where the base is at the goal, as far as one can tell without a posture.
fn end(
    goal: &planner::Goal,
    start: &Vector3<f64>,
    set: &SurfaceSet,
    standing_on: &[usize],
) -> Vector3<f64> {
    let ground = |surface: &Surface, x: f64, y: f64| {
        // The height of the plane over (x, y).
        let n = surface.normal_W();
        let o = surface.X_WS.translation.vector;
        o.z - (n.x * (x - o.x) + n.y * (y - o.y)) / n.z
    };
    let over_ground = standing_on.first().map_or(0.0, |&s| {
        start.z - ground(&set.surfaces[s], start.x, start.y)
    });
    match goal.base.position_m {
        [Some(x), Some(y), Some(z)] => Vector3::new(x, y, z),
        [x, y, _] => {
            let aim = goal
                .contacts
                .first()
                .map(|&(_, s)| set.surfaces[s].X_WS.translation.vector);
            let x = x.or(aim.map(|p| p.x)).unwrap_or(start.x);
            let y = y.or(aim.map(|p| p.y)).unwrap_or(start.y);
            // The highest level face under the goal carries the feet there.
            let under = set
                .surfaces
                .iter()
                .filter(|s| s.normal_W().z > 0.7)
                .filter_map(|s| {
                    let height = ground(s, x, y);
                    let p = s.X_WS.inverse_transform_point(&Point3::new(x, y, height));
                    s.polygon.contains(&p.xy(), 0.0).then_some(height)
                });
            let height = under.max_by(f64::total_cmp);
            Vector3::new(x, y, height.map_or(start.z, |height| height + over_ground))
        }
    }
}

/// The goal as it is written in the plan.
pub fn record(goal: &planner::Goal, robot: &Robot, set: &SurfaceSet) -> GoalRecord {
    let position = goal.base.position_m;
    GoalRecord {
        base_position_m: position.iter().any(Option::is_some).then_some(position),
        tolerance_m: goal.base.tolerance_m,
        yaw_rad: goal.base.yaw_rad,
        contacts: goal
            .contacts
            .iter()
            .map(|&(patch, surface)| GoalContact {
                patch: robot.patches[patch].name.clone(),
                surface: set.surfaces[surface].id.clone(),
            })
            .collect(),
    }
}
