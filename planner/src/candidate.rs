//! The children that a node could have, cheap tests first.
//!
//! A child differs by exactly one contact, and is real only if the transition is: adding c is
//! posed as a posture of the *old* set that touches c's place without load; removing c as an
//! equilibrium without c while c still touches. One posture then belongs to both contact sets.
//! Source: [escande2013]; design: transitions.

use motion::{End, Setting};
use nalgebra::{Point3, Vector3};
use posture::{Contact, Outcome, Place, Problem};

use crate::Error;
use crate::comfort::comfortable;
use crate::node::{Node, aside, fixed};
use crate::request::{FootState, Prepared};
use crate::wish::{Wish, wanted_place};

/// A change to a node's contact set that has passed the cheap tests.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub node: usize,
    pub change: Move,
    /// Contacts made plus contacts still to be made, as far as one can tell before solving.
    pub priority: f64,
    /// Whether it failed at the first attempt and is tried again, from other starts.
    pub again: bool,
    /// Whether its place is one beside another that no motion leads to.
    pub elsewhere: bool,
}

/// One contact more or one less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Move {
    /// Release the contact of this patch.
    Remove { patch: usize },
    /// Touch the surface with the patch, as near as possible to the wanted place.
    Add {
        patch: usize,
        surface: usize,
        toward: Point3<f64>,
        yaw_rad: Option<f64>,
    },
}

/// Every child of a node that passes the cheap tests.
pub(crate) fn children(prepared: &Prepared, index: usize, node: &Node) -> Vec<Candidate> {
    let mut children = Vec::new();
    let feet = node.feet(prepared);
    let made = (node.depth + 1) as f64;
    let greed = prepared.config.greed;
    let held: f64 = node
        .contacts
        .iter()
        .map(|c| extra(prepared, c.patch, &c.place_W(prepared)))
        .sum();

    // With a foot in the air that stood before, only that foot.
    let aloft = |patch: usize| {
        let stood = prepared.feet.contains(&patch) && node.last[patch].is_some();
        stood && !node.holds(patch)
    };
    let any_aloft = prepared.config.land_first && prepared.feet.iter().any(|&p| aloft(p));

    // Release: at least one foot stays, and three points where forces may act, which a foot with an
    // area has: over two the centre of mass has no room.
    for contact in &node.contacts {
        let patch = contact.patch;
        let stays = node
            .contacts
            .iter()
            .any(|c| c.patch != patch && prepared.feet.contains(&c.patch));
        let points: usize = node
            .contacts
            .iter()
            .filter(|c| c.patch != patch)
            .map(|c| prepared.request.robot.patches[c.patch].polygon.len())
            .sum();
        if !stays || points < 3 || any_aloft {
            continue;
        }
        let mut after = feet.clone();
        if let Some(i) = prepared.feet.iter().position(|&p| p == patch) {
            after[i].in_air = true;
        }
        let released = extra(prepared, patch, &contact.place_W(prepared));
        children.push(Candidate {
            node: index,
            change: Move::Remove { patch },
            priority: made + greed * prepared.estimate(&after) + held - released,
            again: false,
            elsewhere: false,
        });
    }

    // Touch: a patch that is free, on a surface it may touch, within reach.
    for patch in 0..prepared.request.robot.patches.len() {
        if !prepared.used[patch] || node.holds(patch) || (any_aloft && !aloft(patch)) {
            continue;
        }
        // Pieces of one face that offer the same place are one.
        let mut offered: Vec<(usize, Point3<f64>)> = Vec::new();
        for &surface in &prepared.request.usable[patch] {
            let Some(wish) = wanted_place(prepared, node, &feet, patch, surface) else {
                continue;
            };
            let face = prepared.face[surface];
            let same = |(other, place): &(usize, Point3<f64>)| {
                *other == face && (place - wish.place).norm() < prepared.config.same_place_m
            };
            if !offered.iter().any(same) {
                offered.push((face, wish.place));
                children.push(touch(prepared, index, node, patch, surface, &wish));
            }
        }
    }
    children
}

/// The child that touches a surface at the wanted place.
pub(crate) fn touch(
    prepared: &Prepared,
    index: usize,
    node: &Node,
    patch: usize,
    surface: usize,
    wish: &Wish,
) -> Candidate {
    let config = prepared.config;
    let mut feet = node.feet(prepared);
    let mut over_m = 0.0;
    if let Some(i) = prepared.feet.iter().position(|&p| p == patch) {
        let place = &wish.place.coords;
        let guide = &prepared.request.guide;
        let progress = guide.foot_progress(place, &prepared.offset[patch]);
        over_m = (progress.along_m - wish.along_m).max(0.0);
        feet[i] = FootState {
            // More than a stride is worth no more than a stride.
            along_m: progress.along_m - over_m,
            aside_m: aside(prepared, patch, place),
            in_air: false,
        };
    }
    let held = node
        .contacts
        .iter()
        .map(|c| (c.patch, c.place_W(prepared)))
        .chain([(patch, wish.place.coords)]);
    let extras: f64 = held
        .map(|(patch, place)| extra(prepared, patch, &place))
        .sum();
    Candidate {
        node: index,
        change: Move::Add {
            patch,
            surface,
            toward: wish.place,
            yaw_rad: wish.yaw_rad,
        },
        priority: (node.depth + 1) as f64
            + config.greed * prepared.estimate(&feet)
            + extras
            + config.aside_price_per_m * over_m,
        again: false,
        elsewhere: false,
    }
}

/// The price of a contact with a patch that is not among the start's: that of any, and of its
/// distance from where the limb usually is.
fn extra(prepared: &Prepared, patch: usize, place: &Vector3<f64>) -> f64 {
    if prepared.feet.contains(&patch) {
        return 0.0;
    }
    let config = prepared.config;
    config.extra_contact_price + config.aside_price_per_m * aside(prepared, patch, place)
}

/// What came of a candidate.
pub(crate) struct Solved {
    /// The contacts that were asked for.
    pub contacts: Vec<Contact>,
    pub outcome: Outcome,
    /// Why the patch cannot come to the place that it touches or leave it, where it cannot.
    pub stuck: Option<String>,
}

/// Solves the posture problem of a candidate; a pure function of the node and the candidate.
pub(crate) fn solve(
    prepared: &Prepared,
    setting: &Setting,
    node: &Node,
    candidate: &Candidate,
) -> Result<Solved, Error> {
    let request = prepared.request;
    let change = &candidate.change;
    let restarts = if candidate.again {
        prepared.config.posture_restarts
    } else {
        0
    };
    let config = &posture::Config {
        restarts,
        optimality: prepared.config.posture_optimality,
        ..setting.posture.clone()
    };
    let mut contacts: Vec<Contact> = node
        .contacts
        .iter()
        .map(|held| {
            let leaves = matches!(change, Move::Remove { patch } if *patch == held.patch);
            fixed(prepared, held, !leaves)
        })
        .collect();
    if let Move::Add {
        patch,
        surface,
        toward,
        yaw_rad,
    } = *change
    {
        contacts.push(Contact {
            patch,
            place: Place::OnSurface {
                surface,
                toward: Some(toward),
                yaw_rad,
            },
            loaded: false,
            friction: request.robot.patches[patch].friction,
        });
    }
    let reference = comfortable(prepared, &contacts);
    let problem = Problem {
        robot: request.robot,
        environment: request.environment,
        contacts,
        base_goal: None,
        reference: &reference,
        guess: &node.posture.q,
    };
    let outcome = posture::solve(&problem, config)?;
    let contacts = problem.contacts;
    let stuck = match &outcome {
        Outcome::Feasible(posture) => {
            let touching: Vec<(usize, usize, bool)> = contacts
                .iter()
                .filter_map(|c| Some((c.patch, c.place.surface()?, c.loaded)))
                .collect();
            let (Move::Remove { patch } | Move::Add { patch, .. }) = *change;
            let setting = Setting {
                posture: config,
                ..*setting
            };
            let stance = End {
                contacts: &touching,
                posture,
            };
            motion::raised(&setting, stance, patch)?
        }
        _ => None,
    };
    Ok(Solved {
        contacts,
        outcome,
        stuck,
    })
}
