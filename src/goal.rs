//! The goal and the path toward it, as the planner takes them.

use anyhow::{Context, Result, bail};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use plan::{GoalContact, GoalJoints, GoalRecord};
use planner::Guide;
use posture::{BaseGoal, Environment, FaceIndex, JointGoal};
use robot_model::{Configuration, Kinematics, PatchId, Robot};
use scenes::scene_file;
use surfaces::{Face, Region, Terrain};

use crate::config::Config;
use crate::mistakes;
use crate::roles::why_not;
use crate::start::{StartState, ground};

/// Largest heading error at the goal, rad: less than the verifier allows (0.1) by what solvers leave.
const YAW_TOLERANCE_RAD: f64 = 0.095;
/// The part of its length to which a limb reaches with ease: beyond it, it is stretched.
const EASE: f64 = 0.8;
/// The part of that by which its base may be beside where it reaches best.
const BESIDE: f64 = 0.5;
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
    (stand, config): (&StartState, &posture::Config),
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
    let joints = joints(asked, robot, config)?;
    // What a hand is to touch it touches from many places.
    let first = contacts.first().filter(|_| position.is_empty());
    let limb = first.and_then(|&(patch, _)| Limb::new(robot, patch, &stand.configuration));
    Ok(planner::Goal {
        beside_m: limb.map_or(base.tolerance_m, |limb| BESIDE * limb.reach_m),
        base,
        patches: match asked.base_position_m.is_some() || joints.is_some() {
            true => stand.patches.clone(),
            false => Vec::new(),
        },
        joints,
        contacts,
    })
}

/// The joints that a goal wants, each within its limits by the margin that postures keep.
fn joints(
    asked: &scene_file::Goal,
    robot: &Robot,
    config: &posture::Config,
) -> Result<Option<JointGoal>> {
    let wanted = wanted_joints(asked, robot)?;
    let tolerance_rad = asked.joint_tolerance_rad;
    let joints = robot.joint_bodies().iter().zip(&wanted);
    let out_of_reach = joints.filter_map(|(body, wanted)| {
        let margin = body.kept_margin(config.joint_margin_rad);
        let (lower, upper) = (body.lower + margin, body.upper - margin);
        let wanted = (*wanted)?;
        let beyond = (lower - wanted).max(wanted - upper);
        let name = &body.joint;
        (beyond > tolerance_rad).then(|| {
            format!("{name} at {wanted:.3}: {beyond:.3} beyond what its limits and posture.joint_margin_rad leave, {lower:.3} to {upper:.3}")
        })
    });
    let out_of_reach: Vec<String> = out_of_reach.collect();
    if !out_of_reach.is_empty() {
        bail!(
            "the goal: no posture has {} (joint_tolerance_rad is {tolerance_rad})",
            out_of_reach.join(", ")
        );
    }
    let any = wanted.iter().any(Option::is_some);
    Ok(any.then_some(JointGoal {
        wanted,
        tolerance_rad,
    }))
}

/// The value of every joint that a goal names or its posture states.
fn wanted_joints(asked: &scene_file::Goal, robot: &Robot) -> Result<Vec<Option<f64>>> {
    let mut wanted = vec![None; robot.nj()];
    if let Some(name) = &asked.posture {
        let configuration = robot.posture(name).context("the goal")?;
        let is_stated = &robot.postures[name].is_stated;
        for ((wanted, value), _) in wanted
            .iter_mut()
            .zip(configuration.joints.iter())
            .zip(is_stated)
            .filter(|(_, is_stated)| **is_stated)
        {
            *wanted = Some(*value);
        }
    }
    let named = asked.joints_rad.iter().map(|(name, value)| {
        let joint = robot.joint_index(name).context("the goal")?;
        Ok((joint, *value))
    });
    for (joint, value) in mistakes::all(named)? {
        wanted[joint] = Some(value);
    }
    Ok(wanted)
}

/// How far apart two faces may be for a step from one to the other, m.
const STEP_M: f64 = 0.3;
/// Two soles of a humanoid and a little around them need this area of what is left of a face inside its edges, m².
const ROOM_M2: f64 = 0.1;

/// A place for the base, m to centimetres, where nobody said one yet: the middle of the face that lies farthest
/// straight ahead of W's origin, of those with room for feet that are come to by steps from the one nearest to it.
pub fn suggested(terrain: &Terrain, config: &Config) -> Option<[f64; 2]> {
    let (roles, sigmas) = (&config.surfaces.roles, config.posture.edge_sigmas);
    let ground_m = roles.ground_m(&terrain.faces, sigmas);
    let faces = terrain.faces.iter();
    let mut left: Vec<&Face> = faces
        .filter(|face| why_not("foot", face, roles, sigmas, ground_m).is_none())
        .collect();
    let origin = Point3::origin();
    let beside = |face: &Face| {
        let below = origin - face.normal_W() * face.height_of(&origin);
        apart_m(face, &below)
    };
    let first = left
        .iter()
        .copied()
        .min_by(|a, b| beside(a).total_cmp(&beside(b)))?;
    left.retain(|face| face.id != first.id);
    let (mut reached, mut next) = (vec![first], 0);
    while let Some(&from) = reached.get(next) {
        let is_near = |face: &&Face| face.vertices_W().iter().any(|v| apart_m(from, v) < STEP_M);
        let (near, far): (Vec<_>, Vec<_>) = left.into_iter().partition(is_near);
        reached.extend(near);
        left = far;
        next += 1;
    }
    let has_room = |face: &&&Face| {
        let regions = face.inset_region(sigmas, 0.0).regions();
        regions.iter().map(Region::area).sum::<f64>() >= ROOM_M2
    };
    let roomy = reached.iter().filter(has_room);
    let middles = roomy.map(|face| middle_W(face).xy().into());
    let ahead = |p: &Point2<f64>| p.x - p.y.abs();
    let far = middles.max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
    Some([far.x, far.y].map(|m| (100.0 * m).round() / 100.0))
}

/// Distance of a point from a face, m.
fn apart_m(face: &Face, p_W: &Point3<f64>) -> f64 {
    let p = face.X_WF.inverse_transform_point(p_W);
    ((face.region.nearest(&p.xy()) - p.xy()).norm_squared() + p.z * p.z).sqrt()
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

/// The path that the base should follow: through the key postures, or straight to the goal.
///
/// # Errors
/// A key posture that is not finite.
pub fn guide(
    asked: Option<&scene_file::Guide>,
    goal: &planner::Goal,
    (robot, stand): (&Robot, &StartState),
    environment: &Environment,
    standing_on: Option<FaceIndex>,
) -> Result<Guide> {
    let start = stand.configuration.p_WB;
    let aim = aim(goal, robot, &stand.configuration, environment);
    let end = || end(goal, aim, &start, environment, standing_on);
    let mut points = vec![start];
    match asked {
        Some(guide) => {
            let key_postures = guide.key_postures.iter();
            points.extend(key_postures.map(|&[x, y, z, _]| Vector3::new(x, y, z)));
            // Places to pass lead on to the goal.
            if let ([Some(x), Some(y), _], Some(last)) = (goal.base.position_m, points.last())
                && (x - last.x).hypot(y - last.y) > goal.base.tolerance_m
            {
                points.push(end());
            }
        }
        None => points.push(end()),
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

/// An arm, or another limb that is no leg: where it begins, in W, and how far it reaches with ease, m.
struct Limb {
    root_W: Vector3<f64>,
    reach_m: f64,
}

impl Limb {
    /// The limb of a patch, from the joint on that moves no other patch; nothing of a foot.
    fn new(robot: &Robot, patch: PatchId, at: &Configuration) -> Option<Self> {
        let patch = &robot.patches[patch];
        let kinematics = Kinematics::new(robot, at);
        let is_own = |body: usize| {
            let mut others = robot.patches.iter().filter(|p| p.body != patch.body);
            !others.any(|p| robot.supports(body, p.body))
        };
        let up = std::iter::successors(Some(patch.body), |&body| robot.bodies[body].parent);
        let joints_W = up
            .take_while(|&body| is_own(body))
            .map(|body| kinematics.origin_W[body]);
        let mut root_W = kinematics.X_WC(patch).translation.vector;
        let mut length_m = 0.0;
        for joint_W in joints_W {
            length_m += (joint_W - root_W).norm();
            root_W = joint_W;
        }
        (!patch.has_role("foot")).then_some(Self {
            root_W,
            reach_m: EASE * length_m,
        })
    }
}

/// Where the base is for the first contact that is wanted, seen from above, m: over the face where a foot is to stand on it, and
/// where another limb is to touch it, before it, as far from its nearest point as the limb reaches with ease.
fn aim(
    goal: &planner::Goal,
    robot: &Robot,
    start: &Configuration,
    environment: &Environment,
) -> Option<Vector2<f64>> {
    let &(patch, face) = goal.contacts.first()?;
    let face = &environment[face];
    let Some(limb) = Limb::new(robot, patch, start) else {
        return Some(middle_W(face).xy());
    };
    let base_F = face.X_WF.inverse_transform_point(&start.p_WB.into());
    let touched = face.point_W(&face.region.nearest(&base_F.xy())).coords;
    let down_m = limb.root_W.z - touched.z;
    let before_m = (limb.reach_m.powi(2) - down_m.powi(2)).max(0.0).sqrt();
    let back = (start.p_WB - touched).xy().try_normalize(1e-6);
    let back = back.unwrap_or_else(|| face.normal_W().xy());
    Some(touched.xy() + back * before_m.max(0.5 * limb.reach_m))
}

/// Where the base is at the goal, as far as one can tell without a posture.
fn end(
    goal: &planner::Goal,
    aim: Option<Vector2<f64>>,
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

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    #[test]
    fn the_goal_that_is_suggested_is_ahead_and_come_to_by_steps() {
        let rectangle = |id: &str, [x, y, z]: [f64; 3], size: [f64; 2]| {
            Face::rectangle(id, Isometry3::translation(x, y, z), size).unwrap()
        };
        let mut terrain = Terrain {
            faces: vec![
                rectangle("floor", [0.6, 0.0, 0.0], [0.6, 1.0]),
                rectangle("tread", [1.05, 0.1, 0.15], [0.3, 1.0]),
                rectangle("narrow", [1.3, 0.1, 0.3], [0.15, 1.0]),
                rectangle("aside", [1.0, 1.2, 0.0], [0.6, 1.0]),
                rectangle("beyond", [3.0, 0.0, 0.2], [1.0, 1.0]),
            ],
            obstacles: Vec::new(),
        };
        let config = Config::default();
        assert_eq!(suggested(&terrain, &config), Some([1.3, 0.1]));
        // Too narrow for two feet.
        terrain.faces[2] = rectangle("narrow", [1.3, 0.1, 0.3], [0.05, 1.0]);
        assert_eq!(suggested(&terrain, &config), Some([1.05, 0.1]));
        terrain.faces.clear();
        assert_eq!(suggested(&terrain, &config), None);
    }
}
