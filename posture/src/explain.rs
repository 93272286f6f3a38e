//! Why a contact set has no posture: the smallest group of constraints that cannot hold together,
//! and for each of them how far it alone would have to give way.
//!
//! A deletion filter [chinneck2008] over groups of constraints: a group without which the rest
//! still has no posture is left out for good; what stays is irreducible. Then each group is eased
//! on its own, the others kept, by bisection to the least that lets a posture through.

use std::fmt::Write;

use crate::iterate::{Context, Relaxed};
use crate::outcome::Constraint;
use crate::problem::Problem;
use crate::{Config, Error, proof};
use relaxation::{Ease, eased, relax};

mod relaxation;

/// A group of constraints that stands or falls as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Parts of the robot keep apart.
    SelfClearance,
    /// The robot keeps away from the environment.
    Clearance,
    /// Joints hold the posture.
    Torques,
    /// Joints stay inside their limits.
    JointLimits,
    /// Contacts do not slip.
    Friction,
    /// The base is at the goal.
    Goal,
    /// A contact is at its place, inside its surface (contact index).
    Place(usize),
    /// Forces and moments balance the weight.
    Equilibrium,
}

/// How far one group would have to give way for the others to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// The group.
    pub group: Group,
    /// By how much: rad (m where prismatic) for joint limits, m for clearances and places, the
    /// coefficient that is needed for friction, the use of the limits that is needed for torques.
    pub amount: f64,
    /// In words.
    pub words: String,
}

/// Why there is no posture.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The groups that cannot hold together; any one less, and they can.
    pub conflict: Vec<Group>,
    /// What would be enough, one group at a time, where one alone is.
    pub relaxations: Vec<Relaxation>,
    /// All of it in a sentence.
    pub words: String,
}

/// A coefficient of friction higher than any sole has on any floor.
pub(super) const ANY_FRICTION: f64 = 3.0;

/// Joints that would have to turn farther than this beyond their limits are no way out, rad.
const TURN_MAX_RAD: f64 = 0.5;

/// The reason why a problem has no posture; nothing where it has one.
///
/// # Errors
/// As [`crate::solve`].
pub fn explain(problem: &Problem, config: &Config) -> Result<Option<Explanation>, Error> {
    config.validate()?;
    problem.validate()?;
    let holds = |kept: &[Group]| -> Result<bool, Error> {
        let ease = |g| match kept.contains(&g) {
            true => Ease::Kept,
            false => Ease::Gone,
        };
        Ok(eased(problem, config, ease)?.is_some())
    };
    let mut kept = groups(problem);
    if holds(&kept)? {
        return Ok(None);
    }
    // A proved conflict needs no trials.
    if let Some(proven) = unbalanced(problem, config) {
        kept = proven;
    } else {
        for group in kept.clone() {
            let without: Vec<Group> = kept.iter().copied().filter(|g| *g != group).collect();
            if !holds(&without)? {
                kept = without;
            }
        }
    }
    let mut relaxations = Vec::new();
    for &group in &kept {
        relaxations.extend(relax(problem, config, group)?);
    }
    let words = describe(problem, &kept, &relaxations);
    Ok(Some(Explanation {
        conflict: kept,
        relaxations,
        words,
    }))
}

/// Of a problem that has no posture the first kind of limit that alone is too tight, and what it would have to be: torques,
/// clearances, joint limits, friction; nothing where it takes more than one. Places, the goal and equilibrium stay as they are.
///
/// # Errors
/// As [`crate::solve`].
pub fn remedy(problem: &Problem, config: &Config) -> Result<Option<Relaxation>, Error> {
    config.validate()?;
    problem.validate()?;
    let limits = [
        Group::Torques,
        Group::Clearance,
        Group::SelfClearance,
        Group::JointLimits,
        Group::Friction,
    ];
    for group in limits {
        let relaxation = relax(problem, config, group)?;
        let is_of_use = |r: &Relaxation| group != Group::JointLimits || r.amount < TURN_MAX_RAD;
        if let Some(relaxation) = relaxation.filter(is_of_use) {
            return Ok(Some(relaxation));
        }
    }
    Ok(None)
}

/// Whether no posture at all can balance the contacts.
fn proven(problem: &Problem, config: &Config) -> bool {
    let violation = proof::infeasible(&Context::new(problem, config, Relaxed::default()));
    matches!(
        violation.map(|v| v.constraint),
        Some(Constraint::Equilibrium | Constraint::Balance)
    )
}

/// The conflict where fixed contacts cannot hold the weight: with friction, where more of it
/// would do.
fn unbalanced(problem: &Problem, config: &Config) -> Option<Vec<Group>> {
    if !proven(problem, config) {
        return None;
    }
    let mut rough = Problem {
        contacts: problem.contacts.clone(),
        base_goal: None,
        ..*problem
    };
    for contact in &mut rough.contacts {
        contact.friction = ANY_FRICTION;
    }
    let mut conflict = Vec::new();
    if !proven(&rough, config) {
        conflict.push(Group::Friction);
    }
    let loaded = |i: &usize| problem.contacts[*i].loaded;
    conflict.extend((0..problem.contacts.len()).filter(loaded).map(Group::Place));
    conflict.push(Group::Equilibrium);
    Some(conflict)
}

/// The groups of a problem, in the order in which a user would give them up.
fn groups(problem: &Problem) -> Vec<Group> {
    let mut groups = vec![
        Group::SelfClearance,
        Group::Clearance,
        Group::Torques,
        Group::JointLimits,
        Group::Friction,
    ];
    if problem.base_goal.is_some() {
        groups.push(Group::Goal);
    }
    groups.extend((0..problem.contacts.len()).map(Group::Place));
    groups.push(Group::Equilibrium);
    groups
}

/// The conflict and the ways out of it in a sentence.
fn describe(problem: &Problem, conflict: &[Group], relaxations: &[Relaxation]) -> String {
    let name = |group: &Group| match group {
        Group::SelfClearance => "parts of the robot apart".to_owned(),
        Group::Clearance => "clear of the environment".to_owned(),
        Group::Torques => "torque limits".to_owned(),
        Group::JointLimits => "joint limits".to_owned(),
        Group::Friction => "friction".to_owned(),
        Group::Goal => "the goal".to_owned(),
        Group::Equilibrium => "equilibrium".to_owned(),
        Group::Place(i) => {
            let contact = &problem.contacts[*i];
            let words = contact.describe(problem.robot, problem.environment);
            match contact.face {
                Some(_) => words,
                None => format!("{words} at its place"),
            }
        }
    };
    let names: Vec<String> = conflict.iter().map(name).collect();
    let mut words = format!("cannot hold together: {}", names.join(", "));
    for (i, relaxation) in relaxations.iter().enumerate() {
        let link = if i == 0 { "; it would take " } else { ", or " };
        // Writing to a string does not fail.
        let _ = write!(words, "{link}{}", relaxation.words);
    }
    words
}
