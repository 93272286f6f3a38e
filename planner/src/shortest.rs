//! Shortest ways on the lattice: A* over places, headings and levels.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};

use crate::lattice::{Footed, HEADINGS, Lattice};
use crate::route::{Pose, wrap};

/// States that are looked at before the search for a way ends without one.
const STATES_MAX: usize = 200_000;

/// What a metre that is left to a point costs as much as, of a way that ends beside it.
const BESIDE: f64 = 2.0;

/// A place of the lattice: cell, heading, level.
type State = (i64, i64, i64, i64);
/// The end of a way, behind whatever place it ends at.
const END: State = (i64::MAX, 0, 0, 0);

/// What a search on the lattice finds.
pub(crate) enum Found {
    Way(Vec<(Pose, Footed)>),
    /// No way, and all places that are come to: on the ground, in W.
    Reached(Vec<Vector3<f64>>),
    /// Its budget is spent.
    Unknown,
}

impl Lattice<'_> {
    /// The shortest way on the lattice to a point, or no farther beside it than `beside_m`, in a heading
    /// where one is wanted.
    pub fn shortest(
        &self,
        from: &Pose,
        level_m: f64,
        to: &Vector3<f64>,
        beside_m: f64,
        to_level_m: Option<f64>,
        heading: Option<f64>,
    ) -> Found {
        let angle = |h: i64| h as f64 * TAU / HEADINGS as f64;
        let nearest = |heading: f64| (heading / angle(1)).round() as i64;
        let origin = from.p.xy();
        let (places_m, levels_m) = (self.context.places_m(), self.context.levels_m());
        let at = |s: &State| origin + Vector2::new(s.0 as f64, s.1 as f64) * places_m;
        let level = |ground_m: f64| (ground_m / levels_m).round() as i64;
        let Some(footed) = self.founded(&origin, from.heading, level_m) else {
            return Found::Unknown;
        };
        let h0 = nearest(from.heading).rem_euclid(HEADINGS);
        let first: State = (0, 0, h0, level(footed.ground_m));
        let wanted_heading = heading.map(|h| nearest(h).rem_euclid(HEADINGS));
        let is_there = |s: &State, f: &Footed| {
            (at(s) - to.xy()).norm() <= beside_m.max(0.75 * places_m)
                && wanted_heading.is_none_or(|h| h == s.2)
                && to_level_m.is_none_or(|l| (f.ground_m - l).abs() <= self.steps.climb_m)
        };
        let apart = |s: &State| (at(s) - to.xy()).norm();
        let mut known: BTreeMap<State, (f64, State, Footed)> = BTreeMap::new();
        known.insert(first, (0.0, first, footed));
        let mut open = BinaryHeap::new();
        let bits = |x: f64| x.max(0.0).to_bits();
        open.push(Reverse((bits(apart(&first)), first)));
        let mut looked = 0;
        let mut done: BTreeSet<State> = BTreeSet::new();
        // A place is come to from those around, mostly of one level.
        let mut places: BTreeMap<(i64, i64, i64, u64), Vec<Footed>> = BTreeMap::new();
        let end = loop {
            let Some(Reverse((_, state))) = open.pop() else {
                let mut cells: BTreeMap<(i64, i64), Vector3<f64>> = BTreeMap::new();
                for s in &done {
                    let place = at(s).push(known[s].2.ground_m);
                    cells.entry((s.0, s.1)).or_insert(place);
                }
                return Found::Reached(cells.into_values().collect());
            };
            if !done.insert(state) {
                continue;
            }
            looked += 1;
            if looked > STATES_MAX {
                return Found::Unknown;
            }
            let (price, last, footed) = known[&state];
            if state == END {
                break last;
            }
            if is_there(&state, &footed) {
                let price = price + BESIDE * apart(&state);
                if known.get(&END).is_none_or(|(best, ..)| price < *best) {
                    known.insert(END, (price, state, footed));
                    open.push(Reverse((bits(price), END)));
                }
            }
            let (x, y, h, _) = state;
            let moves = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy, 0)));
            let moves = moves.filter(|m| *m != (0, 0, 0));
            for (dx, dy, dh) in moves.chain([(0, 0, 1), (0, 0, -1)]) {
                let h = (h + dh).rem_euclid(HEADINGS);
                let cell = (x + dx, y + dy, h, 0);
                let place = (cell.0, cell.1, h, footed.ground_m.to_bits());
                let all = places
                    .entry(place)
                    .or_insert_with(|| self.all_founded(&at(&cell), angle(h), footed.ground_m));
                for there in all.iter() {
                    let next: State = (cell.0, cell.1, h, level(there.ground_m));
                    let step = Vector2::new(dx as f64, dy as f64) * places_m;
                    let turn = dh as f64 * angle(1);
                    let price = price + self.price(&step, angle(h), turn, &footed, there);
                    if known.get(&next).is_none_or(|(best, _, _)| price < *best) {
                        known.insert(next, (price, state, *there));
                        open.push(Reverse((bits(price + apart(&next)), next)));
                    }
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
                    crouch_m: footed.room.crouch_m,
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
}
