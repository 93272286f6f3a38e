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
const DRAWN: usize = 400;
/// Lever arm that weighs a wrong direction against a wrong place, m/rad.
const ARM_M: f64 = 0.3;
/// A limb that is nearer to its place than this stays as it is, m (directions times [`ARM_M`]).
const NEAR_M: f64 = 0.25;

/// The starts in the order in which they are tried.
pub(crate) fn starts(ctx: &Context) -> Vec<Configuration> {
    let problem = ctx.problem;
    let mut starts = vec![problem.guess.clone()];
    starts.extend(laid_out_anew(ctx, problem.guess));
    starts.push(problem.reference.clone());
    starts.truncate(1 + ctx.config.restarts);
    starts
}

/// The configuration with every limb that is far from its place in the best drawn layout; nothing
/// where no limb is.
#[allow(non_snake_case)]
fn laid_out_anew(ctx: &Context, from: &Configuration) -> Option<Configuration> {
    let robot = ctx.robot();
    let kinematics = Kinematics::new(robot, from);
    let mut anew: Option<Configuration> = None;
    for (contact, (of, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        let X_BC = &robot.patches[of.patch].X_BC;
        let is = error_m(ctx, contact, &(kinematics.X_WB[model.body] * X_BC));
        if is < NEAR_M {
            continue;
        }
        let limb = limb(ctx, model.body);
        let Some(&first) = limb.first() else { continue };
        let Some(root) = robot.bodies[first].parent else {
            continue;
        };
        let mut random = Random(0x5ca1_ab1e ^ of.patch as u64);
        let mut best = (is, Vec::new());
        for _ in 0..DRAWN {
            let mut X = kinematics.X_WB[root];
            let mut joints = Vec::with_capacity(limb.len());
            for &body in &limb {
                let (lower, upper) = ctx.joint_bounds(body);
                let q = lower + (upper - lower) * random.unit();
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
    match &ctx.problem.contacts[contact].place {
        Place::Fixed {
            X_WC: wanted,
            yaw_free,
            ..
        } => {
            let apart = (X_WC.translation.vector - wanted.translation.vector).norm();
            let turned = if *yaw_free {
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
            let p_S = surface_
                .X_WS
                .inverse_transform_point(&Point3::from(X_WC.translation.vector));
            let outside = ctx.problem.environment.effective[*surface]
                .as_ref()
                .map_or(0.0, |polygon| polygon.signed_distance(&p_S.xy()).max(0.0));
            let apart = outside.hypot(p_S.z);
            // The wanted place decides between layouts that reach the surface equally well.
            let beside = toward.map_or(0.0, |toward| {
                (X_WC.translation.vector - toward.coords).norm()
            });
            apart + ARM_M * z_C.angle(&surface_.normal_W()) + 0.1 * beside
        }
    }
}

/// SplitMix64 from a seed.
struct Random(u64);

impl Random {
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
