//! Numbers drawn one after another from a stream of their own.

use nalgebra::{Unit, UnitQuaternion, Vector3};

use crate::simulator::rng::Stream;

/// The draws of one problem.
pub(super) struct Draws {
    stream: Stream,
    next: u64,
}

impl Draws {
    /// The stream of a problem.
    pub fn new(seed: u64, family: u64, number: u64) -> Self {
        Self {
            stream: Stream::new(seed, (family << 40) + number),
            next: 0,
        }
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.next += 1;
        self.stream.uniform(self.next)
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// One of `n`.
    pub fn index(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// `n` of the items, in their order.
    pub fn some<T: Copy>(&mut self, of: &[T], n: usize) -> Vec<T> {
        let mut left: Vec<T> = of.to_vec();
        while left.len() > n {
            let out = self.index(left.len());
            left.remove(out);
        }
        left
    }

    /// Uniform in a ball, m.
    pub fn in_ball(&mut self, radius: f64) -> Vector3<f64> {
        loop {
            let p = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            if p.norm_squared() <= 1.0 {
                return radius * p;
            }
        }
    }

    /// A turn of at most `angle` about any axis, rad.
    pub fn turn(&mut self, angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::new(self.in_ball(angle))
    }

    /// z tilted by a drawn angle between the two toward any side.
    pub fn tilt(&mut self, least: f64, most: f64) -> UnitQuaternion<f64> {
        let azimuth = self.between(0.0, std::f64::consts::TAU);
        let axis = Unit::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
        UnitQuaternion::from_axis_angle(&axis, self.between(least, most))
    }
}
