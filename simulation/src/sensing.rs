//! What the controller knows of the robot: what is, or what an estimator and sensors would tell of it.
//!
//! Told, the base's pose and velocity are off by what wanders like an estimator's errors, joints are counted in an
//! encoder's steps and their rates are differences of these, all of it is late and carried on by the velocity, and the
//! force at a patch is a noisy sensor's, filtered.

use std::collections::VecDeque;
use std::ops::AddAssign;

use nalgebra::{DVector, UnitQuaternion, Vector3};
use robot_model::Configuration;

use crate::perturbation::symmetric;

/// Standard deviations of an estimator's pose and velocity of a walking robot's base.
const PLACE_M: f64 = 1e-3;
const TURN_RAD: f64 = 3.5e-3;
const SPEED_M_S: f64 = 0.01;
const SPIN_RAD_S: f64 = 0.01;
/// Time in which such an error becomes another one, s.
const WANDER_S: f64 = 0.1;
/// A step of a joint's encoder: a thousand lines a turn before a gear of 1 to 60, four steps a line, rad.
const ENCODER_RAD: f64 = 2.6e-5;
/// By how many periods of the controller a state is late: 4 ms.
const LATE: usize = 2;
/// Standard deviation of a force, time constant of the filter, and what then counts as nothing, N and s.
const FORCE_N: f64 = 5.0;
const FILTER_S: f64 = 0.01;
const NOTHING_N: f64 = 4.0;

/// What is known, with what has been seen and not yet told.
pub(crate) struct Sensing {
    /// Of the noise; without one all is told as it is, at once.
    seed: Option<u64>,
    drawn: u64,
    /// The state as it is known.
    pub state: Configuration,
    pub v: DVector<f64>,
    /// Normal force at each patch as it is known, N.
    pub normal_n: Vec<f64>,
    filtered_n: Vec<f64>,
    late: VecDeque<(Configuration, DVector<f64>)>,
    /// Errors of the base's place, turn, speed and spin, over their standard deviations.
    errors: [Vector3<f64>; 4],
}

impl Sensing {
    /// A robot at rest, whose patches bear nothing yet.
    pub fn new(seed: Option<u64>, start: &Configuration, patches: usize) -> Self {
        Self {
            seed,
            drawn: 0,
            state: start.clone(),
            v: DVector::zeros(start.joints.len() + 6),
            normal_n: vec![0.0; patches],
            filtered_n: vec![0.0; patches],
            late: VecDeque::new(),
            errors: [Vector3::zeros(); 4],
        }
    }

    /// Takes in the state, `dt_s` after the last one.
    pub fn see(&mut self, state: &Configuration, v: &DVector<f64>, dt_s: f64) {
        if self.seed.is_none() {
            self.state.clone_from(state);
            self.v.copy_from(v);
            return;
        }
        let mut told = state.clone();
        let mut rates = v.clone();
        // An autoregressive process of the first order keeps its variance so.
        let part = dt_s / WANDER_S;
        let driven = ((2.0 - part) / part).sqrt();
        for k in 0..self.errors.len() {
            let noise = self.noise(driven);
            self.errors[k] += (noise - self.errors[k]) * part;
        }
        let [place, turn, speed, spin] = self.errors;
        told.p_WB += place * PLACE_M;
        told.R_WB = UnitQuaternion::new(turn * TURN_RAD) * told.R_WB;
        rates
            .fixed_rows_mut::<3>(0)
            .add_assign(&(speed * SPEED_M_S));
        rates
            .fixed_rows_mut::<3>(3)
            .add_assign(&(spin * SPIN_RAD_S));
        told.joints
            .apply(|q| *q = (*q / ENCODER_RAD).round() * ENCODER_RAD);
        if let Some((before, _)) = self.late.back() {
            let moved = (&told.joints - &before.joints) / dt_s;
            rates.rows_mut(6, moved.len()).copy_from(&moved);
        }
        self.late.push_back((told, rates));
        if self.late.len() > LATE {
            (self.state, self.v) = self.late[0].clone();
            self.late.pop_front();
            // How late it is is known: where the robot has gone since by its velocity.
            let since = &self.v * (LATE as f64 * dt_s);
            self.state.integrate_in_place(since.as_slice());
        }
    }

    /// Takes in the normal force at each patch, N, `dt_s` after the last ones.
    pub fn feel(&mut self, normal_n: &[f64], dt_s: f64) {
        if self.seed.is_none() {
            self.normal_n.copy_from_slice(normal_n);
            return;
        }
        for (patch, force) in normal_n.iter().enumerate() {
            let felt = force + self.noise(FORCE_N).x;
            let filtered = &mut self.filtered_n[patch];
            *filtered += (felt - *filtered) * (dt_s / FILTER_S);
            self.normal_n[patch] = if *filtered < NOTHING_N {
                0.0
            } else {
                *filtered
            };
        }
    }

    /// Three numbers of this standard deviation, from even distributions: none is far off.
    fn noise(&mut self, deviation: f64) -> Vector3<f64> {
        self.drawn += 1;
        let (seed, drawn) = (self.seed.unwrap_or_default(), self.drawn);
        let most = deviation * 3.0_f64.sqrt();
        Vector3::from([0, 1, 2].map(|axis| most * symmetric(seed, 0, axis, drawn)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is known of a base that moves at 1 m/s and a joint that turns at 1 rad/s, period by period.
    fn known(seed: Option<u64>, patch_n: f64) -> Vec<(Configuration, DVector<f64>, f64)> {
        let start = Configuration::zero(1);
        let mut sensing = Sensing::new(seed, &start, 1);
        let v = DVector::from_vec(vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let periods = (0..20_000).map(|k| {
            let mut state = start.clone();
            state.p_WB.x = f64::from(k) * 0.002;
            state.joints[0] = f64::from(k) * 0.002;
            sensing.see(&state, &v, 0.002);
            sensing.feel(&[patch_n], 0.002);
            (
                sensing.state.clone(),
                sensing.v.clone(),
                sensing.normal_n[0],
            )
        });
        periods.collect()
    }

    #[test]
    fn without_a_seed_all_is_known_at_once() {
        let known = known(None, 1.0);
        assert_eq!(known[1000].0.p_WB.x, 2.0);
        assert_eq!((known[1000].1[0], known[1000].2), (1.0, 1.0));
    }

    #[test]
    fn what_is_told_is_late_and_off_by_what_is_said() {
        let told = known(Some(7), 100.0);
        assert_eq!(told, known(Some(7), 100.0));
        let off = |k: usize| told[k].0.p_WB.x - k as f64 * 0.002;
        let all: Vec<f64> = (200..20_000).map(off).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        // Some 200 errors that have nothing to do with each other.
        assert!(mean.abs() < 2.5e-4, "{mean}");
        assert!((square.sqrt() / PLACE_M - 1.0).abs() < 0.15, "{square}");
        for (state, v, force) in &told[100..] {
            let late = state.joints[0] - v[6] * 0.002 * LATE as f64;
            let steps = late / ENCODER_RAD;
            assert!((steps - steps.round()).abs() < 1e-6);
            assert!((v[6] - 1.0).abs() <= ENCODER_RAD / 0.002 + 1e-9);
            assert!((force - 100.0).abs() < 15.0, "{force}");
        }
        // A sensor of a patch in the air tells nothing, most of the time.
        let felt = known(Some(7), 0.0)
            .iter()
            .filter(|told| told.2 > 0.0)
            .count();
        assert!(felt < 1000, "{felt} of 20000");
    }
}
