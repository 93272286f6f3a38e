//! Where the SQP starts: the guess, the guess with limbs laid out anew, the reference.
//!
//! A limb that is far from its place may lie in the wrong fold of its joints for any descent to
//! bring it there. Laying it out anew draws joint values of the limb alone (the joints between its
//! patch and the first body that carries something else) and keeps the best of them.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use robot_model::{Configuration, JointKind, Kinematics, Robot};

use crate::iterate::Context;
use crate::problem::Place;

/// Layouts that are drawn for a limb.
const DRAWN: usize = 100;
/// Layouts that are drawn for a limb in later attempts.
const FEWER: usize = 60;
/// How far later attempts turn the base about x, y and z, rad.
const TURN_RAD: [f64; 3] = [0.2, 0.3, 0.6];
/// How far later attempts move the base along x, y and z, m.
const MOVE_M: [f64; 3] = [0.1, 0.1, 0.1];
/// Lever arm that weighs a wrong direction against a wrong place, m/rad.
const ARM_M: f64 = 0.3;
/// A limb that is nearer to its place than this stays as it is, m (directions times [`ARM_M`]).
const NEAR_M: f64 = 0.25;

/// The start of the `k`-th attempt: the guess; the guess with its far limbs laid out anew; the
/// reference; then the guess turned and with every limb laid out anew, another draw each time.
pub(crate) fn start(ctx: &Context, k: usize) -> Configuration {
    let problem = ctx.problem;
    match k {
        0 => problem.guess.clone(),
        1 => laid_out_anew(ctx, problem.guess, &mut Random(1), DRAWN, NEAR_M)
            .unwrap_or_else(|| problem.reference.clone()),
        _ => {
            let mut random = Random(k as u64);
            let mut from = if k.is_multiple_of(2) {
                problem.reference.clone()
            } else {
                problem.guess.clone()
            };
            let turn = Vector3::from_fn(|i, _| TURN_RAD[i] * random.between(-1.0, 1.0));
            from.R_WB = UnitQuaternion::from_scaled_axis(turn) * from.R_WB;
            from.p_WB += Vector3::from_fn(|i, _| MOVE_M[i] * random.between(-1.0, 1.0));
            laid_out_anew(ctx, &from, &mut random, FEWER, 0.0).unwrap_or(from)
        }
    }
}

/// The configuration with every limb that is farther from its place than `near_m` in the best of
/// `drawn` layouts; nothing where no limb is.
#[allow(non_snake_case)]
fn laid_out_anew(
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
                X *= motion(robot, body, q);
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

/// Pose of a body in its parent at a joint value.
#[allow(non_snake_case)]
fn motion(robot: &Robot, body: usize, q: f64) -> Isometry3<f64> {
    let b = &robot.bodies[body];
    let moved = match b.kind {
        JointKind::Prismatic => {
            Isometry3::from_parts((b.axis * q).into(), UnitQuaternion::identity())
        }
        _ => Isometry3::rotation(b.axis * q),
    };
    b.X_PJ * moved
}

/// How far a patch is from its place, m; directions times [`ARM_M`].
#[allow(non_snake_case)]
fn error_m(ctx: &Context, contact: usize, X_WC: &Isometry3<f64>) -> f64 {
    let z_C = X_WC.rotation * Vector3::z();
    // How a ball is turned does not matter.
    let radius = ctx.contacts[contact].radius;
    match &ctx.problem.contacts[contact].place {
        Place::Fixed {
            X_WC: wanted,
            yaw_free,
            ..
        } => {
            let apart = (X_WC.translation.vector - wanted.translation.vector).norm();
            let turned = if radius.is_some() {
                0.0
            } else if *yaw_free {
                z_C.angle(&(wanted.rotation * Vector3::z()))
            } else {
                X_WC.rotation.angle_to(&wanted.rotation)
            };
            apart + ARM_M * turned
        }
        Place::OnSurface {
            surface, toward, ..
        } => {
            let surface_ = &ctx.problem.environment.surfaces[*surface];
            let normal = surface_.normal_W();
            let p_W = X_WC.translation.vector - radius.unwrap_or(0.0) * normal;
            let p_S = surface_.X_WS.inverse_transform_point(&Point3::from(p_W));
            let outside = ctx.problem.environment.effective[*surface]
                .as_ref()
                .map_or(0.0, |polygon| polygon.signed_distance(&p_S.xy()).max(0.0));
            let apart = outside.hypot(p_S.z);
            // The wanted place decides between layouts that reach the surface equally well.
            let beside = toward.map_or(0.0, |toward| (p_W - toward.coords).norm());
            let turned = match radius {
                Some(_) => 0.0,
                None => z_C.angle(&normal),
            };
            apart + ARM_M * turned + 0.1 * beside
        }
    }
}

/// SplitMix64 from a seed.
struct Random(u64);

impl Random {
    /// A number between two.
    fn between(&mut self, lower: f64, upper: f64) -> f64 {
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
