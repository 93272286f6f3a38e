//! The children that a node could have, cheap tests first.
//!
//! A child differs by exactly one contact, and is real only if the transition is: adding c is
//! posed as a posture of the *old* set that touches c's place without load; removing c as an
//! equilibrium without c while c still touches. One posture then belongs to both contact sets.
//! Source: [escande2013]; design: transitions.

use motion::{MotionContext, StanceRef};
use nalgebra::{Point3, Vector3};
use posture::{Contact, FaceIndex, Outcome};
use robot_model::PatchId;

use crate::Error;
use crate::change::{Candidate, Move, RESTARTS};
use crate::context::SearchContext;
use crate::estimate::estimate;
use crate::foothold::Foothold;
use crate::foothold_proposal::{CROSSED_PRICE, crossed_m, propose};
use crate::footing::Footing;
use crate::node::Node;
use crate::nominal_posture::nominal_posture;
use crate::reserve::solve_with_reserve;

/// How near to the nominal one the postures of the tree are brought: what is left to gain is carried
/// on to the children ([`posture::Solver::optimality`]).
const OPTIMALITY: f64 = 5e-3;

/// Price of a metre by which a foot lands farther ahead than a stride, or another limb touches farther ahead
/// or behind than it is wanted, in contacts: long steps are the ones that legs cannot leave again, and what is
/// far along the way is out of an arm's reach as what is far beside it is.
const BEYOND_PRICE: f64 = 5.0;

/// Price of another limb's contact that is made for nothing yet, in contacts: one that helps a foot is known before it
/// is made (`support`).
const AIMLESS_PRICE: f64 = 2.0;

/// Price of a contact of a leg whose foot stands, in contacts: a knee mostly touches in the place of its foot.
const BOTH_OF_LEG_PRICE: f64 = 4.0;

/// Normals whose cosine is larger are those of one plane, up to a tenth of a degree.
const ONE_PLANE: f64 = 1.0 - 2e-6;

/// Every child of a node that passes the cheap tests.
pub(crate) fn children(context: &SearchContext, index: usize, node: &Node) -> Vec<Candidate> {
    let robot = context.request.robot;
    let feet = node.feet(context);
    // With a foot in the air that stood before, only that foot and what of its own leg touches in its place, such as
    // the knee: nothing else is done on fewer feet than must be.
    let aloft = |patch: PatchId| {
        let stood = context.foot(patch).is_some() && node.footing[patch.index()].is_some();
        stood && !node.holds(patch)
    };
    let any_aloft = context.feet.iter().any(|&p| aloft(p));
    let of_leg_aloft = |patch: PatchId| {
        let mut feet = context.feet.iter();
        context.foot(patch).is_none() && feet.any(|&foot| aloft(foot) && robot.carries(patch, foot))
    };
    let mut children = Vec::new();

    // Release: at least one foot stays, and three points where forces may act, which a foot with an
    // area has: over two the centre of mass has no room.
    for contact in &node.contacts {
        let patch = contact.patch;
        if any_aloft && !of_leg_aloft(patch) {
            continue;
        }
        let stay = || node.contacts.iter().filter(|c| c.patch != patch);
        let points: usize = stay().map(|c| robot.patches[c.patch].polygon.len()).sum();
        if points < 3 || !stay().any(|c| context.foot(c.patch).is_some()) {
            continue;
        }
        let mut after = feet.clone();
        if let Some(foot) = context.foot(patch) {
            after[foot].in_air = true;
        }
        let mut held = node.held();
        held.retain(|c| c.0 != patch);
        let (made, rest) = price(context, node, (&after, &node.footing), &held);
        children.push(Candidate::new(
            index,
            Move::Remove(patch),
            made,
            rest,
            context.weight,
        ));
    }

    // Touch: a patch that is free, on a face it may touch, within reach.
    for patch in robot.patch_ids() {
        if !context.is_used(patch)
            || node.holds(patch)
            || (any_aloft && !aloft(patch) && !of_leg_aloft(patch))
        {
            continue;
        }
        let mut offered: Vec<(Vector3<f64>, Point3<f64>)> = Vec::new();
        for face in within_reach(context, node, patch) {
            let Some(foothold) = propose(context, node, &feet, patch, face, 0) else {
                continue;
            };
            // Faces of one plane may overlap, as the ground under the feet and the floor do.
            let normal = context.request.environment[face].normal_W();
            let same = |(other, place): &(Vector3<f64>, Point3<f64>)| {
                let apart_m = (place - foothold.place).norm();
                other.dot(&normal) > ONE_PLANE && apart_m < context.same_place_m()
            };
            let is_wanted = context.is_wanted(patch, face);
            if is_wanted || !offered.iter().any(same) {
                offered.push((normal, foothold.place));
                let mut child = touch(context, index, node, foothold);
                if context.foot(patch).is_none() && !is_wanted {
                    child.priority += AIMLESS_PRICE;
                }
                let mut stand = context.feet.iter().filter(|&&foot| node.holds(foot));
                if stand.any(|&foot| robot.carries(patch, foot)) {
                    child.priority += BOTH_OF_LEG_PRICE;
                }
                children.push(child);
            }
        }
    }
    children
}

/// The faces that a patch may touch and that may be within its reach from the contacts of a node.
pub(crate) fn within_reach(context: &SearchContext, node: &Node, patch: PatchId) -> Vec<FaceIndex> {
    let radius_m = context.request.robot.patches[patch].point_radius_m();
    let boxes = node.contacts.iter().map(|held| {
        let reach_m = context.reach.span_m(patch, held.patch) + radius_m.unwrap_or(0.0);
        let middle = Point3::from(held.X_WC.translation.vector);
        let reach = Vector3::repeat(reach_m);
        (middle - reach, middle + reach)
    });
    let common = boxes.reduce(|a, b| (a.0.sup(&b.0), a.1.inf(&b.1)));
    let near = common.map(|(low, high)| context.request.environment.faces_near(&low, &high));
    let mut near = near.unwrap_or_default();
    near.retain(|&face| context.may_touch(patch, face));
    near
}

/// The child that touches at a proposed place.
pub(crate) fn touch(
    context: &SearchContext,
    index: usize,
    node: &Node,
    foothold: Foothold,
) -> Candidate {
    let (patch, place) = (foothold.patch, foothold.place.coords);
    let mut feet = node.feet(context);
    let footing = context.footing(patch, &place, foothold.yaw_rad, Some(foothold.along_m));
    let mut beyond_m = footing.along_m - foothold.along_m;
    if let Some(foot) = context.foot(patch) {
        // More than a stride is worth no more than a stride.
        beyond_m = beyond_m.max(0.0);
        feet[foot] = Footing {
            along_m: footing.along_m - beyond_m,
            astray: footing.astray || context.is_elsewhere(patch, foothold.face),
            ..footing
        };
    }
    let mut held = node.held();
    held.push((patch, foothold.face));
    let mut after = node.footing.clone();
    after[patch.index()] = Some(footing);
    let (made, rest) = price(context, node, (&feet, &after), &held);
    let crossed = CROSSED_PRICE * crossed_m(context, node, &foothold);
    let made = made + foothold.price() + BEYOND_PRICE * beyond_m.abs() + crossed;
    Candidate::new(index, Move::Add(foothold), made, rest, context.weight)
}

/// Contacts made with the price of extra ones, and those estimated to follow, of a child of a node that holds
/// `held` and has its feet there; with where on the route every patch stands.
fn price(
    context: &SearchContext,
    node: &Node,
    (feet, footing): (&[Footing], &[Option<Footing>]),
    held: &[(PatchId, FaceIndex)],
) -> (f64, f64) {
    let extras = held.iter().map(|&(patch, face)| {
        let footing = footing[patch.index()].as_ref();
        extra(context, (patch, face), footing)
    });
    let made = (node.depth + 1) as f64 + extras.sum::<f64>();
    (made, estimate(context, feet, context.missing(held)))
}

/// The price of a contact with a patch that is not among the start's and that is not wanted at the goal: that of any, and
/// of its distance from where the limb usually is.
fn extra(
    context: &SearchContext,
    (patch, face): (PatchId, FaceIndex),
    footing: Option<&Footing>,
) -> f64 {
    if context.foot(patch).is_some() || context.is_wanted(patch, face) {
        return 0.0;
    }
    let lateral_m = footing.map_or(0.0, |f| f.lateral_m);
    let config = context.config;
    config.extra_contact_price + config.lateral_deviation_price_per_m * lateral_m
}

/// The next place on the face that a candidate touches, if there is another one.
pub(crate) fn next_place(
    context: &SearchContext,
    node: &Node,
    candidate: &Candidate,
) -> Option<Candidate> {
    let Move::Add(foothold) = &candidate.change else {
        return None;
    };
    let (patch, face) = (foothold.patch, foothold.face);
    let from = foothold.next();
    let next = propose(context, node, &node.feet(context), patch, face, from)?;
    Some(touch(context, candidate.node, node, next))
}

/// What came of a candidate.
pub(crate) struct Solved {
    /// The contacts that were asked for.
    pub contacts: Vec<Contact>,
    pub outcome: Outcome,
    /// Why the patch cannot come to the place that it touches or leave it, where it cannot.
    pub lift_off_blocked: Option<String>,
}

/// Solves the posture problem of a candidate, if its face has room for it; a pure function of the
/// node and the candidate.
pub(crate) fn solve(
    context: &SearchContext,
    motion: &MotionContext,
    node: &Node,
    candidate: &Candidate,
) -> Result<Option<Solved>, Error> {
    let mut contacts = node.contacts.clone();
    let mut along_m = node.along_m(context);
    for change in std::iter::once(&candidate.change).chain(&candidate.purpose) {
        // What was made before the last of them bears.
        let of = |c: &Contact| c.patch == change.patch();
        contacts.iter_mut().for_each(|c| c.loaded = true);
        match change {
            Move::Remove(_) => {
                for contact in contacts.iter_mut().filter(|c| of(c)) {
                    contact.loaded = false;
                }
            }
            Move::Add(foothold) => {
                let Some(contact) = foothold.contact(context) else {
                    return Ok(None);
                };
                contacts.retain(|c| !of(c));
                contacts.push(contact);
                if let Some(foot) = context.foot(foothold.patch) {
                    let last = node.feet(context)[foot].along_m;
                    along_m += (foothold.along_m - last) / context.feet.len() as f64;
                }
            }
        }
    }
    let nominal = nominal_posture(context, &contacts, along_m);
    let config = posture::Config {
        restarts: RESTARTS[candidate.tries.min(RESTARTS.len() - 1)],
        solver: posture::Solver {
            optimality: OPTIMALITY,
            upright: Some(context.upright(&nominal)),
            ..motion.posture.solver
        },
        ..motion.posture.clone()
    };
    let reference = candidate.near.as_ref().map_or(nominal, |p| p.q.clone());
    let is_last = candidate.then.as_ref().is_some_and(Vec::is_empty);
    let planned = candidate.planned.as_ref().filter(|_| is_last);
    let guess = planned.map_or(&node.posture.q, |posture| &posture.q);
    let problem = context.problem(contacts, &reference, guess);
    let outcome = match candidate.tries {
        0 => solve_with_reserve(&problem, &config)?,
        _ => posture::solve(&problem, &config)?,
    };
    let lift_off_blocked = match &outcome {
        Outcome::Feasible(posture) if candidate.purpose.is_empty() => {
            let stance = StanceRef {
                contacts: &problem.contacts,
                posture,
            };
            motion::raised(motion, stance, candidate.change.patch())?
        }
        _ => None,
    };
    Ok(Some(Solved {
        contacts: problem.contacts,
        outcome,
        lift_off_blocked,
    }))
}
