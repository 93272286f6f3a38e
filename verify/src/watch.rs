//! Two bodies that move: how near they come, at every time.
//!
//! A gap along a direction shrinks by no more than the bodies move. Where that is not enough, the gap
//! along the same direction at both ends of a step bounds it in between,
//!
//!   gap(t)  ≥  min(gap(before), gap(now)) − bends,
//!
//! and where that is not enough either, the step is halved.

use nalgebra::Vector3;

use crate::distance::{gap, signed_distance};
use crate::solid::Placed;
use crate::step::{Moment, Step};

/// How often a step is halved: its bends are then 4⁻⁸ of what they were.
const HALVINGS: usize = 8;

/// What a shape of the robot is watched against.
#[derive(Clone, Copy)]
pub(crate) enum Other<'a> {
    /// What stands where it is.
    Still(&'a Placed<'a>),
    /// Another shape.
    Shape(usize),
}

/// A shape and what it is watched against, at any moment.
#[derive(Clone, Copy)]
pub(crate) struct Two<'a>(pub usize, pub Other<'a>);

impl Two<'_> {
    /// Calls with both bodies as they are.
    fn with<T>(&self, moment: &Moment, call: impl FnOnce(&Placed, &Placed) -> T) -> T {
        let a = &moment.shapes[self.0];
        match self.1 {
            Other::Still(b) => call(a, b),
            Other::Shape(j) => call(a, &moment.shapes[j]),
        }
    }

    /// Whether a plane that leans from another by no more than an angle, rad, parts the two but for a bound,
    /// m, at every time of a step; `toward` is the other's normal, from the first to the second.
    pub fn parted(&self, step: &Step, toward: &Vector3<f64>, most_rad: f64, bound: f64) -> bool {
        let bends = step.before.map_or(0.0, |_| self.sum(step.bends_m));
        let (_, nearest) = self.with(step.now, |a, b| {
            signed_distance(a, b, &[*toward], f64::INFINITY)
        });
        let aside = nearest - toward * nearest.dot(toward);
        let along = match (nearest.angle(toward) > most_rad, aside.try_normalize(0.0)) {
            (true, Some(aside)) => toward * most_rad.cos() + aside * most_rad.sin(),
            _ => nearest,
        };
        let apart = |moment| self.with(moment, |a, b| gap(a, b, &along)) - bends >= bound;
        apart(step.now) && step.before.is_none_or(apart)
    }

    /// A number of both shapes added up.
    fn sum(&self, of: &[f64]) -> f64 {
        of[self.0]
            + match self.1 {
                Other::Still(_) => 0.0,
                Other::Shape(j) => of[j],
            }
    }
}

/// What was found at the last look.
#[derive(Clone, Copy)]
pub(crate) struct Watch {
    gap: f64,
    /// How far both had come by then, m.
    moved: f64,
    /// The direction of the gap; none where it is that of boxes around the bodies.
    along: Option<Vector3<f64>>,
}

/// What is asked of two bodies, m.
pub(crate) struct Asked {
    /// What they must keep.
    pub bound: f64,
    /// More than this need not be told.
    pub enough: f64,
    /// Boxes that are farther apart need no look at what is in them.
    pub far: f64,
}

impl Watch {
    /// Before the first look.
    pub fn new() -> Self {
        Self {
            gap: f64::NEG_INFINITY,
            moved: 0.0,
            along: None,
        }
    }

    /// A distance that is worth telling, m: of the bodies now, or one that they come to during the
    /// step and must not; `None` where it is known to be more than is asked, at every time of the step.
    ///
    /// `boxes` is a distance between boxes around the bodies now.
    pub fn look(
        &mut self,
        two: Two,
        step: &Step,
        asked: &Asked,
        hints: &[Vector3<f64>],
        boxes: impl Fn() -> f64,
    ) -> Option<f64> {
        let moved = two.sum(&step.now.moved);
        let since = |at: f64, gap: f64| gap - (at - self.moved);
        let bends = step.before.map_or(0.0, |_| two.sum(step.bends_m));
        let known = match self.along {
            Some(_) => asked.enough,
            None => asked.enough.min(asked.far),
        };
        // At this moment enough, and during the step what must be kept.
        let kept = |now: f64, least: f64, enough: f64| now > enough && least - bends >= asked.bound;
        let now = since(moved, self.gap);
        if kept(now, now, known) {
            return None;
        }
        let moved_before = step.before.map_or(moved, |before| two.sum(&before.moved));
        let boxes = boxes();
        let far = asked.enough.min(asked.far);
        if kept(boxes, boxes - (moved - moved_before), far) {
            (self.gap, self.moved, self.along) = (boxes, moved, None);
            return None;
        }
        if let Some(along) = &self.along {
            let now = two.with(step.now, |a, b| gap(a, b, along));
            let before = |before| two.with(before, |a, b| gap(a, b, along));
            let least = since(moved_before, self.gap);
            if kept(now, now.min(least), asked.enough)
                || kept(now, now.min(step.before.map_or(now, before)), asked.enough)
            {
                (self.gap, self.moved) = (now, moved);
                return None;
            }
        }
        let last = self.along;
        let tried: Vec<Vector3<f64>> = last.iter().chain(hints).copied().collect();
        let most = asked.enough.max(asked.bound + bends);
        let (now, along) = two.with(step.now, |a, b| signed_distance(a, b, &tried, most));
        (self.gap, self.moved, self.along) = (now, moved, Some(along));
        let Some(start) = step.before.filter(|_| now >= asked.bound) else {
            return Some(now);
        };
        let bound = asked.bound;
        let halving = Halving {
            two,
            step,
            tried: &tried,
            bound,
        };
        let least = halving.least([start, step.now], bends, [0.0, 1.0], HALVINGS);
        Some(if least >= bound { now } else { least })
    }
}

/// A step that is looked at more closely.
struct Halving<'a, 's> {
    two: Two<'a>,
    step: &'a Step<'s>,
    /// Directions to begin with.
    tried: &'a [Vector3<f64>],
    bound: f64,
}

impl Halving<'_, '_> {
    /// A bound of the distance during a part of the step, m: not under `bound` where that can be told.
    fn least(&self, ends: [&Moment; 2], bends: f64, part: [f64; 2], left: usize) -> f64 {
        let (two, bound) = (self.two, self.bound);
        let mut best = f64::NEG_INFINITY;
        for end in ends {
            let (distance, along) = two.with(end, |a, b| {
                signed_distance(a, b, self.tried, bound + 2.0 * bends)
            });
            if distance < bound {
                return distance;
            }
            let gaps = ends.map(|moment| two.with(moment, |a, b| gap(a, b, &along)));
            best = best.max(gaps[0].min(gaps[1]) - bends);
            if best >= bound {
                return best;
            }
        }
        let middle = 0.5 * (part[0] + part[1]);
        let Some(moment) = (left > 0).then(|| (self.step.at)(middle)).flatten() else {
            return best;
        };
        let first = self.least([ends[0], &moment], bends / 4.0, [part[0], middle], left - 1);
        match first < bound {
            true => first,
            false => {
                first.min(self.least([&moment, ends[1]], bends / 4.0, [middle, part[1]], left - 1))
            }
        }
    }
}
