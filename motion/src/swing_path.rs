//! The path of a patch through the air: away along the normal of the surface it leaves, over what
//! lies between, down along the normal of the surface it lands on.
//!
//! Positions are a clamped cubic B-spline (C², inside the hull of its control points); the first
//! and last four control points lie on the normals, so its ends are straight. The orientation
//! turns between the straight parts only.

use std::ops::Range;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use posture::{Environment, FaceIndex};

use crate::Config;
use crate::problem::Swing;
use crate::time_scaling::quintic;

/// How far a patch moves straight along the normal of the surface that it leaves or lands on, m.
pub(crate) const STRAIGHT_M: f64 = 0.030;

/// Which path of many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    /// Height over the higher end, m.
    pub height_m: f64,
    /// Offset to the side halfway, m.
    pub aside_m: f64,
    /// Whether it follows its corners closely.
    pub tight: bool,
}

/// A path, parametrised by 0…1 at nearly even speed.
#[derive(Clone, Debug)]
pub(crate) struct SwingPath {
    control: Vec<Vector3<f64>>,
    knots: Vec<f64>,
    /// The control points that may be moved: those that are not on the normals of its ends.
    free: Range<usize>,
    from: UnitQuaternion<f64>,
    /// Rotation vector (in W) from the first orientation to the last.
    turn: Vector3<f64>,
    /// Where the orientation begins and ends to turn.
    turning: (f64, f64),
    /// How readily the patch turns from that far from its ends, beside the joints.
    freedom: f64,
    /// Length, m.
    pub length_m: f64,
}

/// The shapes that are tried, cheapest first.
pub(crate) fn shapes(config: &Config) -> impl Iterator<Item = Shape> {
    let low = config.swing_height_m;
    const HEIGHTS: [f64; 5] = [1.0, 1.6, 2.6, 4.0, 6.0];
    const ASIDE_M: [f64; 9] = [0.0, 0.04, -0.04, 0.08, -0.08, 0.12, -0.12, 0.18, -0.18];
    // Heights one after the other, each with its detours, then the close ones.
    let each = HEIGHTS.len() * ASIDE_M.len();
    (0..2 * each).map(move |i| Shape {
        height_m: HEIGHTS[i % each / ASIDE_M.len()] * low,
        aside_m: ASIDE_M[i % ASIDE_M.len()],
        tight: i >= each,
    })
}

impl SwingPath {
    pub fn new(environment: &Environment, swing: &Swing, shape: Shape) -> Self {
        let (p0, p1) = (swing.from.translation.vector, swing.to.translation.vector);
        let normal = |face: Option<FaceIndex>| face.map(|f| environment[f].normal_W());
        let (n0, n1) = (normal(swing.leaves), normal(swing.lands));
        // Height is counted along the mean of the normals.
        let sum = n0.unwrap_or_else(Vector3::zeros) + n1.unwrap_or_else(Vector3::zeros);
        let up = sum.try_normalize(0.2).unwrap_or_else(Vector3::z);
        let level = p0.dot(&up).max(p1.dot(&up)) + shape.height_m;
        // Along a normal to that level, but no farther than twice the height on leaning surfaces.
        let raised = |p: &Vector3<f64>, n: &Vector3<f64>| {
            let climb = level - p.dot(&up);
            n * (climb / n.dot(&up).max(0.5)).max(shape.height_m)
        };
        let foot = |p: Vector3<f64>, n: &Vector3<f64>| {
            let n = *n;
            (0..4).map(move |i| p + n * (0.55 * STRAIGHT_M * f64::from(i)))
        };
        let over = |p: Vector3<f64>, n: Option<Vector3<f64>>| match n {
            Some(n) => p + raised(&p, &n),
            // From the air, too, it first goes up to that level.
            None => p + up * (level - p.dot(&up)).max(0.0),
        };
        let (a, b) = (over(p0, n0), over(p1, n1));
        let aside = up.cross(&(p1 - p0)).try_normalize(1e-6);
        let aside = aside.unwrap_or_else(Vector3::zeros) * shape.aside_m;
        let copies = if shape.tight { 2 } else { 1 };
        let mut control = Vec::new();
        match &n0 {
            Some(n) => control.extend(foot(p0, n)),
            None => control.push(p0),
        }
        control.extend(std::iter::repeat_n(a + 0.5 * aside, copies));
        if swing.lands.is_some() || shape.aside_m != 0.0 {
            control.push(0.5 * (a + b) + aside);
        }
        match &n1 {
            Some(n) => {
                control.extend(std::iter::repeat_n(b + 0.5 * aside, copies));
                let landing: Vec<_> = foot(p1, n).collect();
                control.extend(landing.into_iter().rev());
            }
            None => control.push(p1),
        }
        while control.len() < 4 {
            let middle = 0.5 * (control[0] + control[1]);
            control.insert(1, middle);
        }
        let (first, last) = (n0.map_or(1, |_| 4), n1.map_or(1, |_| 4));
        let free = first..control.len().saturating_sub(last);
        let mut path = Self {
            free,
            ..Self::along(swing, control)
        };
        path.measure(n0.map(|n| (p0, n)), n1.map(|n| (p1, n)));
        path
    }

    /// Straight from one end to the other.
    pub fn straight(swing: &Swing) -> Self {
        let (p0, p1) = (swing.from.translation.vector, swing.to.translation.vector);
        let control = (0..4).map(|i| p0 + (p1 - p0) * (f64::from(i) / 3.0));
        Self {
            length_m: (p1 - p0).norm(),
            ..Self::along(swing, control.collect())
        }
    }

    /// A path with these control points that turns all along, of no known length.
    fn along(swing: &Swing, control: Vec<Vector3<f64>>) -> Self {
        let from = swing.from.rotation;
        Self {
            knots: knots(&control),
            control,
            free: 0..0,
            from,
            turn: (swing.to.rotation * from.inverse()).scaled_axis(),
            turning: (0.0, 1.0),
            freedom: STIFF,
            length_m: 0.0,
        }
    }

    /// The length, and where the straight ends are left.
    fn measure(
        &mut self,
        leave: Option<(Vector3<f64>, Vector3<f64>)>,
        land: Option<(Vector3<f64>, Vector3<f64>)>,
    ) {
        const PARTS: usize = 100;
        let points = (0..=PARTS).map(|i| self.position(i as f64 / PARTS as f64));
        let points: Vec<Vector3<f64>> = points.collect();
        self.length_m = points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let clear = |p: &Vector3<f64>, end: &Option<(Vector3<f64>, Vector3<f64>)>| {
            end.is_none_or(|(e, n)| (p - e).dot(&n) >= STRAIGHT_M)
        };
        let first = points.iter().position(|p| clear(p, &leave));
        let last = points.iter().rposition(|p| clear(p, &land));
        if let (Some(first), Some(last)) = (first, last)
            && first < last
        {
            self.turning = (first as f64 / PARTS as f64, last as f64 / PARTS as f64);
        }
    }

    /// Bends the path so that it is off by `offset` (m, W) at `u`, by the least change of its control
    /// points; whether it could, which near its straight ends it cannot.
    ///
    ///   min Σ ‖δ_i‖²   s.t.   Σ N_i(u) δ_i = offset      over the free control points
    pub fn bend(&mut self, u: f64, offset: &Vector3<f64>) -> bool {
        let (first, weights) = self.basis(u);
        let free = self.free.clone();
        let moved = (first..).zip(weights).filter(|(i, _)| free.contains(i));
        let square: f64 = moved.clone().map(|(_, w)| w * w).sum();
        if square < BENDING_MIN {
            return false;
        }
        for (i, w) in moved {
            self.control[i] += offset * (w / square);
        }
        true
    }

    /// Position at `u`.
    pub fn position(&self, u: f64) -> Vector3<f64> {
        let (first, weights) = self.basis(u);
        let control = self.control[first..].iter().zip(weights);
        control.map(|(point, weight)| point * weight).sum()
    }

    /// The first of the four control points that count at `u`, and their weights: the basis functions
    /// of the B-spline, by Cox's and de Boor's recursion.
    fn basis(&self, u: f64) -> (usize, [f64; 4]) {
        let u = u.clamp(0.0, 1.0);
        let last = self.control.len() - 1;
        let span = self.knots[4..=last].partition_point(|knot| *knot <= u) + 3;
        let mut weights = [1.0, 0.0, 0.0, 0.0];
        for degree in 1..4 {
            let mut carried = 0.0;
            for (j, weight) in weights.iter_mut().enumerate().take(degree) {
                let (low, high) = (self.knots[span + 1 + j - degree], self.knots[span + 1 + j]);
                let part = if high > low {
                    *weight / (high - low)
                } else {
                    0.0
                };
                *weight = carried + (high - u) * part;
                carried = (u - low) * part;
            }
            weights[degree] = carried;
        }
        (span - 3, weights)
    }

    /// Pose at `u`.
    pub fn pose(&self, u: f64) -> Isometry3<f64> {
        let (begin, end) = self.turning;
        let part = quintic((u - begin) / (end - begin).max(1e-6));
        let rotation = UnitQuaternion::new(self.turn * part) * self.from;
        Isometry3::from_parts(Translation3::from(self.position(u)), rotation)
    }
}

/// Sum of the squares of the free control points' weights below which a path cannot be bent.
const BENDING_MIN: f64 = 0.05;
/// How readily a patch turns from its path's orientation: hardly, as it then takes the least time, or as the
/// body needs it.
const STIFF: f64 = 0.02;
const FREE: f64 = 0.5;
/// Part of the path over which that freedom grows and ceases.
const EASE: f64 = 0.15;

impl SwingPath {
    /// How freely the patch may turn at `u`; not at all where it is near its ends.
    pub fn turn_freedom(&self, u: f64) -> f64 {
        let (begin, end) = self.turning;
        if begin <= 0.0 && end >= 1.0 {
            return 0.0;
        }
        let ease = quintic((u - begin) / EASE) * quintic((end - u) / EASE);
        self.freedom * ease
    }

    /// Lets the patch turn as the body needs it; whether that is anything new.
    pub fn turn_freely(&mut self) -> bool {
        let before = self.turn_freedom(0.5);
        self.freedom = FREE;
        self.turn_freedom(0.5) > before
    }
}

/// Clamped cubic knots: means of three of the control points' distances along their polygon.
fn knots(control: &[Vector3<f64>]) -> Vec<f64> {
    let mut along = vec![0.0];
    for pair in control.windows(2) {
        // Control points at one place keep a little of the parameter for themselves.
        along.push(along[along.len() - 1] + (pair[1] - pair[0]).norm().max(0.005));
    }
    let total = along[along.len() - 1];
    let mut knots = vec![0.0; 4];
    for i in 1..control.len().saturating_sub(3) {
        knots.push((along[i] + along[i + 1] + along[i + 2]) / (3.0 * total));
    }
    knots.extend([1.0; 4]);
    knots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn a_path_is_bent_by_what_is_asked_and_keeps_its_straight_ends() {
        let robot = scenes::builtin_robot("hrp2").unwrap();
        let robot = robot.load(&robot_model::Config::default()).unwrap();
        let swing = Swing {
            patch: robot.patch_id("left_foot").unwrap(),
            from: Isometry3::identity(),
            to: Isometry3::translation(0.4, 0.0, 0.2),
            leaves: None,
            lands: None,
            rolling: [None; 2],
        };
        let environment = Environment::default();
        let shape = Shape {
            height_m: 0.1,
            aside_m: 0.0,
            tight: false,
        };
        let path = SwingPath::new(&environment, &swing, shape);
        let offset = Vector3::new(-0.002, 0.01, 0.0);
        let mut bent = path.clone();
        assert!(bent.bend(0.4, &offset));
        let moved = bent.position(0.4) - path.position(0.4);
        assert!((moved - offset).norm() < 1e-12, "{moved}");
        for end in [0.0, 1.0] {
            assert!((bent.position(end) - path.position(end)).norm() < 1e-12);
        }
        assert!(!bent.bend(0.0, &offset));
    }
}
