//! The way of the base over the terrain: a shortest path on a coarse lattice of places, levels and
//! headings.
//!
//! The base may be where every foot finds a landing near its usual place below it and nothing
//! stands where the trunk is. It moves to the eight places around, or turns by an eighth; sideways
//! and backward cost more, and so do feet far from their usual places. What the lattice finds is
//! drawn straight where that costs no more.

use std::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};

use crate::context::{LEVEL_LEGS, SearchContext};
use crate::gap::gap;
use crate::ground::Stands;
use crate::lattice::{Footed, HEADINGS, Lattice, Preference, Steps};
use crate::route::{Pose, Route, wrap};
use crate::shortest::Found;
use crate::steepness::holds_alone;

/// What a metre by which the ground is higher under one of two feet than under the other usually adds to the price of a metre and
/// of a turn: on stairs, turning is for the landing.
pub(crate) const UNEVEN: f64 = 10.0;

/// The way may end beside the goal by this part of what is allowed.
const WITHIN: f64 = 0.8;

/// The base goes down by this much a metre where it has to crouch.
const DOWN: f64 = 1.0;

/// What came of looking for a way.
enum Way {
    /// Straight from each point of the guide to the next, or not known to be otherwise; whether that is known
    /// to follow the ground.
    Straight(bool),
    /// Through these poses.
    Round(Vec<Pose>),
    /// None on the lattice, and why.
    None(String),
}

/// The context with its route on the way of the base, or with the gap where there is none.
///
/// Where steps as usual lead nowhere, the longest ones are asked for; and where faces are too slippery to stand
/// on, a way that does without them is sought first.
pub(crate) fn laid<'a>(
    mut context: SearchContext<'a>,
    preference: &Preference,
) -> SearchContext<'a> {
    let found = |stands: Stands| match find(&context, Steps::usual, stands, preference) {
        Way::None(_) => find(&context, Steps::longest, stands, preference),
        found => found,
    };
    let feet = context.feet.iter();
    let mut stood = feet.flat_map(|&foot| {
        let faces = context.request.usable[foot.index()].iter();
        faces.map(move |&face| (foot, face))
    });
    let is_firm = stood.all(|(foot, face)| holds_alone(&context, foot, face));
    let way = match found(holds_alone) {
        Way::None(_) | Way::Straight(false) if !is_firm => {
            found(|c, patch, face| c.may_touch(patch, face))
        }
        found => found,
    };
    match way {
        Way::Straight(is_founded) => context.is_founded = is_founded,
        Way::Round(poses) => {
            context.route = Route::through(&poses, context.turn_m);
            context.is_founded = true;
        }
        Way::None(gap) => context.gap = Some(gap),
    }
    context
}

/// The way of the base from the start through the guide's points.
fn find(
    context: &SearchContext,
    steps: fn(&SearchContext, f64) -> Steps,
    stands: Stands,
    preference: &Preference,
) -> Way {
    let Some(lattice) = Lattice::new(context, steps, stands, preference) else {
        return Way::Straight(false);
    };
    let goal_heading = context.request.goal.base.yaw_rad;
    let points = context.request.guide.points();
    let first = context.route.at(0.0);
    let ground_m = first.p.z - lattice.legs_m;
    let Some(start) = lattice.founded(&first.p.xy(), first.heading, ground_m) else {
        return Way::Straight(false);
    };
    let mut poses = vec![(first, start)];
    let (mut straight, mut off_m) = (true, 0.0_f64);
    for (i, to) in points.iter().enumerate().skip(1) {
        let last = i + 1 == points.len();
        let (from, footed) = poses[poses.len() - 1];
        let heading = goal_heading.filter(|_| last);
        let level = (to - from.p).z.abs() > 1e-6;
        let leg = lattice.straight(&from, footed.ground_m, to, heading);
        if let Some(leg) = leg {
            off_m = off_m.max(off_line_m(&leg, &points[i - 1], to));
            poses.extend(leg);
            continue;
        }
        straight = false;
        let to_level = level.then_some(to.z - lattice.legs_m);
        let beside_m = match last {
            true => WITHIN * context.request.goal.beside_m,
            false => 0.0,
        };
        let leg = lattice.shortest(&from, footed.ground_m, to, beside_m, to_level, heading);
        let leg = match leg {
            Found::Way(leg) => leg,
            Found::Reached(here) => return Way::None(gap(&lattice, &here, to)),
            Found::Unknown => return Way::Straight(false),
        };
        poses.extend(lattice.drawn_straight(&poses[poses.len() - 1], leg));
    }
    if straight {
        return Way::Straight(off_m < 0.5 * LEVEL_LEGS * lattice.legs_m);
    }
    let poses = poses.into_iter().map(|(pose, _)| pose).collect();
    Way::Round(smooth(poses))
}

/// How far poses are over or under the straight line between two points, m.
fn off_line_m(poses: &[(Pose, Footed)], from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let length_m = (to - from).xy().norm().max(1e-6);
    let off_m = poses.iter().map(|(pose, _)| {
        let part = (pose.p - from).xy().norm() / length_m;
        (pose.p.z - from.z - part * (to.z - from.z)).abs()
    });
    off_m.fold(0.0, f64::max)
}

impl Lattice<'_> {
    /// The poses of a straight line that is walked looking ahead, with what it costs; nothing
    /// where the way is not free.
    fn line(
        &self,
        from: &Pose,
        footed: Footed,
        to: &Vector2<f64>,
        heading: Option<f64>,
    ) -> Option<(Vec<(Pose, Footed)>, f64)> {
        let step = to - from.p.xy();
        let length = step.norm();
        let mut poses = vec![(*from, footed)];
        let mut price = 0.0;
        let mut go = |p: Vector2<f64>, heading: f64| -> Option<()> {
            let (last, before) = *poses.last()?;
            let now = self.founded(&p, heading, before.ground_m)?;
            price += self.price(
                &(p - last.p.xy()),
                heading,
                heading - last.heading,
                &before,
                &now,
            );
            let z = now.ground_m + self.legs_m;
            poses.push((
                Pose {
                    p: Vector3::new(p.x, p.y, z),
                    heading,
                    crouch_m: now.room.crouch_m,
                },
                now,
            ));
            Some(())
        };
        let turn_to = |from: f64,
                       to: f64,
                       p: Vector2<f64>,
                       go: &mut dyn FnMut(Vector2<f64>, f64) -> Option<()>|
         -> Option<f64> {
            let turn = wrap(to - from);
            let parts = (turn.abs() / (0.5 * TAU / HEADINGS as f64)).ceil();
            for k in 1..=parts as usize {
                go(p, from + turn * k as f64 / parts)?;
            }
            Some(from + turn)
        };
        let mut facing = from.heading;
        if length > 1e-6 {
            facing = turn_to(facing, step.y.atan2(step.x), from.p.xy(), &mut go)?;
            let parts = (length / self.context.places_m()).ceil();
            for k in 1..=parts as usize {
                go(from.p.xy() + step * (k as f64 / parts), facing)?;
            }
        }
        if let Some(heading) = heading {
            turn_to(facing, heading, *to, &mut go)?;
        }
        poses.remove(0);
        Some((poses, price))
    }

    /// The straight line to a point of the guide, where it costs little more than its length.
    fn straight(
        &self,
        from: &Pose,
        level_m: f64,
        to: &Vector3<f64>,
        heading: Option<f64>,
    ) -> Option<Vec<(Pose, Footed)>> {
        let footed = self.founded(&from.p.xy(), from.heading, level_m)?;
        let (poses, _) = self.line(from, footed, &to.xy(), heading)?;
        let (_, last) = poses.last()?;
        // On the level that is wanted, with room, never far from where feet are usually, and where no search got stuck.
        let wanted = to.z - self.legs_m;
        let off_m = poses.iter().map(|(_, f)| f.off_m).fold(0.0, f64::max);
        let arrives = (last.ground_m - wanted).abs() <= self.steps.climb_m;
        let is_open = |f: &Footed| f.room.is_wide && f.room.crouch_m == 0.0 && f.stuck == 0.0;
        let is_open = poses.iter().all(|(_, f)| is_open(f));
        let is_usual = is_open && off_m <= 0.5 * Steps::usual(self.context, self.legs_m).ahead_m;
        (arrives && is_usual).then_some(poses)
    }

    /// A way with straight lines where they cost no more.
    fn drawn_straight(
        &self,
        from: &(Pose, Footed),
        way: Vec<(Pose, Footed)>,
    ) -> Vec<(Pose, Footed)> {
        let all: Vec<(Pose, Footed)> = std::iter::once(*from).chain(way).collect();
        // What the way costs up to each pose.
        let mut spent = vec![0.0];
        for pair in all.windows(2) {
            let ((a, before), (b, now)) = (&pair[0], &pair[1]);
            let step = (b.p - a.p).xy();
            let price = self.price(&step, b.heading, wrap(b.heading - a.heading), before, now);
            spent.push(spent[spent.len() - 1] + price);
        }
        let mut drawn: Vec<(Pose, Footed)> = Vec::new();
        let (mut i, mut here) = (0, *from);
        while i + 1 < all.len() {
            let straight = (i + 2..all.len()).rev().find_map(|j| {
                let (to, _) = &all[j];
                let heading = (j + 1 == all.len()).then_some(to.heading);
                let (poses, price) = self.line(&here.0, here.1, &to.p.xy(), heading)?;
                // Not on another level, under what the way goes over.
                let off_m = poses.last()?.1.ground_m - all[j].1.ground_m;
                let arrives = off_m.abs() <= 0.5 * self.steps.climb_m;
                (arrives && price <= spent[j] - spent[i] + 1e-9).then_some((j, poses))
            });
            let (j, poses) = straight.unwrap_or_else(|| (i + 1, vec![all[i + 1]]));
            drawn.extend(poses);
            let Some(&last) = drawn.last() else { break };
            (i, here) = (j, last);
        }
        // Headings go on from one pose to the next.
        let mut facing = from.0.heading;
        for (pose, _) in &mut drawn {
            facing += wrap(pose.heading - facing);
            pose.heading = facing;
        }
        drawn
    }
}

/// Poses with their headings and heights evened out over their neighbours, but for the ends, and going down
/// before where they are low.
fn smooth(poses: Vec<Pose>) -> Vec<Pose> {
    /// Neighbours on each side.
    const SIDE: usize = 2;
    let last = poses.len() - 1;
    (0..=last)
        .map(|i| {
            let side = SIDE.min(i).min(last - i);
            let near = &poses[i - side..=i + side];
            let mean = |of: fn(&Pose) -> f64| near.iter().map(of).sum::<f64>() / near.len() as f64;
            Pose {
                p: Vector3::new(poses[i].p.x, poses[i].p.y, mean(|pose| pose.p.z)),
                heading: mean(|pose| pose.heading),
                crouch_m: poses.iter().fold(0.0, |m, pose| {
                    let apart_m = (pose.p - poses[i].p).xy().norm();
                    (pose.crouch_m - DOWN * apart_m).max(m)
                }),
            }
        })
        .collect()
}
