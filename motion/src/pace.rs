//! Phases in time: as fast as the robot's limits allow along its path.
//!
//!   q = q(s(t)),  v = q' ṡ,  a = q' s̈ + q'' ṡ²
//!
//! What a body needs, what contacts bear and what joints exert are then constant, linear in s̈ and linear
//! in ṡ²; so is every limit.

mod chain;
mod dynamics;
mod limits;
mod smoothing;
mod standing;

use std::f64::consts::PI;

use nalgebra::{DVector, Matrix3, Matrix3x6, Vector3, Vector6};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics};

use crate::interpolation::{Curve, Instant};
use crate::inverse_dynamics::PathDynamics;
use crate::load_shares::LoadShares;
use crate::problem::MotionContext;
use crate::segment::PhaseTrajectory;
use crate::time_law::Row;
pub(crate) use chain::{least_s, samples};
use dynamics::between;
pub(crate) use standing::stands;

/// Pieces of a phase's path at most, along which its limits are nearly linear: what is sharper is found by the samples
/// of the law. Those at whose ends forces are suited to it; the others are a multiple, as a phase's samples are.
pub(crate) const PLACES: usize = 160;
const SUITED: usize = 80;
/// For how much more than a law needs forces are suited to it.
const FARTHER: f64 = 1.5;
/// Part of the weight below which what is needed has no direction.
const SLIGHT: f64 = 0.01;
/// A point that bears less at rest takes nothing, N.
const UNLOADED_N: f64 = 1e-3;
/// Part of the width of a friction cone that is inside of its eight sides.
const CONE_INSIDE: f64 = 0.923_879_532_511_286_7;
/// A law that exceeds its limits by no more than this part is kept: of a contact that keeps a tenth of its
/// load, ten times as much of its friction.
const OVER: f64 = 2e-4;

/// Where on its path the place `i` of `n` of a phase is: a law of constant accelerations goes from each to the next
/// in nearly the same time.
fn place_s(i: usize, n: usize) -> f64 {
    0.5 - 0.5 * (PI * i as f64 / n as f64).cos()
}

/// How many places are before `s`, in parts of one too.
fn places_before(s: f64, n: usize) -> f64 {
    (1.0 - 2.0 * s.clamp(0.0, 1.0)).acos() / PI * n as f64
}

/// The whole body at one sample of a motion.
pub(crate) struct Paced {
    pub q: Configuration,
    pub v: DVector<f64>,
    pub a: DVector<f64>,
    pub tau: Vec<f64>,
    pub com_W: Vector3<f64>,
    /// Force at each force point of each closed contact, N.
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// Whatever is constant, linear in s̈ and linear in ṡ² at one place of a path.
type Parts<T> = [T; 3];

/// The dynamics of a phase at one place of its path.
struct Place {
    path: Instant,
    com_W: Vector3<f64>,
    /// Where the contacts' points are, in W.
    points_W: Vec<Vector3<f64>>,
    /// Force and moment about the centre of mass that are needed, N and N·m.
    needs: Parts<Vector6<f64>>,
    /// Force at each point at rest as the postures have it, N, and how hard it presses there.
    at_rest: Vec<Vector3<f64>>,
    loads: Vec<f64>,
    /// Torque that each joint would exert if nothing were touched, N·m or N, its axis and its origin.
    bare: Vec<Parts<f64>>,
    joints_W: Vec<[Vector3<f64>; 2]>,
    /// Force at each point, N.
    forces_W: Vec<Parts<Vector3<f64>>>,
    /// Torque of each joint, N·m or N.
    tau: Vec<Parts<f64>>,
    /// How fast the fastest centre of mass of a body moves, over ṡ.
    speed: f64,
    /// How fast the patch in the air moves over ṡ, and how far it is from its landing.
    landing: Option<(f64, f64)>,
}

/// Forces of the points without a resultant, linear in what is needed beyond rest and over what each point
/// bears at rest, so that contacts bear it better than by their shares alone.
type Lean = Vec<Matrix3x6<f64>>;

/// The dynamics of one phase.
pub(crate) struct Pace<'a> {
    context: &'a MotionContext<'a>,
    phase: &'a PhaseTrajectory,
    curve: Curve,
    shares: LoadShares,
    /// The axes along which the sides of each contact's cone stand, in W.
    cone_axes: Vec<Matrix3<f64>>,
    kinematics: Kinematics,
    dynamics: PathDynamics,
    /// Working memory: forces of the postures, what holds the body against gravity, and limits.
    still_W: Vec<Vec<Vector3<f64>>>,
    gravity: DVector<f64>,
    memory: Vec<Row>,
}

impl<'a> Pace<'a> {
    pub fn new(context: &'a MotionContext<'a>, phase: &'a PhaseTrajectory) -> Self {
        let curve = phase.curve();
        Self {
            kinematics: Kinematics::new(context.robot, &curve.at(0.0).q),
            dynamics: PathDynamics::default(),
            still_W: Vec::new(),
            gravity: DVector::zeros(context.robot.nv()),
            memory: Vec::new(),
            shares: LoadShares::new(context, &phase.task.closed),
            cone_axes: phase
                .task
                .closed
                .iter()
                .map(|c| limits::cone_axes(context, c))
                .collect(),
            curve,
            context,
            phase,
        }
    }

    /// The dynamics at the ends of so many pieces of the path, of no more than there are between its samples, borne by
    /// nothing yet.
    fn places(&mut self, pieces: usize) -> Vec<Place> {
        let n = pieces.min(self.phase.samples.len() - 1);
        (0..=n).map(|i| self.going(place_s(i, n))).collect()
    }

    /// The limits at places of the whole path where forces lean like this; `known` are those at equal steps of the
    /// places, or none.
    fn limited(
        &self,
        places: &mut [Place],
        leans: &[Lean],
        mut known: Vec<Vec<Row>>,
    ) -> Vec<Vec<Row>> {
        let n = places.len() - 1;
        let every = n / known.len().saturating_sub(1).clamp(1, n);
        let mut rows = Vec::new();
        let all = places.iter_mut().enumerate().map(|(i, place)| {
            match known.get_mut(i / every).filter(|_| i % every == 0) {
                Some(known) => std::mem::take(known),
                None => {
                    self.bear(place, &between(leans, place_s(i, n)));
                    self.limits(place, &mut rows)
                }
            }
        });
        all.collect()
    }

    /// How the forces should lean at a place that is gone through like this.
    fn lean(&self, place: &Place, rate: f64, bend: f64) -> Lean {
        let [rest, a, b] = &place.needs;
        let w = a * bend + b * rate * rate;
        let still = || place.forces_W.iter().map(|parts| parts[0]);
        let loads = self.shares.loads(still());
        let at = (&place.points_W[..], &place.com_W);
        let leaning = self.shares.leaning(loads, at, rest + w * FARTHER);
        let leaning = leaning.zip(still()).map(|(f, rest)| (f - rest) / FARTHER);
        let leaning: Vec<Vector3<f64>> = leaning.collect();
        let weights = self.shares.weights(&place.loads);
        let plain = self.shares.shared(&weights, at, [w]);
        let plain: Vec<Vector3<f64>> = plain.map(|[f]| f).collect();
        // By what part of their limits they grow.
        let used = |forces: &[Vector3<f64>]| {
            let mut most = 0.0_f64;
            let parts = still().zip(forces).map(|(rest, f)| [rest, *f, *f]);
            self.bearing(parts, |row| most = most.max(row.a / row.c));
            most
        };
        let weight = self.context.robot.mass_kg * GRAVITY_M_S2;
        // Nearly nothing has no direction.
        let square = w.norm_squared() + (SLIGHT * weight).powi(2);
        let better = used(&leaning) < used(&plain);
        let part = if better { 1.0 } else { 0.0 };
        let along = w.transpose() * (part / square);
        let off = leaning.iter().zip(&plain).zip(&place.loads);
        let off = off.map(|((f, g), load)| match *load > UNLOADED_N {
            true => (f - g) * along / *load,
            false => Matrix3x6::zeros(),
        });
        off.collect()
    }

    fn paced(&self, place: &Place, rate: f64, bend: f64) -> Paced {
        let square = rate * rate;
        let path = &place.path;
        let mut forces_W = vec![Vec::new(); self.phase.task.closed.len()];
        for ([rest, a, b], point) in place.forces_W.iter().zip(&self.shares.points) {
            forces_W[point.contact].push(rest + a * bend + b * square);
        }
        let tau = place.tau.iter();
        let tau = tau.map(|[rest, a, b]| rest + a * bend + b * square);
        Paced {
            q: path.q.clone(),
            v: &path.v * rate,
            a: &path.v * bend + &path.a * square,
            tau: tau.collect(),
            com_W: place.com_W,
            forces_W,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_accelerations_go_from_each_place_to_the_next_in_nearly_the_same_time() {
        let n = 80;
        // s = 2 t² up to the middle.
        let time = |i: usize| (place_s(i, n) / 2.0).sqrt();
        let steps = (0..n / 2).map(|i| time(i + 1) - time(i));
        let (least, most) = steps.fold((1.0_f64, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
        assert!(most < 1.5 * least, "{least} {most}");
        for i in 0..=n {
            assert!((places_before(place_s(i, n), n) - i as f64).abs() < 1e-6);
        }
    }
}
