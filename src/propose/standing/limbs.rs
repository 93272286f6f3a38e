//! Legs and arms where a standing robot has them, by their own joints.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot_model::collision::Other;
use robot_model::propose::{Limb, LimbKind, Mirror, Tip, deepest, dexterity, place};
use robot_model::{Configuration, Kinematics, PatchId, PatchKind, Robot};

/// Starts of the descent to a place.
const STARTS: u64 = 10;
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
/// A joint's margin where it is placed, rad.
const MARGIN: f64 = 0.05;

/// A leg and the end that it stands on.
pub(super) struct Leg<'a> {
    pub limb: &'a Limb,
    pub patch: PatchId,
    pub tip: Tip,
    pub radius_m: f64,
    /// The other side's, where this one leads.
    leads: bool,
    /// Where its end is below the base with the leg stretched, m; its hip's height.
    under: Vector3<f64>,
    hip: Vector3<f64>,
    pub depth_m: f64,
    outward: Vector3<f64>,
}

/// The legs with the feet that they stand on.
pub(super) fn legs<'a>(robot: &Robot, limbs: &'a [Limb]) -> Vec<Leg<'a>> {
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
        let (deep, deepest_m) = deepest(robot, limb, &tip);
        let p = tip.p_W(&Kinematics::new(robot, &deep));
        let rests = tip.p_W(&neutral);
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
pub(super) fn put_legs(
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
        let starts = leg.limb.starts(robot, &q, STARTS);
        let ends = starts.filter_map(|start| place(robot, leg.limb, &leg.tip, &X_WC, &start));
        let fine = ends.filter(|q| {
            leg.limb.joints().all(|j| {
                let body = &robot.joint_bodies()[j];
                let margin = body.kept_margin(MARGIN);
                q.joints[j] >= body.lower + margin && q.joints[j] <= body.upper - margin
            })
        });
        q = fine.min_by(|a, b| strain(robot, leg, a).total_cmp(&strain(robot, leg, b)))?;
        mirror.copy(robot, &mut q, leg.limb.joints());
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
    let end = leg.tip.p_W(&kinematics);
    let bend = |p: &Vector3<f64>| (p - leg.hip).cross(&(end - leg.hip)).norm();
    let knee = knee
        .max_by(|a, b| bend(a).total_cmp(&bend(b)))
        .unwrap_or_default();
    bodies.iter().map(off).sum::<f64>() + 2.0 * far * (knee.x - leg.hip.x) / leg.depth_m
}

/// Brings the arms to where they are out of the way: hands beside and before the body, elbows bent.
pub(super) fn put_arms(robot: &Robot, limbs: &[Limb], mirror: &Mirror, q: &mut Configuration) {
    for (number, limb) in limbs.iter().enumerate() {
        let leads = limb.mirror.is_some_and(|m| m > number);
        if limb.kind != LimbKind::Arm || !leads {
            continue;
        }
        let kinematics = Kinematics::new(robot, q);
        let (shoulder, tip) = (kinematics.origin_W[limb.bodies[0]], Tip::of(robot, limb));
        let room = (ROOM * limb.length_m).max(FOLDED_M);
        let wanted = HANDS.iter().filter_map(|[x, y, z]| {
            let side = shoulder.y.signum();
            let p = shoulder + Vector3::new(*x, y * side, *z) * limb.length_m;
            let X_WC = Isometry3::from_parts(p.into(), UnitQuaternion::identity());
            let reached = limb.starts(robot, q, STARTS).filter_map(|from| {
                let mut to = place(robot, limb, &tip, &X_WC, &from)?;
                mirror.copy(robot, &mut to, limb.joints());
                let body = |j: usize| &robot.joint_bodies()[j];
                let part =
                    |j: usize| (to.joints[j] - 0.0_f64.clamp(body(j).lower, body(j).upper)).powi(2);
                let strain: f64 = limb.joints().map(part).sum();
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
