//! How far one group of constraints has to give way for the others to hold.

use super::{ANY_FRICTION, Group, Relaxation};
use crate::iterate::Relaxed;
use crate::outcome::{Outcome, Posture};
use crate::problem::Problem;
use crate::solve::solve_relaxed;
use crate::{Config, Error};

/// Halvings of the amount by which a group is eased.
const HALVINGS: usize = 6;
/// What is done to a group.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ease {
    /// As it is.
    Kept,
    /// Eased by an amount, as [`Relaxation::amount`] has it.
    By(f64),
    /// Left out.
    Gone,
}

/// The posture of the problem with its groups eased.
pub(super) fn eased(
    problem: &Problem,
    config: &Config,
    ease: impl Fn(Group) -> Ease,
) -> Result<Option<Box<Posture>>, Error> {
    let mut config = config.clone();
    let mut contacts = problem.contacts.clone();
    let mut relaxed = Relaxed {
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
        relaxed.places[i] = ease(Group::Place(i)) != Ease::Kept;
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
    match solve_relaxed(&problem, &config, relaxed)? {
        Outcome::Feasible(posture) => Ok(Some(posture)),
        _ => Ok(None),
    }
}

/// The least by which a group has to give way while the others hold; nothing where it alone is
/// not enough.
pub(super) fn relax(
    problem: &Problem,
    config: &Config,
    group: Group,
) -> Result<Option<Relaxation>, Error> {
    let with = |amount: Ease| {
        let ease = |g| if g == group { amount } else { Ease::Kept };
        eased(problem, config, ease)
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
            let frictions = problem.contacts.iter().map(|c| c.friction);
            (frictions.fold(f64::INFINITY, f64::min), ANY_FRICTION)
        }
        Group::Torques => {
            let needed = 1.01 * free.margins.torque_use;
            (config.torque_use, needed.max(config.torque_use))
        }
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
        Group::JointLimits => match with(Ease::By(high))? {
            Some(posture) => wider_limits(problem, config, &posture),
            None => return Ok(None),
        },
        _ => words(config, group, high),
    };
    Ok(Some(Relaxation {
        group,
        amount: high,
        words,
    }))
}

/// Where a contact ends up that is only drawn to its place.
fn displacement(problem: &Problem, i: usize, free: &Posture) -> Option<Relaxation> {
    let is = free.contacts[i].X_WC.translation.vector;
    let asked = &problem.contacts[i];
    let shape = &problem.robot.patches[asked.patch];
    let patch = &shape.name;
    let (amount, direction) = match asked.area() {
        None => {
            let by = is - asked.X_WC.translation.vector;
            let [x, y, z] = [by.x, by.y, by.z].map(|c| 1e3 * c);
            (by.norm(), format!(" (x {x:+.0}, y {y:+.0}, z {z:+.0})"))
        }
        Some(area) => {
            let (beside, over) = area.distances_m(&shape.touched_W(&free.contacts[i].X_WC));
            let direction = format!(" ({:+.0} along the normal)", 1e3 * over);
            (beside.hypot(over), direction)
        }
    };
    Some(Relaxation {
        group: Group::Place(i),
        amount,
        words: format!("{patch} elsewhere by {:.0} mm{direction}", 1e3 * amount),
    })
}

/// What easing a group by an amount means.
fn words(config: &Config, group: Group, amount: f64) -> String {
    match group {
        Group::Friction => format!("friction of {amount:.2}"),
        Group::Torques => {
            let [needed, may] = [amount, config.torque_use].map(|use_| 100.0 * use_);
            format!("torques of {needed:.1} % of the limits ({may:.0} % may be used)")
        }
        Group::SelfClearance => format!("{:.0} mm less between parts of the robot", 1e3 * amount),
        Group::Clearance => format!("{:.0} mm less from the environment", 1e3 * amount),
        Group::Goal => format!("{:.0} mm more tolerance at the goal", 1e3 * amount),
        Group::JointLimits | Group::Place(_) | Group::Equilibrium => String::new(),
    }
}

/// The joints that a posture has beyond their limits, the worst three.
fn wider_limits(problem: &Problem, config: &Config, posture: &Posture) -> String {
    let bodies = problem.robot.joint_bodies().iter();
    let over = bodies.zip(posture.q.joints.iter()).map(|(b, q)| {
        let inside = (q - b.lower).min(b.upper - q) - b.kept_margin(config.joint_margin_rad);
        (-inside, b.joint.as_str())
    });
    let mut beyond: Vec<(f64, &str)> = over.filter(|(by, _)| *by > 1e-3).collect();
    beyond.sort_by(|a, b| b.0.total_cmp(&a.0));
    let said = |(by, joint): &(f64, &str)| format!("{joint} by {:.1}°", by.to_degrees());
    let names: Vec<String> = beyond.iter().take(3).map(said).collect();
    format!("wider joint limits: {}", names.join(", "))
}
