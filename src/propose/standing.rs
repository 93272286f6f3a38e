//! A standing posture: feet on level ground, knees bent, the centre of mass over their middle, left as
//! right.
#![allow(non_snake_case)]

use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use planner::PathStance;
use posture::{BaseGoal, Contact, Environment, Outcome, Problem};
use robot_model::collision::Other;
use robot_model::propose::{Limb, LimbKind, Mirror, Tip, deepest, dexterity, place};
use robot_model::{Configuration, Kinematics, PatchId, PatchKind, Robot};
use surfaces::{Face, Terrain};

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
/// Starts of the descent to a place.
const STARTS: u64 = 10;
/// Places that are given to the posture generator before it is given up.
const TRIES: usize = 12;
/// Where a hand is wanted from its shoulder, of the arm's length: ahead, outward, up.
const HANDS: [[f64; 3]; 4] = [
    [0.2, 0.1, -0.75],
    [0.35, 0.2, -0.6],
    [0.4, 0.35, -0.4],
    [0.5, 0.3, 0.0],
];
/// Distance of an arm from the rest, m, as part of its length.
const ROOM: f64 = 0.03;
/// Distance between parts of one limb, m: more than the posture generator asks for.
const FOLDED_M: f64 = 0.006;
/// How level the base is, and how straight ahead it looks, rad.
const LEVEL_RAD: f64 = 2e-4;
/// A joint's margin where it is placed, rad.
const MARGIN: f64 = 0.05;

/// A leg and the end that it stands on.
struct Leg<'a> {
    limb: &'a Limb,
    patch: PatchId,
    tip: Tip,
    radius_m: f64,
    /// The other side's, where this one leads.
    leads: bool,
    /// Where its end is below the base with the leg stretched, m; its hip's height.
    under: Vector3<f64>,
    hip: Vector3<f64>,
    depth_m: f64,
    outward: Vector3<f64>,
}

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

fn legs<'a>(robot: &Robot, limbs: &'a [Limb]) -> Vec<Leg<'a>> {
    let neutral = Kinematics::new(robot, &robot.neutral());
    let feet = robot
        .patch_ids()
        .filter(|p| robot.patches[*p].has_role("foot"));
    let legs = feet.filter_map(|id| {
        let patch = &robot.patches[id];
        let number = limbs.iter().position(|l| l.bodies.contains(&patch.body))?;
        let limb = &limbs[number];
        let tip = Tip {
            body: patch.body,
            X_BC: patch.X_BC,
            flat: patch.kind == PatchKind::Area,
        };
        let (deep, deepest_m) = deepest(
            robot,
            limb,
            &Tip {
                flat: false,
                ..tip.clone()
            },
        );
        let p = (Kinematics::new(robot, &deep).X_WB[tip.body] * tip.X_BC)
            .translation
            .vector;
        let rests = (neutral.X_WB[tip.body] * tip.X_BC).translation.vector;
        let hip = neutral.origin_W[limb.bodies[0]];
        // Legs that point down at neutral keep their feet apart as they are.
        let downward = hip.z - rests.z > 0.5 * (deepest_m + hip.z);
        let away = Vector3::new(rests.x - hip.x, rests.y - hip.y, 0.0);
        let sideways = Vector3::y() * hip.y.signum();
        Some(Leg {
            limb,
            patch: id,
            radius_m: patch.point_radius_m().unwrap_or(0.0),
            leads: limb.mirror.is_none_or(|m| m > number),
            under: Vector3::new(p.x, if downward { rests.y } else { p.y }, 0.0),
            hip,
            depth_m: deepest_m + hip.z,
            outward: match downward {
                false => away.try_normalize(1e-6).unwrap_or(sideways),
                true => sideways,
            },
            tip,
        })
    });
    legs.collect()
}

/// The legs at a height, outward and ahead of where they hang, with how well each moves its end.
fn put_legs(
    robot: &Robot,
    legs: &[Leg],
    mirror: &Mirror,
    [height, outward, ahead]: [f64; 3],
) -> Option<(Configuration, Vec<f64>)> {
    let mut q = robot.neutral();
    let ground = legs
        .iter()
        .map(|l| height * l.depth_m - l.hip.z + l.radius_m);
    let ground = ground.fold(f64::INFINITY, f64::min);
    for leg in legs.iter().filter(|l| l.leads) {
        let mut p = leg.under + leg.outward * outward;
        p.x += ahead;
        p.z = leg.radius_m - ground;
        let X_WC = Isometry3::from_parts(p.into(), UnitQuaternion::identity());
        let joints = || leg.limb.bodies.iter().map(|b| b - 1);
        let starts = (0..STARTS).map(|number| {
            let mut start = q.clone();
            if number > 0 {
                let drawn = robot_model::propose::drawn(robot, number);
                joints().for_each(|j| start.joints[j] = drawn.joints[j]);
            }
            start
        });
        let ends = starts.filter_map(|start| place(robot, leg.limb, &leg.tip, &X_WC, &start));
        let fine = ends.filter(|q| {
            joints().all(|j| {
                let body = &robot.joint_bodies()[j];
                let margin = body.kept_margin(MARGIN);
                q.joints[j] >= body.lower + margin && q.joints[j] <= body.upper - margin
            })
        });
        q = fine.min_by(|a, b| strain(robot, leg, a).total_cmp(&strain(robot, leg, b)))?;
        mirror.copy(robot, &mut q, joints());
    }
    q.p_WB.z = ground;
    let w = legs
        .iter()
        .map(|l| dexterity(robot, l.limb, &l.tip, &q))
        .collect();
    // The other side's feet must be where the mirror has them.
    let kinematics = Kinematics::new(robot, &q);
    let touches = |l: &Leg| {
        let X_WC = kinematics.X_WC(&robot.patches[l.patch]);
        (X_WC.translation.vector.z - l.radius_m).abs() < 0.02
    };
    // Legs beside each other; what else is too near the posture generator parts.
    let all: Vec<usize> = legs
        .iter()
        .flat_map(|l| robot.subtree(l.limb.bodies[0]))
        .collect();
    let rest: Vec<usize> = (0..robot.bodies.len())
        .filter(|b| !all.contains(b))
        .collect();
    let free = |l: &Leg| {
        let apart = parts_m(robot, l.limb, &q, FOLDED_M, &rest).1;
        touches(l) && apart >= FOLDED_M
    };
    legs.iter().all(free).then_some((q, w))
}

/// How far a leg's joints are from the middle of their ranges, and its knee from the robot's middle:
/// where legs may bend either way, shanks then lean outward over an edge, and not the knees.
fn strain(robot: &Robot, leg: &Leg, q: &Configuration) -> f64 {
    let off = |&b: &usize| {
        let body = &robot.bodies[b];
        let half = (0.5 * (body.upper - body.lower)).max(1e-6);
        ((q.joints[b - 1] - 0.5 * (body.upper + body.lower)) / half.max(1.5)).powi(2)
    };
    let kinematics = Kinematics::new(robot, q);
    let bodies = &leg.limb.bodies;
    let far = (leg.hip.x.abs() > 0.1 * leg.depth_m) as u8 as f64 * leg.hip.x.signum();
    let knee = bodies.iter().map(|&b| kinematics.origin_W[b]);
    let end = (kinematics.X_WB[leg.tip.body] * leg.tip.X_BC)
        .translation
        .vector;
    let bend = |p: &Vector3<f64>| (p - leg.hip).cross(&(end - leg.hip)).norm();
    let knee = knee
        .max_by(|a, b| bend(a).total_cmp(&bend(b)))
        .unwrap_or_default();
    bodies.iter().map(off).sum::<f64>() + 2.0 * far * (knee.x - leg.hip.x) / leg.depth_m
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

/// Brings the arms to where they are out of the way: hands beside and before the body, elbows bent.
fn put_arms(robot: &Robot, limbs: &[Limb], mirror: &Mirror, q: &mut Configuration) {
    for (number, limb) in limbs.iter().enumerate() {
        let leads = limb.mirror.is_some_and(|m| m > number);
        if limb.kind != LimbKind::Arm || !leads {
            continue;
        }
        let kinematics = Kinematics::new(robot, q);
        let (shoulder, tip) = (kinematics.origin_W[limb.bodies[0]], Tip::of(robot, limb));
        let joints = || limb.bodies.iter().map(|b| b - 1);
        let room = (ROOM * limb.length_m).max(FOLDED_M);
        let wanted = HANDS.iter().filter_map(|[x, y, z]| {
            let side = shoulder.y.signum();
            let p = shoulder + Vector3::new(*x, y * side, *z) * limb.length_m;
            let X_WC = Isometry3::from_parts(p.into(), UnitQuaternion::identity());
            let reached = (0..STARTS).filter_map(|start| {
                let mut from = q.clone();
                if start > 0 {
                    let drawn = robot_model::propose::drawn(robot, start);
                    joints().for_each(|j| from.joints[j] = drawn.joints[j]);
                }
                let mut to = place(robot, limb, &tip, &X_WC, &from)?;
                mirror.copy(robot, &mut to, joints());
                let body = |j: usize| &robot.joint_bodies()[j];
                let part =
                    |j: usize| (to.joints[j] - 0.0_f64.clamp(body(j).lower, body(j).upper)).powi(2);
                let strain: f64 = joints().map(part).sum();
                let (own, rest) = parts_m(robot, limb, &to, room, &[]);
                let free = own >= FOLDED_M && rest >= room;
                free.then_some((strain, to))
            });
            reached.min_by(|a, b| a.0.total_cmp(&b.0))
        });
        let found = wanted.map(|w| w.1).next();
        if let Some(to) = found {
            *q = to;
        }
    }
}

/// The least distance between links of a limb that are watched, and from it to all but some bodies, m,
/// where it is below `within_m`.
fn parts_m(
    robot: &Robot,
    limb: &Limb,
    q: &Configuration,
    within_m: f64,
    but: &[usize],
) -> (f64, f64) {
    let mut near = Vec::new();
    let kinematics = Kinematics::new(robot, q);
    robot
        .collision
        .self_proximities(&kinematics, within_m, &mut near);
    let on = |body: usize| robot.subtree(limb.bodies[0]).contains(&body);
    let mut least = (f64::INFINITY, f64::INFINITY);
    for p in near {
        let Other::Shape(b) = p.b else { continue };
        match (on(p.a.body), on(b.body)) {
            (true, true) => least.0 = least.0.min(p.distance),
            (false, false) => {}
            _ if but.contains(&p.a.body) || but.contains(&b.body) => {}
            _ => least.1 = least.1.min(p.distance),
        }
    }
    least
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
