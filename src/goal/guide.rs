//! The path that the base should roughly follow to a goal.

use anyhow::Result;
use nalgebra::{Point3, Vector2, Vector3};
use planner::Guide;
use posture::{Environment, FaceIndex};
use robot_model::{Configuration, Kinematics, PatchId, Robot};
use scenes::scene_file;
use surfaces::Face;

use super::middle_W;
use crate::start::StartState;

/// The part of its length to which a limb reaches with ease: beyond it, it is stretched.
const EASE: f64 = 0.8;
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

/// An arm, or another limb that is no leg: where it begins, in W, and how far it reaches with ease, m.
pub(super) struct Limb {
    root_W: Vector3<f64>,
    pub reach_m: f64,
}

impl Limb {
    /// The limb of a patch, from the joint on that moves no other patch; nothing of a foot.
    pub fn new(robot: &Robot, patch: PatchId, at: &Configuration) -> Option<Self> {
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
