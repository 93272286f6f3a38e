//! The way of the base over the terrain: a shortest path on a coarse lattice of places, levels and
//! headings.
//!
//! The base may be where every foot finds a landing near its usual place below it and nothing
//! stands where the trunk is. It moves to the eight places around, or turns by an eighth; sideways
//! and backward cost more, and so do feet far from their usual places. What the lattice finds is
//! drawn straight where that costs no more.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};

use crate::context::SearchContext;
use crate::lattice::{CELL_M, CLIMB_LEGS, Footed, HEADINGS, LEVEL_M, Lattice, REACH_STRIDES};
use crate::route::Route;
use crate::route::{Pose, wrap};

/// States that are looked at before the search for a way ends without one.
const STATES_MAX: usize = 200_000;

/// A place of the lattice: cell, heading, level.
type State = (i64, i64, i64, i64);

/// What a search on the lattice finds.
enum Found {
    Way(Vec<(Pose, Footed)>),
    /// No way, and the place that comes nearest.
    Nearest(Vector2<f64>),
    /// Its budget is spent.
    Unknown,
}

/// What came of looking for a way.
enum Way {
    /// Straight from each point of the guide to the next, or not known to be otherwise.
    Straight,
    /// Through these poses.
    Round(Vec<Pose>),
    /// None on the lattice: where the base comes nearest to the point that it should pass next.
    None {
        nearest: Vector2<f64>,
        to: Vector2<f64>,
    },
}

/// The context with its route on the way of the base, or with the gap where there is none.
pub(crate) fn laid(mut context: SearchContext) -> SearchContext {
    match find(&context) {
        Way::Straight => {}
        Way::Round(poses) => context.route = Route::through(&poses, context.turn_m),
        Way::None { nearest, to } => context.gap = Some([nearest, to]),
    }
    context
}

/// The way of the base from the start through the guide's points.
fn find(context: &SearchContext) -> Way {
    let Some(lattice) = Lattice::new(context, context.turn_m) else {
        return Way::Straight;
    };
    match through(context, &lattice) {
        Ok(Some(poses)) => Way::Round(poses),
        Ok(None) => Way::Straight,
        Err([nearest, to]) => Way::None { nearest, to },
    }
}

/// The poses, where the way is not straight; where the base comes nearest to which point, where
/// there is none.
fn through(
    context: &SearchContext,
    lattice: &Lattice,
) -> Result<Option<Vec<Pose>>, [Vector2<f64>; 2]> {
    let goal_heading = context.request.goal.base.yaw_rad;
    let points = context.request.guide.points();
    let first = context.route.at(0.0);
    let ground_m = first.p.z - lattice.legs_m;
    let Some(start) = lattice.founded(&first.p.xy(), first.heading, ground_m) else {
        return Ok(None);
    };
    let mut poses = vec![(first, start)];
    let mut straight = true;
    for (i, to) in points.iter().enumerate().skip(1) {
        let last = i + 1 == points.len();
        let (from, footed) = poses[poses.len() - 1];
        let heading = goal_heading.filter(|_| last);
        let level = (to - from.p).z.abs() > 1e-6;
        let leg = lattice.straight(&from, footed.ground_m, to, heading);
        if let Some(leg) = leg {
            poses.extend(leg);
            continue;
        }
        straight = false;
        let to_level = level.then_some(to.z - lattice.legs_m);
        let leg = match lattice.shortest(&from, footed.ground_m, to, to_level, heading) {
            Found::Way(leg) => leg,
            Found::Nearest(nearest) => return Err([nearest, to.xy()]),
            Found::Unknown => return Ok(None),
        };
        poses.extend(lattice.drawn_straight(&poses[poses.len() - 1], leg));
    }
    if straight {
        return Ok(None);
    }
    let poses = poses.into_iter().map(|(pose, _)| pose).collect();
    Ok(Some(smooth(poses)))
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
            let parts = (length / CELL_M).ceil();
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
        // On the level that is wanted, with room and never far from where feet are usually.
        let wanted = to.z - self.legs_m;
        let off_m = poses.iter().map(|(_, f)| f.off_m).fold(0.0, f64::max);
        let arrives = (last.ground_m - wanted).abs() <= CLIMB_LEGS * self.legs_m;
        let is_wide = poses.iter().all(|(_, f)| f.is_wide);
        let is_usual = is_wide && off_m <= 0.5 * REACH_STRIDES * self.context.stride_m;
        (arrives && is_usual).then_some(poses)
    }

    /// The shortest way on the lattice to a point, in a heading where one is wanted.
    fn shortest(
        &self,
        from: &Pose,
        level_m: f64,
        to: &Vector3<f64>,
        to_level_m: Option<f64>,
        heading: Option<f64>,
    ) -> Found {
        let angle = |h: i64| h as f64 * TAU / HEADINGS as f64;
        let nearest = |heading: f64| (heading / angle(1)).round() as i64;
        let origin = from.p.xy();
        let at = |s: &State| origin + Vector2::new(s.0 as f64, s.1 as f64) * CELL_M;
        let level = |ground_m: f64| (ground_m / LEVEL_M).round() as i64;
        let Some(footed) = self.founded(&origin, from.heading, level_m) else {
            return Found::Unknown;
        };
        let h0 = nearest(from.heading).rem_euclid(HEADINGS);
        let first: State = (0, 0, h0, level(footed.ground_m));
        let wanted_heading = heading.map(|h| nearest(h).rem_euclid(HEADINGS));
        let is_there = |s: &State, f: &Footed| {
            (at(s) - to.xy()).norm() <= 0.75 * CELL_M
                && wanted_heading.is_none_or(|h| h == s.2)
                && to_level_m.is_none_or(|l| (f.ground_m - l).abs() <= CLIMB_LEGS * self.legs_m)
        };
        let rest = |s: &State| (at(s) - to.xy()).norm();
        let mut known: BTreeMap<State, (f64, State, Footed)> = BTreeMap::new();
        known.insert(first, (0.0, first, footed));
        let mut open = BinaryHeap::new();
        let bits = |x: f64| x.max(0.0).to_bits();
        open.push(Reverse((bits(rest(&first)), first)));
        let mut looked = 0;
        let mut done: BTreeMap<State, ()> = BTreeMap::new();
        let end = loop {
            let Some(Reverse((_, state))) = open.pop() else {
                let nearest = done.keys().min_by(|a, b| rest(a).total_cmp(&rest(b)));
                return nearest.map_or(Found::Unknown, |state| Found::Nearest(at(state)));
            };
            if done.insert(state, ()).is_some() {
                continue;
            }
            looked += 1;
            if looked > STATES_MAX {
                return Found::Unknown;
            }
            let (price, _, footed) = known[&state];
            if is_there(&state, &footed) {
                break state;
            }
            let (x, y, h, _) = state;
            let moves = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy, 0)));
            let moves = moves.filter(|m| *m != (0, 0, 0));
            for (dx, dy, dh) in moves.chain([(0, 0, 1), (0, 0, -1)]) {
                let h = (h + dh).rem_euclid(HEADINGS);
                let mut next: State = (x + dx, y + dy, h, 0);
                let Some(there) = self.founded(&at(&next), angle(h), footed.ground_m) else {
                    continue;
                };
                next.3 = level(there.ground_m);
                let step = Vector2::new(dx as f64, dy as f64) * CELL_M;
                let turn = dh as f64 * angle(1);
                let price = price + self.price(&step, angle(h), turn, &footed, &there);
                if known.get(&next).is_none_or(|(best, _, _)| price < *best) {
                    known.insert(next, (price, state, there));
                    open.push(Reverse((bits(price + rest(&next)), next)));
                }
            }
        };
        let mut states = vec![end];
        while let Some(&last) = states.last().filter(|s| **s != first) {
            states.push(known[&last].1);
        }
        states.reverse();
        let mut facing = from.heading;
        let mut poses = Vec::new();
        for state in states.iter().skip(1) {
            facing += wrap(angle(state.2) - facing);
            let footed = known[state].2;
            let p = at(state);
            poses.push((
                Pose {
                    p: Vector3::new(p.x, p.y, footed.ground_m + self.legs_m),
                    heading: facing,
                },
                footed,
            ));
        }
        // The last place is the point itself, where it is founded as well.
        if let Some((pose, before)) = poses.last_mut()
            && let Some(footed) =
                self.founded(&to.xy(), heading.unwrap_or(pose.heading), before.ground_m)
        {
            pose.p = Vector3::new(to.x, to.y, footed.ground_m + self.legs_m);
            if let Some(heading) = heading {
                pose.heading += wrap(heading - pose.heading);
            }
            *before = footed;
        }
        Found::Way(poses)
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
                (price <= spent[j] - spent[i] + 1e-9).then_some((j, poses))
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

/// Poses with their headings and heights evened out over their neighbours, but for the ends.
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
            }
        })
        .collect()
}
