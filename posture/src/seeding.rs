//! Seeds of the search: the guess, the guess with limbs seeded anew, the reference.
//!
//! A limb that is far from its place may lie in the wrong fold of its joints for any descent to
//! bring it there. Seeding it anew draws joint values of the limb alone (the joints between its
//! patch and the first body that carries something else) and keeps the best of them.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robot_model::{Configuration, Kinematics};

use crate::contact::Freedom;
use crate::iterate::Context;

/// Joint values that are drawn for a far limb of the guess.
const DRAWN_FIRST: usize = 100;
/// Joint values that are drawn for every limb in later attempts.
const DRAWN_LATER: usize = 60;
/// How far later attempts turn the base about x, y and z, rad.
const TURN_RAD: [f64; 3] = [0.2, 0.3, 0.6];
/// How far later attempts move the base along x, y and z, m.
const MOVE_M: [f64; 3] = [0.1, 0.1, 0.1];
/// The part of that, and of half the joints' ranges, by which what goes on from an attempt is shaken.
const SHAKEN: f64 = 0.5;
/// Lever arm that weighs a wrong direction against a wrong place, m/rad.
const ARM_M: f64 = 0.3;
/// A limb that is nearer to its place than this stays as it is, m (directions times [`ARM_M`]).
const NEAR_M: f64 = 0.25;

/// The `k`-th seed: the guess; the guess with its far limbs seeded anew; then, in turns, the
/// reference and the guess, turned and moved and with every limb seeded anew.
pub(crate) fn seed(ctx: &Context, k: usize) -> Configuration {
    let problem = ctx.problem;
    match k {
        0 => problem.guess.clone(),
        1 => limbs_anew(ctx, problem.guess, &mut Random(1), DRAWN_FIRST, NEAR_M)
            .unwrap_or_else(|| problem.reference.clone()),
        _ => {
            let mut random = Random(k as u64);
            let mut from = if k.is_multiple_of(2) {
                problem.reference.clone()
            } else {
                problem.guess.clone()
            };
            move_base(&mut from, 1.0, &mut random);
            limbs_anew(ctx, &from, &mut random, DRAWN_LATER, 0.0).unwrap_or(from)
        }
    }
}

/// The `k`-th configuration about one.
pub(crate) fn shaken(ctx: &Context, near: &Configuration, k: usize) -> Configuration {
    let (mut random, mut q) = (Random(k as u64), near.clone());
    move_base(&mut q, SHAKEN, &mut random);
    for (i, _) in ctx.layout.joints() {
        let (lower, upper) = ctx.joint_bounds(i);
        q.joints[i - 1] += 0.5 * SHAKEN * (upper - lower) * random.between(-1.0, 1.0);
    }
    q
}

/// Turns and moves the base by up to a part of [`TURN_RAD`] and [`MOVE_M`].
fn move_base(q: &mut Configuration, part: f64, random: &mut Random) {
    let turn = Vector3::from_fn(|i, _| part * TURN_RAD[i] * random.between(-1.0, 1.0));
    q.R_WB = UnitQuaternion::from_scaled_axis(turn) * q.R_WB;
    q.p_WB += Vector3::from_fn(|i, _| part * MOVE_M[i] * random.between(-1.0, 1.0));
}

/// The configuration with every limb that is farther from its place than `near_m` at the best of
/// `drawn` draws of its joint values; nothing where no limb is.
fn limbs_anew(
    ctx: &Context,
    from: &Configuration,
    random: &mut Random,
    drawn: usize,
    near_m: f64,
) -> Option<Configuration> {
    let robot = ctx.robot();
    let kinematics = Kinematics::new(robot, from);
    let mut anew: Option<Configuration> = None;
    for (contact, (of, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        let X_BC = &robot.patches[of.patch].X_BC;
        let is = error_m(ctx, contact, &(kinematics.X_WB[model.body] * X_BC));
        if is < near_m {
            continue;
        }
        let limb = limb(ctx, model.body);
        let Some(&first) = limb.first() else { continue };
        let Some(root) = robot.bodies[first].parent else {
            continue;
        };
        let mut best = (is, Vec::new());
        for _ in 0..drawn {
            let mut X = kinematics.X_WB[root];
            let mut joints = Vec::with_capacity(limb.len());
            for &body in &limb {
                let (lower, upper) = ctx.joint_bounds(body);
                let q = random.between(lower, upper);
                joints.push(q);
                X *= robot.bodies[body].placed_at(q);
            }
            let error = error_m(ctx, contact, &(X * X_BC));
            if error < best.0 {
                best = (error, joints);
            }
        }
        let anew = anew.get_or_insert_with(|| from.clone());
        for (&body, q) in limb.iter().zip(best.1) {
            anew.joints[body - 1] = q;
        }
    }
    anew
}

/// Bodies from the first that carries nothing but this patch to the patch's own.
fn limb(ctx: &Context, body: usize) -> Vec<usize> {
    let robot = ctx.robot();
    let others = |b: usize| {
        let within = robot.subtree(b);
        robot
            .patches
            .iter()
            .any(|p| p.body != body && within.contains(&p.body))
    };
    let mut limb = Vec::new();
    let mut b = body;
    while let Some(parent) = robot.bodies[b].parent {
        if others(b) {
            break;
        }
        limb.push(b);
        b = parent;
    }
    limb.reverse();
    limb
}

/// How far a patch is from its place, m; directions times [`ARM_M`].
fn error_m(ctx: &Context, contact: usize, X_WC: &Isometry3<f64>) -> f64 {
    let z_C = X_WC.rotation * Vector3::z();
    // How a ball is turned does not matter.
    let radius = ctx.contacts[contact].radius;
    let asked = &ctx.problem.contacts[contact];
    let normal = asked.normal_W();
    let apart = match asked.area() {
        None => (X_WC.translation.vector - asked.X_WC.translation.vector).norm(),
        Some(area) => {
            let p_W = X_WC.translation.vector - radius.unwrap_or(0.0) * normal;
            let (beside, over) = area.distances_m(&p_W);
            // The wanted place decides between joint values that reach the face equally well.
            let off = area.toward.map_or(0.0, |t| (p_W - t.coords).norm());
            beside.hypot(over) + 0.1 * off
        }
    };
    let turned = match &asked.freedom {
        _ if radius.is_some() => 0.0,
        Freedom::Fixed => X_WC.rotation.angle_to(&asked.X_WC.rotation),
        _ => z_C.angle(&normal),
    };
    apart + ARM_M * turned
}

/// SplitMix64 from a seed.
pub(crate) struct Random(pub u64);

impl Random {
    /// A number between two.
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    /// A number from 0 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 53) as f64
    }
}
