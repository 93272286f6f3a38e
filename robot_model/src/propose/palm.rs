//! The side of a hand that ends neither flat nor as a ball: the palm or its back, fingers held out of the way.

use nalgebra::{Isometry3, Vector3};

use super::flat::{Flat, doubled_area, foremost_m, sides};
use super::limb::Limb;
use crate::collision::Shape;
use crate::{Kinematics, Robot};

/// Shapes placed in W.
type Placed<'a> = Vec<(Isometry3<f64>, &'a Shape)>;
/// Where the joints of a finger's bodies are held, and the robot there.
type Way = (Vec<(usize, f64)>, Kinematics);

/// A finger may stand out of a face by this, m: less than what counts as in its plane.
const OUT_M: f64 = 0.001;
/// How far behind a face the rest of the arm must come to be, m: the links that carry the hand, and all others. Nearer than
/// this to what is touched no posture has them.
const BEHIND_M: [f64; 2] = [0.005, 0.02];
/// Postures of the arm that are drawn to find that out.
const DRAWN: u64 = 200;
/// Of two sides about as large the one that looks ahead and down is taken: by how much larger the other must be.
const LARGER: f64 = 0.05;

/// The direction from a body's origin to what is farthest of its shapes about `along`: a wrist may be bent where its joints
/// are neutral.
pub(super) fn pointing(
    shapes: &[(Isometry3<f64>, &Shape)],
    from: &Vector3<f64>,
    mut along: Vector3<f64>,
) -> Option<Vector3<f64>> {
    for _ in 0..4 {
        let far = |(X_WG, shape): &(Isometry3<f64>, &Shape)| {
            (X_WG * shape.geometry.support(&(X_WG.rotation.inverse() * along))).coords - from
        };
        let far = shapes.iter().map(far);
        let far = far.max_by(|a, b| a.dot(&along).total_cmp(&b.dot(&along)))?;
        along = far.try_normalize(1e-6)?;
    }
    Some(along)
}

/// By how much farther than it must be all of the arm but its hand can be held behind the plane of a face of the palm, m,
/// and the link that is in the way.
///
/// A wrist as thick as the hand is flush with its back, however it is bent.
pub(super) fn spare_m<'a>(
    robot: &'a Robot,
    limb: &Limb,
    palm: usize,
    X_BC: &Isometry3<f64>,
) -> (f64, &'a str) {
    let shapes = robot.collision.shapes().iter();
    let rest = shapes.filter(|s| limb.bodies.contains(&s.body) && s.body < palm);
    let rest: Vec<&Shape> = rest.collect();
    let spare_m = |q: crate::Configuration| {
        let kinematics = Kinematics::new(robot, &q);
        let X_WC = kinematics.X_WB[palm] * X_BC;
        let n = X_WC.rotation * -Vector3::z();
        let spare = rest.iter().map(|shape| {
            let placed = vec![(kinematics.X_WB[shape.body] * shape.X_BG, *shape)];
            let behind_m = X_WC.translation.vector.dot(&n) - foremost_m(&placed, &n);
            let [near_m, far_m] = BEHIND_M;
            let must_m = if robot.are_close(palm, shape.body) {
                near_m
            } else {
                far_m
            };
            (behind_m - must_m, shape.link.as_str())
        });
        spare
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, ""))
    };
    let neutral = robot.neutral();
    let drawn = limb.starts(robot, &neutral, DRAWN).map(spare_m);
    drawn
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((f64::NEG_INFINITY, ""))
}

/// The largest flat side of the palm that fingers do not stand out of where they are held, and where that is, rad or m.
///
/// `fingers`: the bodies beyond the palm. Each branch of them is as in `kinematics`, all its joints at their lower or all at
/// their upper limits, whichever stands out of the face the least.
pub(super) fn side(
    robot: &Robot,
    kinematics: &Kinematics,
    (shapes, along): (&Placed, &Vector3<f64>),
    fingers: &[usize],
    is_usable: &dyn Fn(&Flat) -> bool,
) -> Option<(Flat, Vec<(String, f64)>)> {
    // 1. The ways to hold each finger.
    let neutral = robot.neutral();
    let roots = fingers.iter().filter(|&&f| {
        let parent = robot.bodies[f].parent;
        parent.is_none_or(|p| !fingers.contains(&p))
    });
    let poses = roots.map(|&root| {
        let branch: Vec<usize> = robot.subtree(root).collect();
        let at = |value: &dyn Fn(usize) -> f64| {
            let mut q = neutral.clone();
            for &b in &branch {
                q.joints[b - 1] = value(b);
            }
            let held = branch.iter().map(|&b| (b, q.joints[b - 1])).collect();
            (held, Kinematics::new(robot, &q))
        };
        let bodies = &robot.bodies;
        let ways = [
            at(&|b| neutral.joints[b - 1]),
            at(&|b| bodies[b].lower),
            at(&|b| bodies[b].upper),
        ];
        (branch.clone(), ways)
    });
    let poses: Vec<(Vec<usize>, [Way; 3])> = poses.collect();
    // 2. The faces that no finger stands out of.
    let out_m = |face: &Flat, branch: &[usize], kinematics: &Kinematics| {
        let n = face.X_BC.rotation * -Vector3::z();
        let of = robot.collision.shapes().iter();
        let of = of.filter(|s| branch.contains(&s.body));
        let placed: Placed = of.map(|s| (kinematics.X_WB[s.body] * s.X_BG, s)).collect();
        foremost_m(&placed, &n) - face.X_BC.translation.vector.dot(&n)
    };
    let held = |face: &Flat| {
        let mut held = Vec::new();
        for (branch, ways) in &poses {
            let out = |way: &Way| out_m(face, branch, &way.1);
            let least = ways.iter().min_by(|a, b| out(a).total_cmp(&out(b)))?;
            if out(least) > OUT_M {
                return None;
            }
            let named = |(b, value): &(usize, f64)| (robot.bodies[*b].joint.clone(), *value);
            held.extend(least.0.iter().map(named));
        }
        Some(held)
    };
    // 3. The largest.
    let worth = |face: &Flat| {
        let n_B = kinematics.X_WB[0].rotation.inverse() * (face.X_BC.rotation * -Vector3::z());
        doubled_area(&face.polygon) * (1.0 + LARGER * (n_B.x - n_B.z))
    };
    let faces = sides(shapes, along);
    let free = faces.into_iter().filter(|face| is_usable(face));
    let free = free.filter_map(|face| held(&face).map(|held| (face, held)));
    free.max_by(|a, b| worth(&a.0).total_cmp(&worth(&b.0)))
}
