//! SRDF: named postures, and pairs of links that never collide or always do.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use roxmltree::Node;

use super::Findings;
use crate::xml::{Source, children};
use crate::{Error, NamedPosture, Robot};

/// Adds an SRDF's postures to a robot and disables its pairs of links.
///
/// States of one name (a group each) make one posture; joints that none of them names stay at
/// the neutral value. A joint that is absent or has several values is noted; the seven values
/// [x y z qx qy qz qw] of a root joint become the posture's base pose.
///
/// # Errors
/// [`Error::File`] for what is no SRDF. States and pairs that make no sense and links that are not there, unless
/// `findings` is lenient, are refused with all else.
pub(super) fn apply(
    file: &str,
    text: &str,
    robot: &mut Robot,
    findings: &mut Findings,
) -> Result<(), Error> {
    let source = Source::parse(file, text)?;
    let root = source.robot()?;
    for state in children(root, "group_state") {
        let read = posture(&source, state, robot, findings);
        findings.kept(read);
    }
    // Pairs to disable, in either order.
    let mut disabled = BTreeSet::new();
    for pair in children(root, "disable_collisions") {
        let links = source
            .text(pair, "link1")
            .and_then(|a| Ok((a, source.text(pair, "link2")?)));
        let Some((a, b)) = findings.kept(links) else {
            continue;
        };
        let mut known = true;
        for link in [a, b] {
            if robot.frames.iter().all(|f| f.name != link) {
                known = false;
                let place = format!("{file}: line {}", source.line(pair));
                let links = robot.frames.iter().map(|f| f.name.as_str());
                let error = Error::unknown(Some(&place), "link", link, links);
                findings.refuse_unless_lenient(error);
            }
        }
        if known {
            disabled.insert((a.to_owned(), b.to_owned()));
        }
    }
    let is_disabled = |a: &str, b: &str| disabled.contains(&(a.to_owned(), b.to_owned()));
    robot.collision.disable(is_disabled);
    // Tags that look like a slip of the pen would otherwise pass in silence.
    for element in root.children().filter(Node::is_element) {
        let tag = element.tag_name().name();
        if !KNOWN_TAGS.contains(&tag) {
            findings.note(format!("{file}: <{tag}> is not understood and left aside"));
        }
    }
    Ok(())
}

/// What an SRDF may hold; only states and pairs matter here.
const KNOWN_TAGS: [&str; 15] = [
    "group_state",
    "disable_collisions",
    "group",
    "end_effector",
    "virtual_joint",
    "passive_joint",
    "link_sphere_approximation",
    "disable_default_collisions",
    "enable_collisions",
    "joint_property",
    "rotor_params",
    "gripper",
    "handle",
    "contact",
    "specificities",
];

fn posture(
    source: &Source,
    state: Node,
    robot: &mut Robot,
    findings: &mut Findings,
) -> Result<(), Error> {
    let name = source.text(state, "name")?.to_owned();
    let neutral = || NamedPosture {
        joints: robot.neutral().joints.as_slice().to_vec(),
        is_stated: vec![false; robot.nj()],
        base: None,
    };
    let known = robot.postures.get(&name).cloned();
    let mut posture = known.unwrap_or_else(neutral);
    let (mut absent, mut outside) = (Vec::new(), Vec::new());
    for node in children(state, "joint") {
        let joint = source.text(node, "name")?;
        let number = |word: &str| word.parse::<f64>().ok().filter(|value| value.is_finite());
        let words = source.text(node, "value")?.split_whitespace();
        let values: Option<Vec<f64>> = words.map(number).collect();
        let no_number = || source.refuse(node, format!("joint \"{joint}\": not a number"));
        let values = values.ok_or_else(no_number)?;
        let place = robot.joint_names().position(|n| n == joint);
        match (place, values.as_slice()) {
            (Some(at), [value]) => {
                let body = &robot.bodies[at + 1];
                if *value < body.lower || *value > body.upper {
                    outside.push(joint.to_owned());
                }
                posture.joints[at] = *value;
                posture.is_stated[at] = true;
            }
            (None, &[x, y, z, i, j, k, w]) => {
                let rotation = Quaternion::new(w, i, j, k);
                if let Some(rotation) = UnitQuaternion::try_new(rotation, 1e-3) {
                    let place = Translation3::new(x, y, z);
                    posture.base = Some(Isometry3::from_parts(place, rotation));
                }
            }
            (Some(_), values) => {
                let has = format!("joint \"{joint}\" has {} values", values.len());
                findings.note(format!("posture \"{name}\": {has}; left at neutral"));
            }
            (None, _) => absent.push(joint.to_owned()),
        }
    }
    if !absent.is_empty() {
        let what = format!("names joints that the robot lacks: {}", absent.join(", "));
        findings.note(format!("posture \"{name}\" {what}"));
    }
    if !outside.is_empty() {
        let what = format!("is outside the limits of {}", outside.join(", "));
        findings.note(format!("posture \"{name}\" {what}"));
    }
    robot.postures.insert(name, posture);
    Ok(())
}
