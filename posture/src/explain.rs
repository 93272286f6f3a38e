//! Why a contact set has no posture: the smallest group of constraints that cannot hold together,
//! and for each of them how far it alone would have to give way.
//!
//! A deletion filter [chinneck2008] over groups of constraints: a group without which the rest
//! still has no posture is left out for good; what stays is irreducible. Then each group is eased
//! on its own, the others kept, by bisection to the least that lets a posture through.

use std::fmt::Write;

use crate::iterate::{Context, Dropped};
use crate::outcome::{Constraint, Outcome, Posture};
use crate::problem::{Place, Problem};
use crate::solve::solve_without;
use crate::{Config, Error, proof};

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

/// Halvings of the amount by which a group is eased.
const HALVINGS: usize = 6;
/// The friction that counts as any: more than a pair of soles and floors has.
const ANY_FRICTION: f64 = 3.0;

/// The reason why a problem has no posture; nothing where it has one.
///
/// # Errors
/// As [`crate::solve`].
pub fn explain(problem: &Problem, config: &Config) -> Result<Option<Explanation>, Error> {
    config.validate()?;
    problem.validate()?;
    let holds = |kept: &[Group]| -> Result<bool, Error> {
        Ok(eased(problem, config, |g| {
            if kept.contains(&g) {
                Ease::Kept
            } else {
                Ease::Gone
            }
        })?
        .is_some())
    };
    let mut kept = groups(problem);
    if holds(&kept)? {
        return Ok(None);
    }
    // What is proven needs no trial.
    let proven = unbalanced(problem, config)?;
    let trials = if proven.is_some() {
        Vec::new()
    } else {
        kept.clone()
    };
    kept = proven.unwrap_or(kept);
    for group in trials {
        let without: Vec<Group> = kept.iter().copied().filter(|g| *g != group).collect();
        if !holds(&without)? {
            kept = without;
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

/// Whether no posture at all can balance the contacts.
fn proven(problem: &Problem, config: &Config) -> Result<bool, Error> {
    let violation = proof::infeasible(&Context::new(problem, config)?);
    Ok(matches!(
        violation.map(|v| v.constraint),
        Some(Constraint::Equilibrium | Constraint::Balance)
    ))
}

/// The conflict where fixed contacts cannot hold the weight: with friction, where more of it
/// would do.
fn unbalanced(problem: &Problem, config: &Config) -> Result<Option<Vec<Group>>, Error> {
    if !proven(problem, config)? {
        return Ok(None);
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
    if !proven(&rough, config)? {
        conflict.push(Group::Friction);
    }
    let loaded = |i: &usize| problem.contacts[*i].loaded;
    conflict.extend((0..problem.contacts.len()).filter(loaded).map(Group::Place));
    conflict.push(Group::Equilibrium);
    Ok(Some(conflict))
}

/// The groups of a problem, those first that one would do without first.
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

/// What is done to a group.
#[derive(Clone, Copy, PartialEq)]
enum Ease {
    Kept,
    /// Eased by an amount, as [`Relaxation::amount`] has it.
    By(f64),
    Gone,
}

/// The posture of the problem with its groups eased.
fn eased(
    problem: &Problem,
    config: &Config,
    ease: impl Fn(Group) -> Ease,
) -> Result<Option<Box<Posture>>, Error> {
    let mut config = config.clone();
    let mut contacts = problem.contacts.clone();
    let mut dropped = Dropped {
        places: vec![false; contacts.len()],
        equilibrium: ease(Group::Equilibrium) != Ease::Kept,
    };
    let clearance = |group, kept: f64| match ease(group) {
        Ease::Kept => kept,
        Ease::By(amount) => kept - amount,
        Ease::Gone => -1e3,
    };
    config.self_clearance_m = clearance(Group::SelfClearance, config.self_clearance_m);
    config.clearance_m = clearance(Group::Clearance, config.clearance_m);
    config.torque_use = match ease(Group::Torques) {
        Ease::Kept => config.torque_use,
        Ease::By(amount) => amount,
        Ease::Gone => 1e3,
    };
    config.joint_margin_rad = match ease(Group::JointLimits) {
        Ease::Kept => config.joint_margin_rad,
        Ease::By(amount) => config.joint_margin_rad - amount,
        Ease::Gone => -std::f64::consts::PI,
    };
    for (i, contact) in contacts.iter_mut().enumerate() {
        match ease(Group::Friction) {
            Ease::Kept => {}
            Ease::By(needed) => contact.friction = needed.max(contact.friction),
            Ease::Gone => contact.friction = ANY_FRICTION,
        }
        dropped.places[i] = ease(Group::Place(i)) != Ease::Kept;
    }
    let base_goal = match ease(Group::Goal) {
        Ease::Kept => problem.base_goal.clone(),
        Ease::By(amount) => problem.base_goal.clone().map(|mut goal| {
            goal.tolerance_m += amount;
            goal
        }),
        Ease::Gone => None,
    };
    let problem = Problem {
        contacts,
        base_goal,
        ..*problem
    };
    let outcome = solve_without(&problem, &config, dropped)?;
    Ok(match outcome {
        Outcome::Feasible(posture) => Some(posture),
        _ => None,
    })
}

/// The least by which a group has to give way while the others hold; nothing where it alone is
/// not enough.
fn relax(problem: &Problem, config: &Config, group: Group) -> Result<Option<Relaxation>, Error> {
    let with = |amount: Ease| {
        eased(problem, config, |g| {
            if g == group { amount } else { Ease::Kept }
        })
    };
    let Some(free) = with(Ease::Gone)? else {
        return Ok(None);
    };
    if let Group::Place(i) = group {
        return Ok(displacement(problem, i, &free));
    }
    if group == Group::Equilibrium {
        return Ok(None);
    }
    let (mut low, mut high) = match group {
        Group::Friction => {
            let least = problem
                .contacts
                .iter()
                .map(|c| c.friction)
                .fold(f64::INFINITY, f64::min);
            (least, ANY_FRICTION)
        }
        Group::Torques => (
            config.torque_use,
            (1.01 * free.margins.torque_use).max(config.torque_use),
        ),
        Group::JointLimits => (0.0, std::f64::consts::PI),
        _ => (0.0, 0.5),
    };
    if with(Ease::By(high))?.is_none() {
        return Ok(None);
    }
    for _ in 0..HALVINGS {
        let middle = if group == Group::Friction {
            (low * high).sqrt()
        } else {
            0.5 * (low + high)
        };
        if with(Ease::By(middle))?.is_some() {
            high = middle;
        } else {
            low = middle;
        }
    }
    let words = match group {
        Group::Friction => format!("friction of {high:.2}"),
        Group::Torques => format!("torques of {:.0} % of the limits", 100.0 * high),
        Group::JointLimits => {
            let Some(posture) = with(Ease::By(high))? else {
                return Ok(None);
            };
            let mut beyond: Vec<(f64, &str)> = problem
                .robot
                .joint_bodies()
                .iter()
                .zip(posture.q.joints.iter())
                .map(|(b, q)| {
                    let inside = (q - b.lower).min(b.upper - q) - config.joint_margin_rad;
                    (-inside, b.joint.as_str())
                })
                .filter(|(by, _)| *by > 1e-3)
                .collect();
            beyond.sort_by(|a, b| b.0.total_cmp(&a.0));
            let names: Vec<String> = beyond
                .iter()
                .take(3)
                .map(|(by, joint)| format!("{joint} by {:.1}°", by.to_degrees()))
                .collect();
            format!("wider joint limits: {}", names.join(", "))
        }
        Group::SelfClearance => format!("{:.0} mm less between parts of the robot", 1e3 * high),
        Group::Clearance => format!("{:.0} mm less from the environment", 1e3 * high),
        Group::Goal => format!("{:.0} mm more tolerance at the goal", 1e3 * high),
        Group::Place(_) | Group::Equilibrium => String::new(),
    };
    Ok(Some(Relaxation {
        group,
        amount: high,
        words,
    }))
}

/// Where a contact ends up that is only drawn to its place.
#[allow(non_snake_case)]
fn displacement(problem: &Problem, i: usize, free: &Posture) -> Option<Relaxation> {
    let is = free.contacts[i].X_WC.translation.vector;
    let patch = &problem.robot.patches[problem.contacts[i].patch].name;
    let (amount, direction) = match &problem.contacts[i].place {
        Place::Fixed { X_WC, .. } => {
            let by = is - X_WC.translation.vector;
            let [x, y, z] = [by.x, by.y, by.z].map(|c| 1e3 * c);
            (by.norm(), format!(" (x {x:+.0}, y {y:+.0}, z {z:+.0})"))
        }
        Place::OnSurface { surface, .. } => {
            let s = &problem.environment.surfaces[*surface];
            let touched =
                problem.robot.patches[problem.contacts[i].patch].touched_W(&free.contacts[i].X_WC);
            let p_S = s.X_WS.inverse_transform_point(&touched.into());
            let polygon = problem.environment.effective[*surface].as_ref()?;
            let outside = polygon.signed_distance(&p_S.xy()).max(0.0);
            (
                outside.hypot(p_S.z),
                format!(" ({:+.0} along the normal)", 1e3 * p_S.z),
            )
        }
    };
    Some(Relaxation {
        group: Group::Place(i),
        amount,
        words: format!("{patch} elsewhere by {:.0} mm{direction}", 1e3 * amount),
    })
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
            let patch = &problem.robot.patches[contact.patch].name;
            match contact.place.surface() {
                Some(s) => format!("{patch} on {}", problem.environment.surfaces[s].id),
                None => format!("{patch} at its place"),
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
