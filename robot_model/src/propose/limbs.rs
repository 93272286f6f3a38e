//! The limbs of a robot: chains that branch off a trunk, legs and arms.

use nalgebra::Vector3;

use super::leg_reach::{Tip, deepest};
use super::limb::{Limb, LimbKind};
use super::mirror::Mirror;
use crate::{Kinematics, Robot};

/// A branch at least this long, of the longest, is a limb: heads, wheels and fingers are not.
const LONG: f64 = 0.35;
/// A limb that reaches at least this deep below the base, of the deepest, is a leg.
const DEEP: f64 = 0.6;

/// The limbs of a robot in its bodies' order.
pub fn limbs(robot: &Robot) -> Vec<Limb> {
    let n = robot.bodies.len();
    let mut children = vec![Vec::new(); n];
    for (i, body) in robot.bodies.iter().enumerate() {
        children[body.parent.unwrap_or(i)].extend(body.parent.map(|_| i));
    }
    // How far each body's branch goes on beyond its joint, from its own size inward.
    let mut beyond: Vec<f64> = (0..n).map(|body| size_m(robot, body)).collect();
    for i in (1..n).rev() {
        let parent = robot.bodies[i].parent.unwrap_or(0);
        let through = robot.bodies[i].X_PJ.translation.vector.norm() + beyond[i];
        beyond[parent] = beyond[parent].max(through);
    }
    let longest = (1..n).map(|i| beyond[i]).fold(0.0, f64::max);
    let long = |i: &usize| beyond[*i] >= LONG * longest;
    // The trunk: the base and what carries two limbs or more.
    let mut trunk = vec![false; n];
    for i in (0..n).rev() {
        let splits = children[i].iter().filter(|c| long(c)).count() > 1;
        trunk[i] = i == 0 || splits || children[i].iter().any(|&c| trunk[c]);
    }
    let starts = (1..n).filter(|&i| long(&i) && !trunk[i]);
    let starts = starts.filter(|&i| trunk[robot.bodies[i].parent.unwrap_or(0)]);
    let mut found: Vec<Limb> = starts
        .map(|start| {
            let mut bodies = vec![start];
            // A hand's fingers are several; of one that goes on alone the end is the last.
            while let [.., last] = bodies[..]
                && let [only] = children[last][..]
            {
                bodies.push(only);
            }
            Limb {
                kind: LimbKind::Arm,
                length_m: beyond[start],
                bodies,
                mirror: None,
                place: String::new(),
            }
        })
        .collect();
    pair(robot, &mut found);
    name(robot, &mut found);
    found
}

/// How far a body's shapes go from its joint, m.
fn size_m(robot: &Robot, body: usize) -> f64 {
    let shapes = robot.collision.shapes().iter().filter(|s| s.body == body);
    let far = shapes.map(|s| {
        let away = (s.X_BG.translation.vector).try_normalize(1e-9);
        let d = s.X_BG.rotation.inverse() * away.unwrap_or_else(Vector3::z);
        (s.X_BG * s.geometry.support(&d)).coords.norm()
    });
    far.fold(0.0, f64::max)
}

/// Finds each limb's other side, and the legs: pairs that come about as deep as the deepest.
fn pair(robot: &Robot, limbs: &mut [Limb]) {
    let mirror = Mirror::new(robot);
    let other = |limb: &Limb| mirror.of_body(limb.bodies[0]);
    for i in 0..limbs.len() {
        let twin =
            (0..limbs.len()).find(|&k| k != i && other(&limbs[i]) == Some(limbs[k].bodies[0]));
        limbs[i].mirror = twin.filter(|&k| limbs[k].bodies.len() == limbs[i].bodies.len());
    }
    let depth = |limb: &Limb| {
        let tip = Tip::of(robot, limb);
        deepest(robot, limb, &tip).1
    };
    let depths: Vec<f64> = limbs.iter().map(depth).collect();
    let paired = || {
        limbs
            .iter()
            .zip(&depths)
            .filter(|(l, _)| l.mirror.is_some())
    };
    let most = paired().map(|(_, d)| *d).fold(0.0, f64::max);
    for (limb, depth) in limbs.iter_mut().zip(depths) {
        if limb.mirror.is_some() && depth > 0.0 && depth >= DEEP * most {
            limb.kind = LimbKind::Leg;
        }
    }
}

/// Names limbs by side, and legs and arms of several pairs by their order from front to rear.
fn name(robot: &Robot, limbs: &mut [Limb]) {
    let kinematics = Kinematics::new(robot, &robot.neutral());
    let at: Vec<Vector3<f64>> = limbs
        .iter()
        .map(|l| kinematics.origin_W[l.bodies[0]])
        .collect();
    for i in 0..limbs.len() {
        let side = match limbs[i].mirror {
            None => "middle",
            Some(k) if at[i].y > at[k].y => "left",
            Some(_) => "right",
        };
        let same = |k: &usize| {
            let on_side = limbs[*k]
                .mirror
                .is_some_and(|m| (at[*k].y > at[m].y) == (side == "left"));
            limbs[*k].kind == limbs[i].kind && on_side
        };
        let row: Vec<usize> = (0..limbs.len()).filter(same).collect();
        let ahead = row.iter().filter(|&&k| at[k].x > at[i].x + 1e-6).count();
        let along = match (row.len(), ahead) {
            (..=1, _) => String::new(),
            (_, 0) => "front_".to_owned(),
            (n, k) if k + 1 == n => "rear_".to_owned(),
            (3, _) => "middle_".to_owned(),
            (_, k) => format!("row{}_", k + 1),
        };
        limbs[i].place = format!("{along}{side}");
    }
}
