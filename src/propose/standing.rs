//! A standing posture: feet on level ground, knees bent, the centre of mass over their middle, left as
//! right.

use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use planner::PathStance;
use posture::{BaseGoal, Contact, Environment, Outcome, Problem};
use robot_model::propose::{Limb, LimbKind, Mirror, Tip, deepest, place};
use robot_model::{Configuration, Kinematics, PatchId, Robot};
use surfaces::{Face, Terrain};

use limbs::{Leg, legs, put_arms, put_legs};

mod limbs;

/// What is said of it in the file.
pub const ABOUT: &str = "Found by the posture generator: feet flat on level ground, as high as legs \
     still move their ends well, the centre of mass over the middle of the feet, left as right";

/// Legs stand where they move their ends at least this well, of the best.
const DEXTEROUS: f64 = 0.9;
/// Heights that are tried, of the legs' depth below the hips.
const HEIGHTS: [f64; 12] = [
    0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.45, 0.4,
];
/// How far outward feet are tried, of the legs' depth.
const OUTWARD: [f64; 7] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
/// Places that are given to the posture generator before it is given up.
const TRIES: usize = 12;
/// How level the base is, and how straight ahead it looks, rad.
const LEVEL_RAD: f64 = 2e-4;

/// Legs with too few joints for a sole stretched downward, all else neutral.
pub fn stretched(robot: &Robot, limbs: &[Limb]) -> Configuration {
    let mut at = robot.neutral();
    for limb in limbs {
        if limb.kind == LimbKind::Leg && limb.bodies.len() < 5 {
            let deep = deepest(robot, limb, &Tip::of(robot, limb)).0;
            for &body in &limb.bodies {
                at.joints[body - 1] = deep.joints[body - 1];
            }
        }
    }
    at
}

/// A posture that stands on all feet, the base upright over level ground.
///
/// # Errors
/// What stopped the posture generator at the first place that was tried.
pub fn stand(robot: &Robot, limbs: &[Limb], config: &posture::Config) -> Result<Configuration> {
    let legs = legs(robot, limbs);
    let mirror = Mirror::new(robot);
    let depth = legs.iter().map(|l| l.depth_m).reduce(f64::min);
    let depth = depth.context("no leg has a patch")?;
    if legs.len() < 3 && legs.iter().all(|l| !l.tip.flat) {
        bail!("two balls hold no posture at rest: three do, or a sole");
    }
    // 1. Places for the feet, best first.
    let mut places = Vec::new();
    for height in HEIGHTS {
        for outward in OUTWARD {
            if let Some((q, w)) = put_legs(robot, &legs, &mirror, [height, outward * depth, 0.0]) {
                places.push((height, outward * depth, q, w));
            }
        }
    }
    let best: Vec<f64> = (0..legs.len())
        .map(|k| places.iter().map(|p| p.3[k]).fold(0.0, f64::max))
        .collect();
    let worth = |w: &[f64]| {
        let parts = w.iter().zip(&best).map(|(w, best)| w / best.max(1e-12));
        parts.fold(f64::INFINITY, f64::min)
    };
    let (mut good, mut rest): (Vec<_>, Vec<_>) =
        places.into_iter().partition(|p| worth(&p.3) >= DEXTEROUS);
    good.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.0.total_cmp(&a.0)));
    rest.sort_by(|a, b| worth(&b.3).total_cmp(&worth(&a.3)));
    good.extend(rest);
    if good.is_empty() {
        return Err(anyhow!("its legs do not put all feet on level ground"));
    }
    // 2. The first at which the whole robot stands, and bears itself without any one of its feet.
    let (mut first, mut stuck) = (None, None);
    for (height, outward, q, _) in good.into_iter().take(TRIES) {
        match whole(robot, limbs, &legs, &mirror, (height, outward, q), config) {
            Ok(stands) if lifts_each(robot, &legs, &stands, config) => return Ok(stands),
            Ok(stands) => stuck = stuck.or(Some(stands)),
            Err(why) => {
                tracing::debug!(
                    "no standing {height} of the legs high, {outward:.3} m outward: {why:#}"
                );
                first = first.or(Some(why));
            }
        }
    }
    stuck.ok_or_else(|| first.unwrap_or_else(|| anyhow!("no place was found")))
}

/// The whole robot over feet at a place: centre of mass over their middle, arms bent beside it, and
/// what the posture generator makes of it.
fn whole(
    robot: &Robot,
    limbs: &[Limb],
    legs: &[Leg],
    mirror: &Mirror,
    (height, outward, mut q): (f64, f64, Configuration),
    config: &posture::Config,
) -> Result<Configuration> {
    let mut ahead = 0.0;
    for _ in 0..3 {
        put_arms(robot, limbs, mirror, &mut q);
        let kinematics = Kinematics::new(robot, &q);
        let feet = legs.iter().map(|l| middle(robot, &kinematics, l.patch).x);
        let off = kinematics.com_W.x - feet.sum::<f64>() / legs.len() as f64;
        if off.abs() < 1e-3 {
            break;
        }
        ahead += off;
        match put_legs(robot, legs, mirror, [height, outward, ahead]) {
            Some((placed, _)) => q = placed,
            None => break,
        }
    }
    put_arms(robot, limbs, mirror, &mut q);
    let feet: Vec<PatchId> = legs.iter().map(|l| l.patch).collect();
    let stands =
        |q: &Configuration| anyhow::Ok(solve(robot, &feet, q, config)?.1.posture.q.clone());
    let first = stands(&q)?;
    // What is the same left and right, where that stands too.
    let stands = stands(&mirror.evened(robot, &first)).unwrap_or(first);
    Ok(exactly(robot, legs, stands))
}

/// The same with the base level and every foot exactly on the ground: what the posture generator takes for
/// closed leaves a sole askew by a milliradian, and friction is told by its normal.
fn exactly(robot: &Robot, legs: &[Leg], mut q: Configuration) -> Configuration {
    let kinematics = Kinematics::new(robot, &q);
    q.R_WB = UnitQuaternion::identity();
    for leg in legs {
        let mut p = middle(robot, &kinematics, leg.patch);
        p.z = leg.radius_m;
        let X_WC = Isometry3::from_parts(p.into(), UnitQuaternion::identity());
        if let Some(placed) = place(robot, leg.limb, &leg.tip, &X_WC, &q) {
            q = placed;
        }
    }
    q
}

/// The middle of a patch in W.
fn middle(robot: &Robot, kinematics: &Kinematics, patch: PatchId) -> Vector3<f64> {
    kinematics.X_WC(&robot.patches[patch]).translation.vector
}

/// Level ground, and the feet on it where `q` has them.
fn on_ground(
    robot: &Robot,
    feet: &[PatchId],
    q: &Configuration,
) -> Result<(Environment, Vec<Contact>)> {
    let floor = Face::rectangle("ground", Isometry3::identity(), [10.0, 10.0])?;
    let environment = Environment::new(Terrain::new(vec![floor], Vec::new())?, 0.03, 0.0)?;
    let ground = environment.face("ground")?;
    let kinematics = Kinematics::new(robot, q);
    let contacts = feet.iter().map(|&foot| {
        let mut p = middle(robot, &kinematics, foot);
        p.z = robot.patches[foot].point_radius_m().unwrap_or(0.0);
        let X_WC = Isometry3::from_parts(p.into(), UnitQuaternion::identity());
        Contact::at(robot, foot, X_WC).on(ground, &environment)
    });
    let contacts = contacts.collect();
    Ok((environment, contacts))
}

/// Whether the others bear the robot with any of its feet about to leave the ground.
fn lifts_each(robot: &Robot, legs: &[Leg], q: &Configuration, config: &posture::Config) -> bool {
    let feet: Vec<PatchId> = legs.iter().map(|l| l.patch).collect();
    let Ok((environment, contacts)) = on_ground(robot, &feet, q) else {
        return false;
    };
    (0..contacts.len()).all(|lifted| {
        let mut contacts = contacts.clone();
        contacts[lifted].loaded = false;
        let problem = Problem::new(robot, &environment, contacts, q);
        posture::solve(&problem, config).is_ok_and(|outcome| outcome.posture().is_some())
    })
}

/// The posture nearest to `q` that stands with all feet on level ground, where `q` has them.
///
/// # Errors
/// The constraint that is in the way.
pub fn solve(
    robot: &Robot,
    feet: &[PatchId],
    q: &Configuration,
    config: &posture::Config,
) -> Result<(Environment, PathStance)> {
    let (environment, contacts) = on_ground(robot, feet, q)?;
    let problem = Problem {
        contacts,
        base_goal: Some(BaseGoal {
            position_m: [None, Some(0.0), Some(q.p_WB.z)],
            tolerance_m: 0.03 * q.p_WB.z.abs(),
            yaw_rad: Some(0.0),
            yaw_tolerance_rad: LEVEL_RAD,
        }),
        ..Problem::new(robot, &environment, Vec::new(), q)
    };
    let solver = posture::Solver {
        optimality: 1e-3,
        upright: Some(posture::Upright {
            z_W: Vector3::z(),
            tilt_max_rad: LEVEL_RAD,
        }),
        ..config.solver
    };
    let config = posture::Config {
        solver,
        ..config.clone()
    };
    match posture::solve(&problem, &config)? {
        Outcome::Feasible(posture) => {
            let stance = PathStance {
                change: plan::Change::Start,
                contacts: problem.contacts,
                posture: Arc::from(posture),
            };
            Ok((environment, stance))
        }
        other => {
            let why = other.violation().map(|v| v.describe(&problem));
            Err(anyhow!(why.unwrap_or_default()))
        }
    }
}
