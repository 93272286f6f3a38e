//! The time of the reference, which waits for a robot that was pushed back.
//!
//! A motion uses most of what the contacts bear to accelerate; what is left does not bring a robot that a push holds
//! up back on its way before the next foot leaves. So the reference waits for it: its time passes more slowly, and
//! not at all from some distance on,
//!
//!   q(s), v = ṡ q'(s), a = ṡ² q''(s) + s̈ q'(s)
//!
//! A robot that is ahead, or beside its way, is not waited for: that would brake it, and nothing else.

use nalgebra::Vector2;

use crate::reference::ReferenceState;

/// How far the capture point may be behind its reference's before time passes more slowly, m: what the world is off
/// and what an estimator is told wrongly; and from where on it stands still.
const BEHIND_M: f64 = 0.01;
const STANDS_M: f64 = 0.03;
/// How fast the rate changes, 1/s: centres of mass of motions move at up to .5 m/s, which it brakes by 1.5 m/s².
const RATE_CHANGE: f64 = 3.0;
/// Slower than this the reference goes nowhere that a robot could be behind, m/s.
const STILL_M_S: f64 = 0.02;
/// How long a reference waits in all, s: a robot that cannot catch up is to fail.
const WAITS_S: f64 = 3.0;

/// The reference's time as it passes.
pub(crate) struct Clock {
    /// Time of the reference, s.
    pub t_s: f64,
    /// By how much it is later in the simulation, s.
    pub waited_s: f64,
    /// ṡ and s̈.
    rate: f64,
    change: f64,
}

/// Where the capture point is, and where it should be.
pub(crate) struct Capture {
    /// How far it is off its reference's, in the ground plane of W, m.
    pub off_W: Vector2<f64>,
    /// The centre of mass's wanted velocity in it, m/s.
    pub velocity_W: Vector2<f64>,
}

impl Clock {
    /// At the start of the reference.
    pub fn new() -> Self {
        Self {
            t_s: 0.0,
            waited_s: 0.0,
            rate: 1.0,
            change: 0.0,
        }
    }

    /// `dt_s` of the simulation passes.
    pub fn pass(&mut self, dt_s: f64, capture: &Capture) {
        let speed = capture.velocity_W.norm();
        let behind_m = match speed > STILL_M_S && self.waited_s < WAITS_S {
            true => -capture.off_W.dot(&capture.velocity_W) / speed,
            false => 0.0,
        };
        let rate = ((STANDS_M - behind_m) / (STANDS_M - BEHIND_M)).clamp(0.0, 1.0);
        let step = (rate - self.rate).clamp(-RATE_CHANGE * dt_s, RATE_CHANGE * dt_s);
        self.rate += step;
        self.change = step / dt_s;
        self.t_s += self.rate * dt_s;
        self.waited_s += (1.0 - self.rate) * dt_s;
    }

    /// Velocities and accelerations of the reference at this rate.
    pub fn slow(&self, wanted: &mut ReferenceState) {
        wanted.a *= self.rate.powi(2);
        wanted.a.axpy(self.change, &wanted.v, 1.0);
        wanted.v *= self.rate;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(seconds: f64, off_m: f64, speed: f64) -> Clock {
        let capture = Capture {
            off_W: Vector2::new(off_m, 0.0),
            velocity_W: Vector2::new(speed, 0.0),
        };
        let mut clock = Clock::new();
        for _ in 0..(seconds / 0.002).round() as usize {
            clock.pass(0.002, &capture);
        }
        clock
    }

    #[test]
    fn time_waits_for_who_is_behind_and_not_for_ever() {
        for (off_m, speed) in [(-0.009, 0.3), (0.05, 0.3), (-0.05, 0.01)] {
            let clock = after(1.0, off_m, speed);
            assert!((clock.t_s - 1.0).abs() < 1e-9 && clock.waited_s < 1e-9);
        }
        let behind = after(1.0, -0.05, 0.3);
        // Half of what it takes to stand still.
        assert!(
            (behind.t_s - 0.5 / RATE_CHANGE).abs() < 2e-3,
            "{}",
            behind.t_s
        );
        assert!((behind.t_s + behind.waited_s - 1.0).abs() < 1e-9);
        let late = after(10.0, -0.05, 0.3);
        assert!((late.waited_s - WAITS_S - 0.5 / RATE_CHANGE).abs() < 1e-2);
    }

    #[test]
    fn velocities_are_those_of_the_slowed_reference() {
        let at = |s: f64| (s.sin(), s.cos(), -s.sin());
        let capture = |off_m| Capture {
            off_W: Vector2::new(off_m, 0.0),
            velocity_W: Vector2::new(0.3, 0.0),
        };
        let (mut clock, mut before) = (Clock::new(), None);
        let mut wanted = ReferenceState::at_rest(scenes::robot("hexapod").unwrap().neutral());
        for step in 0..400 {
            clock.pass(1e-4, &capture(-0.01 - 1e-4 * f64::from(step)));
            let (q, v, a) = at(clock.t_s);
            wanted.v.fill(v);
            wanted.a.fill(a);
            clock.slow(&mut wanted);
            if let Some((q_before, v_before)) = before.replace((q, wanted.v[0])) {
                let differs = |x: f64, y: f64, most: f64| (x - y).abs() < most;
                assert!(differs((q - q_before) / 1e-4, wanted.v[0], 1e-3), "{step}");
                assert!(
                    differs((wanted.v[0] - v_before) / 1e-4, wanted.a[0], 1e-2),
                    "{step}"
                );
            }
        }
        assert!(clock.rate < 0.95);
    }
}
