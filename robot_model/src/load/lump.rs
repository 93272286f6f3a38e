//! A tree of links → moving bodies, frames and limits: fixed links lumped, mimics locked.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use urdf_rs::JointType;

use super::Findings;
use super::inertia::{self, Lump};
use super::tree::Tree;
use super::urdf::{Urdf, pose};
use crate::{Body, Error, Frame, GREATEST_M, JointKind};

/// Most bodies of a robot: matrices have the square of it as entries.
const BODIES_MAX: usize = 500;

/// The bodies, and for every link (by its index) the body it is part of and its pose there.
pub(super) struct Lumped {
    pub bodies: Vec<Body>,
    pub frames: Vec<Frame>,
    pub places: Vec<Option<(usize, Isometry3<f64>)>>,
}

/// Lumps links on fixed and locked joints into the bodies that move; joints of `held` are locked at their values, rad or m.
///
/// # Errors
/// Too many bodies. A joint of `held` that is not there or does not come there, limits or an axis that make no sense, a floating joint anywhere but under a dummy root, and what
/// [`inertia::check`] says are refused with all else.
pub(super) fn lump(
    file: &str,
    urdf: &Urdf,
    tree: &Tree,
    held: &BTreeMap<String, f64>,
    findings: &mut Findings,
) -> Result<Lumped, Error> {
    for name in held.keys() {
        let joints = urdf.robot.joints.iter().map(|j| j.name.as_str());
        if joints.clone().all(|joint| joint != name) {
            let place = Some("held joints of the contacts file");
            findings
                .refused
                .push(Error::unknown(place, "joint", name, joints));
        }
    }
    let links = &urdf.robot.links;
    let root = base_of(urdf, tree, findings);
    let mut bodies = vec![base_body(links[root].name.clone())];
    let mut lumps = vec![Lump::default()];
    let mut frames = Vec::new();
    let mut places = vec![None; links.len()];
    // Depth first, children in the file's order.
    let mut open = vec![(root, 0, Isometry3::identity(), None)];
    while let Some((link, body, X_BL, mover)) = open.pop() {
        // A link on a moving joint starts a body of its own.
        let (body, X_BL) = match mover {
            None => (body, X_BL),
            Some(moved) => {
                bodies.push(Body {
                    name: links[link].name.clone(),
                    parent: Some(body),
                    X_PJ: X_BL,
                    ..moved
                });
                lumps.push(Lump::default());
                (bodies.len() - 1, Isometry3::identity())
            }
        };
        let added = lumps[body].add(file, &links[link], &X_BL);
        findings.kept(added);
        frames.push(Frame {
            name: links[link].name.clone(),
            body,
            X_BL,
        });
        places[link] = Some((body, X_BL));
        let first = open.len();
        for &(j, child) in &tree.children[link] {
            let joint = &urdf.robot.joints[j];
            let X_BJ = X_BL * pose(&joint.origin);
            let motion = motion_of(file, urdf, j, findings);
            let motion = motion.and_then(|motion| hold(motion, held, findings));
            open.push(match findings.kept(motion) {
                // What hangs on a joint that is refused is looked at, too.
                None => (child, body, X_BJ, None),
                Some(Motion::Locked(X_JL)) => (child, body, X_BJ * X_JL, None),
                Some(Motion::Moves(moved)) => (child, body, X_BJ, Some(*moved)),
            });
        }
        open[first..].reverse();
    }
    if bodies.len() > BODIES_MAX {
        let cause = format!(
            "{} links move, at most {BODIES_MAX} are planned for",
            bodies.len()
        );
        return Err(Error::file(file, cause));
    }
    for (body, lump) in bodies.iter_mut().zip(&lumps) {
        (body.mass_kg, body.com_B, body.inertia_B) = lump.total();
    }
    inertia::check(file, &bodies, findings);
    Ok(Lumped {
        bodies,
        frames,
        places,
    })
}

/// The link that floats: the root, or what hangs on a dummy root by a floating joint.
fn base_of(urdf: &Urdf, tree: &Tree, findings: &mut Findings) -> usize {
    let (links, joints) = (&urdf.robot.links, &urdf.robot.joints);
    let root = &links[tree.root];
    let is_dummy = root.collision.is_empty() && root.inertial.mass.value == 0.0;
    match tree.children[tree.root].as_slice() {
        [(j, child)] if is_dummy && joints[*j].joint_type == JointType::Floating => {
            let (name, base) = (&root.name, &links[*child].name);
            let what = format!("link \"{base}\" floats; the dummy root \"{name}\" is dropped");
            findings.note(what);
            *child
        }
        _ => tree.root,
    }
}

/// How a joint moves its child.
enum Motion {
    /// Not at all: the child's pose in the joint's frame.
    Locked(Isometry3<f64>),
    /// As this body does, wherever it hangs.
    Moves(Box<Body>),
}

fn motion_of(file: &str, urdf: &Urdf, j: usize, findings: &mut Findings) -> Result<Motion, Error> {
    let (joint, line) = (&urdf.robot.joints[j], urdf.joint_lines[j]);
    let name = joint.name.as_str();
    let refuse = |cause: &str| {
        let cause = format!("line {line}: {cause}");
        Err(Error::part(file, "joint", name, cause))
    };
    if joint.joint_type == JointType::Fixed {
        return Ok(Motion::Locked(Isometry3::identity()));
    }
    if joint.joint_type == JointType::Floating {
        return refuse("a floating joint is supported under a dummy root link only");
    }
    let Some(axis) = UnitVector3::try_new(Vector3::from(*joint.axis.xyz), 1e-9) else {
        return refuse("its axis is zero");
    };
    let kind = match joint.joint_type {
        JointType::Prismatic => JointKind::Prismatic,
        _ => JointKind::Revolute,
    };
    // A mimic joint is no freedom of its own: it stays where it is while its leader is at zero.
    if let Some(mimic) = &joint.mimic {
        let offset = mimic.offset.unwrap_or(0.0);
        let leader = &mimic.joint;
        if !urdf.robot.joints.iter().any(|other| other.name == *leader) {
            // Locked all the same.
            findings.note(format!("joint \"{name}\" mimics no joint: \"{leader}\""));
        }
        let at = format!("\"{name}\" at {offset} (mimics \"{leader}\")");
        findings.list("mimic joints are locked", at);
        return Ok(Motion::Locked(moved(kind, &axis, offset)));
    }
    let (mut lower, mut upper) = (joint.limit.lower, joint.limit.upper);
    if joint.joint_type == JointType::Continuous {
        (lower, upper) = (f64::NEG_INFINITY, f64::INFINITY);
    }
    // A URDF of version 1.2 may leave out either limit of any joint.
    // Others write a great number in its place.
    if lower.abs().max(upper.abs()) > GREATEST_M {
        if kind == JointKind::Prismatic {
            return refuse("it slides without limit");
        }
        findings.list("continuous joints are limited to ±2π rad", name);
        (lower, upper) = (lower.max(-TAU), upper.min(TAU));
    }
    if lower > upper {
        let cause = format!("its lower limit {lower} is above its upper limit {upper}");
        return refuse(&cause);
    }
    if lower == upper {
        let at = format!("\"{name}\" at {lower}");
        findings.list("joints without a range are locked", at);
        return Ok(Motion::Locked(moved(kind, &axis, lower)));
    }
    // No motor has no torque or speed: zero stands for a limit that is not stated.
    let stated = |value: f64| if value == 0.0 { f64::INFINITY } else { value };
    let effort = stated(joint.limit.effort);
    let velocity = stated(joint.limit.velocity);
    if effort < 0.0 || velocity < 0.0 {
        return refuse("its effort or velocity limit is negative");
    }
    if effort.is_infinite() {
        findings.list("no effort limit is stated, none is used", name);
    }
    if velocity.is_infinite() {
        findings.list("no velocity limit is stated, none is used", name);
    }
    Ok(Motion::Moves(Box::new(Body {
        joint: name.to_owned(),
        kind,
        axis: axis.into_inner(),
        lower,
        upper,
        effort,
        velocity,
        ..base_body(String::new())
    })))
}

/// A joint's motion, locked where it is held.
fn hold(
    motion: Motion,
    held: &BTreeMap<String, f64>,
    findings: &mut Findings,
) -> Result<Motion, Error> {
    let Motion::Moves(body) = &motion else {
        return Ok(motion);
    };
    let Some(&value) = held.get(&body.joint) else {
        return Ok(motion);
    };
    if !(body.lower..=body.upper).contains(&value) {
        let (name, lower, upper) = (&body.joint, body.lower, body.upper);
        let cause = format!("it cannot be held at {value}: it moves from {lower} to {upper}");
        return Err(Error::part("contacts", "joint", name, cause));
    }
    let at = format!("\"{}\" at {value}", body.joint);
    findings.list("joints are held where the contacts file has them", at);
    let axis = UnitVector3::new_normalize(body.axis);
    Ok(Motion::Locked(moved(body.kind, &axis, value)))
}

/// The pose that a joint value gives.
fn moved(kind: JointKind, axis: &UnitVector3<f64>, value: f64) -> Isometry3<f64> {
    match kind {
        JointKind::Prismatic => Translation3::from(axis.into_inner() * value).into(),
        _ => nalgebra::convert(UnitQuaternion::from_axis_angle(axis, value)),
    }
}

fn base_body(name: String) -> Body {
    Body {
        name,
        joint: String::new(),
        parent: None,
        X_PJ: Isometry3::identity(),
        kind: JointKind::Floating,
        axis: Vector3::zeros(),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        effort: 0.0,
        velocity: f64::INFINITY,
        mass_kg: 0.0,
        com_B: Vector3::zeros(),
        inertia_B: nalgebra::Matrix3::zeros(),
    }
}
