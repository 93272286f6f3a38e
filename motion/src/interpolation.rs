//! The motion at any time, with its rates: a C² curve through the samples.
//!
//! Coordinates are splines in time; the base's quaternion is a spline made unit length,
//!
//!   q = p/|p|,   ω = 2 q̇ q*,   ω̇ = 2 q̈ q*      (vector parts, in W)

use nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3, Vector4};
use robot_model::Configuration;

use crate::spline::{Ends, Order, Spline};
use plan::Motion;

/// The whole body at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Instant {
    /// Configuration.
    pub q: Configuration,
    /// Velocity `[v_B, ω_B, joint rates…]`, in W; m/s, rad/s.
    pub v: DVector<f64>,
    /// Acceleration, the derivative of `v` in W; m/s², rad/s².
    pub a: DVector<f64>,
}

/// A C² curve through configurations at equal steps of a parameter.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    spline: Spline,
    dim: usize,
    length: f64,
}

impl Curve {
    /// The curve through `[p_WB, quat_xyzw, joints…]`, `step` apart, the first at 0; at least two.
    pub fn new<'a>(all: impl Iterator<Item = &'a [f64]>, step: f64, ends: Ends) -> Self {
        let mut values = Vec::new();
        let (mut dim, mut count) = (0, 0);
        let mut last = Vector4::zeros();
        for q in all {
            let mut quaternion = Vector4::from_column_slice(&q[3..7]);
            // q and −q are one orientation: stay on the side of the one before.
            if quaternion.dot(&last) < 0.0 {
                quaternion = -quaternion;
            }
            last = quaternion;
            values.extend_from_slice(&q[..3]);
            values.extend_from_slice(quaternion.as_slice());
            values.extend_from_slice(&q[7..]);
            (dim, count) = (q.len(), count + 1);
        }
        Self {
            spline: Spline::new(dim, step, values, ends),
            dim,
            length: step * (count as f64 - 1.0),
        }
    }

    /// Configuration and its first two derivatives at `x`; beyond the ends it rests where it is.
    pub fn at(&self, x: f64) -> Instant {
        let mut all = vec![0.0; 3 * self.dim];
        let (y, rates) = all.split_at_mut(self.dim);
        let (dy, ddy) = rates.split_at_mut(self.dim);
        self.spline.evaluate(x, Order::Value, y);
        if (0.0..=self.length).contains(&x) {
            self.spline.evaluate(x, Order::First, dy);
            self.spline.evaluate(x, Order::Second, ddy);
        }
        let (y, dy, ddy) = (&*y, &*dy, &*ddy);
        let (p, dp, ddp) = (quaternion(y), quaternion(dy), quaternion(ddy));
        let norm = p.norm();
        let q = p / norm;
        let dnorm = q.coords.dot(&dp.coords);
        let dq = (dp - q * dnorm) / norm;
        let ddnorm = dq.coords.dot(&dp.coords) + q.coords.dot(&ddp.coords);
        let ddq = (ddp - dq * (2.0 * dnorm) - q * ddnorm) / norm;
        let omega = 2.0 * (dq * q.conjugate()).imag();
        let alpha = 2.0 * (ddq * q.conjugate()).imag();
        let nj = self.dim - 7;
        let rates = |c: &[f64], turn: &Vector3<f64>| {
            let all = c[..3].iter().chain(turn.iter()).chain(&c[7..]);
            DVector::from_iterator(6 + nj, all.copied())
        };
        Instant {
            q: configuration(y, q),
            v: rates(dy, &omega),
            a: rates(ddy, &alpha),
        }
    }

    /// The configuration alone at `x`.
    pub fn configuration(&self, x: f64) -> Configuration {
        let mut y = vec![0.0; self.dim];
        self.spline.evaluate(x, Order::Value, &mut y);
        let p = quaternion(&y);
        configuration(&y, p / p.norm())
    }
}

/// The base's quaternion of a sample, not of unit length.
fn quaternion(y: &[f64]) -> Quaternion<f64> {
    Quaternion::new(y[6], y[3], y[4], y[5])
}

fn configuration(y: &[f64], q: Quaternion<f64>) -> Configuration {
    Configuration {
        p_WB: Vector3::new(y[0], y[1], y[2]),
        R_WB: UnitQuaternion::new_unchecked(q),
        joints: DVector::from_column_slice(&y[7..]),
    }
}

/// A C² curve through the samples of a motion, from rest to rest.
#[derive(Clone, Debug)]
pub struct Interpolation {
    curve: Curve,
    duration_s: f64,
}

impl Interpolation {
    /// The curve through the samples of a motion.
    ///
    /// # Errors
    /// As [`Motion::validate`].
    pub fn new(motion: &Motion) -> Result<Self, plan::Error> {
        motion.validate()?;
        let samples = motion.samples.iter().map(|sample| &sample.q[..]);
        Ok(Self {
            curve: Curve::new(samples, motion.dt_s, Ends::Rest),
            duration_s: motion.duration_s(),
        })
    }

    /// When the motion ends, s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The body at a time; before the start and after the end it rests where it is.
    pub fn at(&self, t_s: f64) -> Instant {
        self.curve.at(t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time_scaling::quintic;
    use plan::{MOTION_FORMAT, Phase, PhaseKind, Sample};

    /// A body that turns about a slanted axis and slides, from rest to rest.
    fn turning() -> Motion {
        let n = 200;
        let sample = |i: usize| {
            let u = quintic(i as f64 / n as f64);
            let turn = UnitQuaternion::new(Vector3::new(0.6, -0.3, 1.2) * u);
            let mut q = vec![u, 2.0 * u, -u];
            q.extend(turn.coords.iter());
            q.push(3.0 * u);
            Sample {
                t_s: i as f64 * 0.01,
                q,
                v: vec![0.0; 7],
                a: vec![0.0; 7],
                tau: vec![0.0],
                com_W: [0.0; 3],
                forces_W: Vec::new(),
            }
        };
        Motion {
            format: MOTION_FORMAT.to_owned(),
            robot: "body".to_owned(),
            dt_s: 0.01,
            limits: plan::Limits {
                joint_speed_use: 1.0,
                joint_acceleration_rad_s2: 50.0,
                torque_use: 1.0,
                friction_use: 1.0,
                margin_use: 0.0,
            },
            phases: vec![Phase {
                kind: PhaseKind::Shift,
                t_start_s: 0.0,
                t_end_s: 2.0,
                from_stance: 0,
                to_stance: 1,
                contacts: Vec::new(),
                swing: None,
            }],
            samples: (0..=n).map(sample).collect(),
        }
    }

    #[test]
    fn rates_are_those_of_the_curve() {
        let curve = Interpolation::new(&turning()).unwrap();
        let h = 1e-4;
        for i in 1..40 {
            let t = 0.05 * f64::from(i) - 0.003;
            let (before, now, after) = (curve.at(t - h), curve.at(t), curve.at(t + h));
            let velocity = before.q.difference(&after.q) / (2.0 * h);
            assert!((velocity - &now.v).norm() < 1e-5, "velocity at {t} s");
            let acceleration = (&after.v - &before.v) / (2.0 * h);
            let off = (acceleration - &now.a).norm();
            assert!(off < 1e-2, "acceleration at {t} s");
        }
    }

    #[test]
    fn it_rests_at_both_ends_and_beyond() {
        let curve = Interpolation::new(&turning()).unwrap();
        for t in [-1.0, 0.0, 2.0, 3.0] {
            assert!(curve.at(t).v.norm() < 1e-9, "at {t} s");
        }
        assert!((curve.at(9.0).q.joints[0] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_flipped_quaternion_changes_nothing() {
        let motion = turning();
        let mut flipped = motion.clone();
        flipped.samples[77].q[3..7]
            .iter_mut()
            .for_each(|x| *x = -*x);
        let [one, other] = [motion, flipped].map(|m| Interpolation::new(&m).unwrap());
        assert!((one.at(0.773).v - other.at(0.773).v).norm() < 1e-12);
    }

    #[test]
    fn records_that_contradict_themselves_are_refused() {
        let broken: [fn(&mut Motion); 7] = [
            |m| m.format = "else".to_owned(),
            |m| m.dt_s = 0.0,
            |m| m.phases[0].t_end_s = 1.995,
            |m| m.phases[0].t_start_s = 0.5,
            |m| m.samples.truncate(7),
            |m| m.samples[3].q[2] = f64::NAN,
            |m| m.samples[3].forces_W.push(Vec::new()),
        ];
        assert!(turning().validate().is_ok());
        for (i, change) in broken.iter().enumerate() {
            let mut motion = turning();
            change(&mut motion);
            assert!(Interpolation::new(&motion).is_err(), "change {i}");
        }
    }
}
