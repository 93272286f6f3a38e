//! The way of the base: poses along the guide path, from the start's heading to the goal's.
//!
//! Between poses position and heading change together. A turn has a length too, so that a foot
//! that is turned makes progress like one that is put ahead:
//!
//!   s = ∫ |dp| + ρ |dψ|        with ρ the length of a stride over the angle of one
//!
//! A foot's *progress* is the s at which its usual place is nearest to where it is: at the start
//! every foot has progress 0, at the goal every foot has the route's length.

use nalgebra::{Rotation3, Vector3};

use crate::Guide;

/// Largest angle between neighbouring poses, rad: a foot's usual places in between are on a line.
const BEND_RAD: f64 = 0.15;
/// A metre sideways or backward costs as much as this many ahead.
const ASIDE: f64 = 2.0;
/// What an angle between a sole's heading and the route's counts beside a distance, m/rad.
const YAW_M: f64 = 0.25;
/// Poses of two routes nearer than this, headings counted in, are the same, m.
const SAME_M: f64 = 0.15;
/// Progress is looked for this far about where it is expected, m.
const WINDOW_M: f64 = 1.5;

/// A pose of the base on its way, upright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    /// Position in W, m.
    pub p: Vector3<f64>,
    /// Heading, rad, continuous along the route.
    pub heading: f64,
    /// How much lower than usual the base is, so that nothing overhead is in the way, m: `p` is without.
    pub crouch_m: f64,
}

impl Pose {
    /// Where a foot with that offset from the base belongs.
    pub fn foot(&self, offset: &Vector3<f64>) -> Vector3<f64> {
        self.p + Rotation3::from_axis_angle(&Vector3::z_axis(), self.heading) * offset
    }
}

/// The poses of the base on its way.
#[derive(Clone, Debug)]
pub(crate) struct Route {
    poses: Vec<Pose>,
    /// Route length at each pose, m.
    lengths: Vec<f64>,
}

impl Route {
    /// The route along a path, from a heading to another where one is wanted, rad; a turn of one
    /// radian counts as `turn_m`. It looks where it goes, or keeps its heading where that is
    /// shorter.
    pub fn new(guide: &Guide, start: f64, goal: Option<f64>, turn_m: f64) -> Self {
        let points = guide.points();
        let mut poses = vec![Pose {
            p: points[0],
            heading: start,
            crouch_m: 0.0,
        }];
        let mut heading = start;
        for (i, pair) in points.windows(2).enumerate() {
            let edge = pair[1] - pair[0];
            let (length, flat) = (edge.norm(), edge.xy().norm());
            let last = i + 2 == points.len();
            let turned = |from: f64, to: f64| turn_m * wrap(to - from).abs();
            let finally = |from: f64| match goal {
                Some(goal) if last => turned(from, goal),
                _ => 0.0,
            };
            if flat > 1e-6 {
                let along = edge.y.atan2(edge.x);
                let ahead = turned(heading, along) + length + finally(along);
                if ahead <= ASIDE * length + finally(heading) {
                    heading += wrap(along - heading);
                    poses.push(Pose {
                        p: pair[0],
                        heading,
                        crouch_m: 0.0,
                    });
                }
            }
            poses.push(Pose {
                p: pair[1],
                heading,
                crouch_m: 0.0,
            });
        }
        if let (Some(goal), Some(&last)) = (goal, poses.last()) {
            poses.push(Pose {
                heading: last.heading + wrap(goal - last.heading),
                ..last
            });
        }
        Self::through(&poses, turn_m)
    }

    /// The route through poses whose headings are continuous.
    pub fn through(poses: &[Pose], turn_m: f64) -> Self {
        let mut route = Self {
            poses: poses[..1].to_vec(),
            lengths: vec![0.0],
        };
        for pair in poses.windows(2) {
            let (step, turn) = (pair[1].p - pair[0].p, pair[1].heading - pair[0].heading);
            let length = step.norm() + turn_m * turn.abs();
            if length <= 0.0 {
                continue;
            }
            let from = route.length_m();
            let parts = (turn.abs() / BEND_RAD).ceil().max(1.0);
            for k in 1..=parts as usize {
                let t = k as f64 / parts;
                route.poses.push(Pose {
                    p: pair[0].p + step * t,
                    heading: pair[0].heading + turn * t,
                    crouch_m: pair[0].crouch_m + (pair[1].crouch_m - pair[0].crouch_m) * t,
                });
                route.lengths.push(from + length * t);
            }
        }
        route
    }

    /// Whether every pose of it is near to one of another route.
    pub fn is_along(&self, other: &Self) -> bool {
        let parts = (other.length_m() / SAME_M).ceil().max(1.0);
        let along = |k: usize| other.at(other.length_m() * k as f64 / parts);
        let others: Vec<Pose> = (0..=parts as usize).map(along).collect();
        self.poses.iter().all(|pose| {
            others.iter().any(|near| {
                let turned = wrap(pose.heading - near.heading);
                (pose.p - near.p).norm().hypot(YAW_M * turned) < SAME_M
            })
        })
    }

    /// Its poses.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Its length, turns included, m.
    pub fn length_m(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The pose after `along_m`; beyond the ends the end.
    pub fn at(&self, along_m: f64) -> Pose {
        let next = self.lengths.partition_point(|&l| l <= along_m);
        let (Some(a), Some(b)) = (next.checked_sub(1), self.poses.get(next)) else {
            let end = if next == 0 { 0 } else { self.poses.len() - 1 };
            return self.poses[end];
        };
        let t = (along_m - self.lengths[a]) / (self.lengths[next] - self.lengths[a]);
        let from = self.poses[a];
        Pose {
            p: from.p + (b.p - from.p) * t,
            heading: from.heading + (b.heading - from.heading) * t,
            crouch_m: from.crouch_m + (b.crouch_m - from.crouch_m) * t,
        }
    }

    /// The direction in which the base moves after `along_m`, level and of length 1; ahead where it
    /// turns on the spot.
    pub fn direction(&self, along_m: f64) -> Vector3<f64> {
        let next = self.lengths.partition_point(|&l| l <= along_m);
        let next = next.clamp(1, self.poses.len().max(2) - 1);
        let heading = self.at(along_m).heading;
        let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
        let step = match (self.poses.get(next - 1), self.poses.get(next)) {
            (Some(a), Some(b)) => b.p - a.p,
            _ => return ahead,
        };
        let flat = Vector3::new(step.x, step.y, 0.0);
        flat.try_normalize(1e-6).unwrap_or(ahead)
    }

    /// Where a foot with that offset belongs after `along_m`.
    pub fn foot_at(&self, along_m: f64, offset: &Vector3<f64>) -> Vector3<f64> {
        self.at(along_m).foot(offset)
    }

    /// The progress of a foot with that offset at a place, with a heading where it has one; about
    /// `near_m` where that is known.
    pub fn progress(
        &self,
        offset: &Vector3<f64>,
        place: &Vector3<f64>,
        yaw: Option<f64>,
        near_m: Option<f64>,
    ) -> f64 {
        let mut best = (f64::INFINITY, 0.0);
        for i in 1..self.poses.len() {
            let (from, to) = (self.lengths[i - 1], self.lengths[i]);
            if near_m.is_some_and(|near| to < near - WINDOW_M || from > near + WINDOW_M) {
                continue;
            }
            let (a, b) = (&self.poses[i - 1], &self.poses[i]);
            let (p, q) = (a.foot(offset), b.foot(offset));
            // Distance and angle together, as in a space of four dimensions.
            let (step, off) = (q - p, place - p);
            let turn = YAW_M * (b.heading - a.heading);
            let turned = yaw.map_or(0.0, |yaw| YAW_M * wrap(yaw - a.heading));
            let turn = if yaw.is_some() { turn } else { 0.0 };
            let length2 = step.norm_squared() + turn * turn;
            let t = if length2 > 0.0 {
                ((step.dot(&off) + turn * turned) / length2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let apart2 = (off - step * t).norm_squared() + (turned - turn * t).powi(2);
            if apart2 < best.0 {
                best = (apart2, from + (to - from) * t);
            }
        }
        best.1
    }
}

/// The heading of a direction, rad.
pub(crate) fn heading(direction: &Vector3<f64>) -> f64 {
    direction.y.atan2(direction.x)
}

/// The angle between −π and π.
pub(crate) fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn corner() -> Guide {
        Guide::new(vec![
            Vector3::zeros(),
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(1.0, 2.0, 0.0),
        ])
        .unwrap()
    }

    #[test]
    fn it_turns_where_the_path_does_and_a_foot_with_it() {
        let route = Route::new(&corner(), 0.0, Some(FRAC_PI_2), 0.5);
        assert!((route.length_m() - 3.0 - 0.5 * FRAC_PI_2).abs() < 1e-9);
        let offset = Vector3::new(0.0, 0.1, -0.6);
        for along in [0.2, 0.6, 1.1, 1.5, 2.9] {
            let heading = route.at(along).heading;
            let foot = route.foot_at(along, &offset);
            let found = route.progress(&offset, &foot, Some(heading), None);
            assert!((found - along).abs() < 0.02, "{along}: {found}");
        }
    }

    #[test]
    fn a_short_way_back_is_gone_backward_and_a_long_one_after_a_turn() {
        let back = |length: f64| {
            let end = Vector3::new(-length, 0.0, 0.0);
            let guide = Guide::new(vec![Vector3::zeros(), end]).unwrap();
            Route::new(&guide, 0.0, None, 0.7)
        };
        assert_eq!(back(0.3).at(0.2).heading, 0.0);
        let turned = back(5.0).at(4.0).heading;
        assert!((wrap(turned).abs() - std::f64::consts::PI).abs() < 1e-9);
        assert!(back(0.3).direction(0.1).x < 0.0);
    }

    #[test]
    fn a_turn_on_the_spot_has_a_length() {
        let guide = Guide::new(vec![Vector3::zeros(), Vector3::zeros()]).unwrap();
        let route = Route::new(&guide, 0.0, Some(-1.0), 0.6);
        assert!((route.length_m() - 0.6).abs() < 1e-9);
        assert!((route.at(0.3).heading + 0.5).abs() < 1e-9);
    }
}
