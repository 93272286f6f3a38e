//! Where the base may be: how its feet would stand there, how much room there is, and what a move costs.

use std::f64::consts::TAU;

use nalgebra::{Rotation2, Vector2, Vector3};

use crate::context::SearchContext;
use crate::ground::{Ground, Stands};
use crate::reach::Leg;
use crate::room::{OVER_LEGS, Room, Rooms};

/// Number of headings.
pub(crate) const HEADINGS: i64 = 8;
/// Directions in which the base is held over its feet.
const AROUND: usize = 8;
/// A metre sideways or backward costs as much as this many ahead.
const ASIDE: f64 = 2.0;
/// What a metre of a foot's distance from its usual place adds to the price of a metre.
const OFF_PLACE: f64 = 5.0;
/// A metre without room for all of the robot costs as much as this many.
const TIGHT: f64 = 4.0;
/// What crouching by all of the legs' height adds to the price of a metre.
const CROUCH: f64 = 5.0;
/// Price of a metre up or down.
const CLIMB: f64 = 2.0;
/// What a search that got stuck at a place adds to the price of a metre and of a turn there, and how far about it, falling
/// off evenly, in parts of the legs' height.
const STUCK: f64 = 6.0;
const STUCK_LEGS: f64 = 2.0;

/// What a way is chosen by beside its length.
#[derive(Clone, Debug)]
pub(crate) struct Preference {
    /// What a metre by which the ground is higher under one of two feet than under the other adds to the price of a metre
    /// and of a turn.
    pub uneven: f64,
    /// Where the base was to go next on other ways when the search got stuck, in W, m.
    pub stuck_W: Vec<Vector3<f64>>,
}

/// How the feet step, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    /// How far ahead of or behind its usual place a foot is put, and how far sideways.
    pub ahead_m: f64,
    aside_m: f64,
    /// How far up or down from the mean of the feet.
    pub climb_m: f64,
    /// How high things are that are stepped over.
    over_m: f64,
}

impl Steps {
    /// As a person would call usual, on legs of that height.
    pub fn usual(context: &SearchContext, legs_m: f64) -> Self {
        let ahead_m = 0.85 * context.stride_m;
        let (ahead_m, aside_m) = match context.feet.len() {
            0..=2 => (ahead_m, 0.1),
            // Of many feet none needs to pass another or to carry the body alone: half of what it reaches.
            _ => {
                let legs = context.feet.iter().map(|f| context.reach.leg(*f));
                let most_m = legs.fold(ahead_m, |m, leg| m.max(0.5 * leg.range_m(0.0)));
                (most_m, most_m)
            }
        };
        Self {
            ahead_m,
            aside_m,
            climb_m: 0.45 * legs_m,
            over_m: OVER_LEGS * legs_m,
        }
    }

    /// As long and as high as stretched legs under a body that is a fifth lower than usual. Of two feet one
    /// carries the body while the other lands: both together are no farther apart than the one leg
    /// reaches from over the tip of the other's sole.
    pub fn longest(context: &SearchContext, legs_m: f64) -> Self {
        let legs = context.feet.iter().map(|f| context.reach.leg(*f));
        let range_m = |low: f64, leg: &Leg| {
            let height_m = low * leg.height_m;
            (leg.length_m.powi(2) - height_m.powi(2)).max(0.0).sqrt()
        };
        let range_m = legs
            .clone()
            .map(|leg| range_m(0.8, leg))
            .fold(0.0, f64::max);
        let up_m = legs.map(|leg| leg.length_m - 0.25 * leg.height_m);
        let tip_m = tip_m(context) + 0.1 * legs_m;
        let ahead_m = match context.feet.len() {
            0..=2 => 0.5 * (range_m + tip_m),
            _ => range_m,
        };
        let usual = Self::usual(context, legs_m);
        Self {
            ahead_m: ahead_m.max(usual.ahead_m),
            aside_m: (0.5 * ahead_m).max(usual.aside_m),
            climb_m: up_m.fold(usual.climb_m, f64::max),
            over_m: 0.8 * legs_m,
        }
    }

    /// The longest step, from one foot's usual place behind to another's ahead, m.
    pub fn length_m(&self) -> f64 {
        2.0 * self.ahead_m
    }
}

/// How far a foot's tip is from the middle of its patch, m.
fn tip_m(context: &SearchContext) -> f64 {
    let patches = &context.request.robot.patches;
    let corners = context.feet.iter().flat_map(|f| &patches[*f].polygon);
    corners.map(|p| p.coords.norm()).fold(0.0, f64::max)
}

/// What the lattice asks of the world.
pub(crate) struct Lattice<'a> {
    pub context: &'a SearchContext<'a>,
    ground: Ground<'a>,
    rooms: Rooms<'a>,
    /// Height of the base over the ground, m.
    pub legs_m: f64,
    pub steps: Steps,
    preference: &'a Preference,
    /// How far the base is beside what carries it at most, m.
    lean_m: f64,
    /// Where a foot may be from its usual place (ahead, left), the nearest first.
    spread: Vec<Vector2<f64>>,
}

/// How well a state is founded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footed {
    /// Mean height of the ground under the feet, m.
    pub ground_m: f64,
    /// Mean distance of the feet from their usual places, m.
    pub off_m: f64,
    /// How much higher the ground is under one of two feet than under the other, m.
    pub uneven_m: f64,
    /// How much room there is about the base.
    pub room: Room,
    /// What searches that got stuck near there add to the price of a metre.
    pub stuck: f64,
}

impl<'a> Lattice<'a> {
    /// With feet that step as `steps` says of legs of a height; nothing where there are none.
    pub fn new(
        context: &'a SearchContext<'a>,
        steps: fn(&SearchContext, f64) -> Steps,
        stands: Stands,
        preference: &'a Preference,
    ) -> Option<Self> {
        let feet = &context.feet;
        let legs = feet.iter().map(|f| -context.offset(*f).z);
        let legs_m = legs.sum::<f64>() / feet.len().max(1) as f64;
        if legs_m <= 0.0 {
            return None;
        }
        let steps = steps(context, legs_m);
        let ground = Ground::new(context, stands);
        let step = |most: f64| (most / ground.cell_m) as i64;
        let mut spread: Vec<Vector2<f64>> = Vec::new();
        for i in -step(steps.ahead_m)..=step(steps.ahead_m) {
            for j in -step(steps.aside_m)..=step(steps.aside_m) {
                spread.push(Vector2::new(i as f64, j as f64) * ground.cell_m);
            }
        }
        spread.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        Some(Self {
            context,
            ground,
            rooms: Rooms::new(context, legs_m, steps.over_m),
            legs_m,
            steps,
            preference,
            lean_m: tip_m(context) + 0.1 * legs_m,
            spread,
        })
    }

    /// How the feet stand with the base at a place, about a level of the ground, each as near to it as it may; nothing
    /// where one finds no landing or the trunk no room.
    pub fn founded(&self, p: &Vector2<f64>, heading: f64, level_m: f64) -> Option<Footed> {
        self.stood(p, heading, level_m, 0.0, &mut false)
    }

    /// All ways for the feet to stand there: as near to the level as they may, and, where one of them has a choice (under
    /// a tread or on it), each as high, and each as low.
    pub fn all_founded(&self, p: &Vector2<f64>, heading: f64, level_m: f64) -> Vec<Footed> {
        let mut has_choice = false;
        let nearest = self.stood(p, heading, level_m, 0.0, &mut has_choice);
        let mut all: Vec<Footed> = nearest.into_iter().collect();
        for leaning in [1.0, -1.0].into_iter().filter(|_| has_choice) {
            let other = self.stood(
                p,
                heading,
                level_m,
                leaning * self.steps.climb_m,
                &mut false,
            );
            let is_new = |f: &Footed| all.iter().all(|known| known.ground_m != f.ground_m);
            all.extend(other.filter(is_new));
        }
        all
    }

    /// How the feet stand about a level of the ground, each where it is nearest to what lies over that by `leaning_m`;
    /// `has_choice` becomes true where one could stand on another level too.
    fn stood(
        &self,
        p: &Vector2<f64>,
        heading: f64,
        level_m: f64,
        leaning_m: f64,
        has_choice: &mut bool,
    ) -> Option<Footed> {
        let climb_m = self.steps.climb_m;
        let wanted_m = level_m + leaning_m;
        let turn = Rotation2::new(heading);
        let (mut ground_m, mut off_m) = (0.0, 0.0);
        let (mut lowest_m, mut highest_m) = (f64::INFINITY, f64::NEG_INFINITY);
        // How far the feet are from the base in each direction.
        let mut around_m = [f64::NEG_INFINITY; AROUND];
        for &foot in &self.context.feet {
            let usual = p + turn * self.context.offset(foot).xy();
            let (height_m, off) = self.spread.iter().find_map(|off| {
                let off = turn * off;
                let nearest = self.ground.at(foot, &(usual + off), |heights| {
                    let heights = heights.iter().copied();
                    let within = heights.filter(|height| (height - level_m).abs() <= climb_m);
                    *has_choice |= within.clone().count() > 1;
                    within.min_by(|a, b| (a - wanted_m).abs().total_cmp(&(b - wanted_m).abs()))
                })?;
                Some((nearest, off))
            })?;
            ground_m += height_m;
            (lowest_m, highest_m) = (height_m.min(lowest_m), height_m.max(highest_m));
            off_m += off.norm();
            for (k, most) in around_m.iter_mut().enumerate() {
                let (sin, cos) = (k as f64 * TAU / AROUND as f64).sin_cos();
                *most = most.max((usual + off - p).dot(&Vector2::new(cos, sin)));
            }
        }
        // The base is over what the feet carry.
        if around_m.iter().any(|&most| most < -self.lean_m) {
            return None;
        }
        let count = self.context.feet.len() as f64;
        let ground_m = ground_m / count;
        let room = self.rooms.at(p, ground_m)?;
        let base = p.push(ground_m + self.legs_m);
        let stuck = |place: &Vector3<f64>| {
            let apart = (place - base).norm() / (STUCK_LEGS * self.legs_m);
            STUCK * (1.0 - apart).max(0.0)
        };
        Some(Footed {
            ground_m,
            off_m: off_m / count,
            // More feet need not turn on one of them.
            uneven_m: match self.context.feet.len() {
                0..=2 => highest_m - lowest_m,
                _ => 0.0,
            },
            room,
            stuck: self.preference.stuck_W.iter().map(stuck).sum(),
        })
    }

    /// The price of a move between founded places.
    pub fn price(
        &self,
        step: &Vector2<f64>,
        heading: f64,
        turn: f64,
        from: &Footed,
        to: &Footed,
    ) -> f64 {
        let length = step.norm();
        let ahead = if length > 0.0 {
            step.dot(&Vector2::new(heading.cos(), heading.sin())) / length
        } else {
            1.0
        };
        let aside = 1.0 + (ASIDE - 1.0) * (1.0 - ahead).min(1.0);
        let tight = if to.room.is_wide { 1.0 } else { TIGHT };
        let low = CROUCH * to.room.crouch_m / self.legs_m;
        let ground = 1.0 + self.preference.uneven * to.uneven_m + to.stuck;
        length * aside * tight * (ground + OFF_PLACE * to.off_m + low)
            + self.context.turn_m * turn.abs() * ground
            + CLIMB * (to.ground_m - from.ground_m).abs()
    }
}
