//! The children that a node could have, cheap tests first.
//!
//! A child differs by exactly one contact, and is real only if the transition is: adding c is
//! posed as a posture of the *old* set that touches c's place without load; removing c as an
//! equilibrium without c while c still touches. One posture then belongs to both contact sets.
//! Source: [escande2013]; design: transitions.

use nalgebra::{Isometry3, Point3};
use posture::{Contact, Outcome, Place, Problem};

use crate::comfort::comfortable;
use crate::node::{Node, aside, fixed};
use crate::request::{FootState, Prepared, hindmost};

/// A change to a node's contact set that has passed the cheap tests.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub node: usize,
    pub change: Move,
    /// Contacts made plus contacts still to be made, as far as one can tell before solving.
    pub priority: f64,
    /// Whether it failed at the first attempt and is tried again, from other starts.
    pub again: bool,
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
    let extras = |n: usize| prepared.config.extra_contact_price * n as f64;
    let extra_held = node
        .contacts
        .iter()
        .filter(|c| !prepared.feet.contains(&c.patch))
        .count();

    // With a foot in the air that stood before, only that foot.
    let aloft = |patch: usize| {
        let stood = prepared.feet.contains(&patch) && node.last[patch].is_some();
        stood && !node.holds(patch)
    };
    let any_aloft = prepared.config.land_first && prepared.feet.iter().any(|&p| aloft(p));

    // Release: at least one foot stays, and three points where forces may act, which a foot with an
    // area has: over two the centre of mass has no room.
    for held in &node.contacts {
        let patch = held.patch;
        let is_foot = prepared.feet.contains(&patch);
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
        let extra = if is_foot { extra_held } else { extra_held - 1 };
        children.push(Candidate {
            node: index,
            change: Move::Remove { patch },
            priority: made + greed * prepared.estimate(&after) + extras(extra),
            again: false,
        });
    }

    // Touch: a patch that is free, on a surface it may touch, within reach.
    for patch in 0..prepared.request.robot.patches.len() {
        if !prepared.used[patch] || node.holds(patch) || (any_aloft && !aloft(patch)) {
            continue;
        }
        let is_foot = prepared.feet.contains(&patch);
        for &surface in &prepared.request.usable[patch] {
            let Some(wanted) = wanted_place(prepared, node, &feet, patch, surface) else {
                continue;
            };
            let (toward, yaw_rad) = (wanted.place, wanted.yaw_rad);
            let mut over_m = 0.0;
            let mut after = feet.clone();
            if let Some(i) = prepared.feet.iter().position(|&p| p == patch) {
                let guide = &prepared.request.guide;
                let progress = guide.foot_progress(&toward.coords, &prepared.offset[patch]);
                over_m = (progress.along_m - wanted.along_m).max(0.0);
                after[i] = FootState {
                    // More than a stride is worth no more than a stride.
                    along_m: progress.along_m - over_m,
                    aside_m: aside(prepared, patch, &toward.coords),
                    in_air: false,
                };
            }
            let extra = if is_foot { extra_held } else { extra_held + 1 };
            children.push(Candidate {
                node: index,
                change: Move::Add {
                    patch,
                    surface,
                    toward,
                    yaw_rad,
                },
                priority: made
                    + greed * prepared.estimate(&after)
                    + extras(extra)
                    + prepared.config.aside_price_per_m * over_m,
                again: false,
            });
        }
    }
    children
}

/// Where a patch would like to touch a surface.
struct Wish {
    place: Point3<f64>,
    /// Heading of a foot.
    yaw_rad: Option<f64>,
    /// Progress along the guide path that was aimed at, m.
    along_m: f64,
}

/// The place on a surface that a patch would like best, if it is within reach at all: a stride
/// ahead of the hindmost of the other feet (for a hand, of the foremost that stands), along the
/// guide path, at the patch's usual offset, moved onto the surface.
#[allow(non_snake_case)]
fn wanted_place(
    prepared: &Prepared,
    node: &Node,
    feet: &[FootState],
    patch: usize,
    surface: usize,
) -> Option<Wish> {
    let request = prepared.request;
    let guide = &request.guide;
    let support = match prepared.feet.iter().position(|&foot| foot == patch) {
        Some(i) => hindmost(feet, i),
        None => feet
            .iter()
            .filter(|f| !f.in_air)
            .map(|f| f.along_m)
            .max_by(f64::total_cmp)
            .unwrap_or(f64::NEG_INFINITY),
    };
    let (_, heading) = guide.at(support);
    let normal = request.environment.surfaces[surface].normal_W();
    let stride_m = prepared.stride_on(patch, &normal, heading);
    let along = (support + stride_m).min(guide.length_m());
    let wanted = guide.foot_at(along, &prepared.offset[patch]);
    let (_, heading) = guide.at(along);

    // Moved onto the surface, the patch's middle at least its half width from the edge, a ball's at
    // least its radius.
    let polygon = request.environment.effective[surface].as_ref()?;
    let X_WS = &request.environment.surfaces[surface].X_WS;
    let shape = &request.robot.patches[patch];
    let half_width = shape
        .point_radius_m()
        .unwrap_or_else(|| half_width(&shape.polygon));
    let room = polygon.inset(half_width)?;
    let p_S = X_WS.inverse_transform_point(&Point3::from(wanted)).xy();
    let place_S = nearest_inside(room.vertices(), &p_S);
    let place = X_WS * Point3::new(place_S.x, place_S.y, 0.0);

    // Within reach of every contact that stays: two limbs and what is between them. A ball's centre
    // is over the place that it touches.
    let over = request.robot.patches[patch].touching(&Isometry3::identity());
    let centre = place + X_WS.rotation * over.translation.vector;
    let X_over = X_WS * over;
    for held in &node.contacts {
        let apart = (centre.coords - held.X_WC.translation.vector).norm();
        let nearest = distance_to_polygon(&X_over, polygon.vertices(), &held.X_WC);
        let reach = prepared.reach_m[patch] + prepared.reach_m[held.patch];
        if nearest > reach && apart > reach {
            return None;
        }
    }
    // A foot looks along the path; how a hand lies does not matter.
    let yaw_rad = prepared.feet.contains(&patch).then_some(heading);
    Some(Wish {
        place,
        yaw_rad,
        along_m: along,
    })
}

/// Distance of a contact from the nearest point of a polygon, m.
#[allow(non_snake_case)]
fn distance_to_polygon(
    X_WS: &Isometry3<f64>,
    polygon: &[nalgebra::Point2<f64>],
    X_WC: &Isometry3<f64>,
) -> f64 {
    let p = X_WS.inverse_transform_point(&Point3::from(X_WC.translation.vector));
    let inside = nearest_inside(polygon, &p.xy());
    ((inside - p.xy()).norm_squared() + p.z * p.z).sqrt()
}

/// Radius of the largest circle about the centroid that the patch contains, m.
fn half_width(polygon: &[nalgebra::Point2<f64>]) -> f64 {
    let n = polygon.len().max(1) as f64;
    let c = polygon
        .iter()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n;
    polygon
        .iter()
        .zip(polygon.iter().cycle().skip(1))
        .map(|(a, b)| {
            let e = b - a;
            e.perp(&(c - a.coords)).abs() / e.norm().max(1e-12)
        })
        .fold(f64::INFINITY, f64::min)
}

/// The point of a convex counter-clockwise polygon that is nearest to `p`.
fn nearest_inside(
    polygon: &[nalgebra::Point2<f64>],
    p: &nalgebra::Point2<f64>,
) -> nalgebra::Point2<f64> {
    let mut inside = true;
    let mut best = (*p, f64::INFINITY);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let e = b - a;
        if e.perp(&(p - a)) < 0.0 {
            inside = false;
        }
        let t = (e.dot(&(p - a)) / e.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        let q = a + t * e;
        let d = (p - q).norm();
        if d < best.1 {
            best = (q, d);
        }
    }
    if inside { *p } else { best.0 }
}

/// Solves the posture problem of a candidate; a pure function of the node and the candidate.
pub(crate) fn solve(
    prepared: &Prepared,
    node: &Node,
    candidate: &Candidate,
    config: &posture::Config,
) -> Result<(Vec<Contact>, Outcome), posture::Error> {
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
        ..config.clone()
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
    Ok((contacts, outcome))
}
