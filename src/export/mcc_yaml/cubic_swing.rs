//! The swing that the controller plays: its `CubicSplineSimple`, with the offsets that keep it on a
//! verified path.
//!
//!   p(u) = p₀ + (p₁ − p₀)(3s² − s³)/2   withdraw, s = u/a;   mirrored on the approach
//!
//! and between them one C² cubic spline through the middle, at half time, with the velocities of both
//! at its ends. A verified path that a patch goes along has a place at each of these times, so the two
//! can only part between them.

use nalgebra::{Isometry3, Vector3};

/// Parts of the time for withdrawing and approaching that are tried.
const PARTS: [f64; 6] = [0.1, 0.15, 0.2, 0.25, 0.3, 0.35];
/// Places at which a swing is compared with its path.
const LOOKS: usize = 60;

/// A swing in the air, over its time from 0 to 1.
pub(super) struct CubicSwing {
    /// Parts of the time for withdrawing and approaching.
    pub parts: [f64; 2],
    /// Start, end of the withdrawal, middle, begin of the approach, end; W, m.
    pub places_W: [Vector3<f64>; 5],
    /// How far it is from the path that it follows, whatever the time, at most, m.
    pub strays_m: f64,
}

impl CubicSwing {
    /// The swing that strays least from a path of at least two poses at equal steps of time.
    pub fn along(path: &[Isometry3<f64>]) -> Option<Self> {
        let last = path.len().checked_sub(1).filter(|last| *last > 0)?;
        let at = |u: f64| {
            let x = u * last as f64;
            let i = (x.floor() as usize).min(last - 1);
            let [a, b] = [i, i + 1].map(|i| path[i].translation.vector);
            a.lerp(&b, x - i as f64)
        };
        let pairs = PARTS.iter().flat_map(|a| PARTS.map(|b| [*a, b]));
        let swings = pairs.map(|parts| {
            let [a, b] = parts;
            let mut swing = Self {
                parts,
                places_W: [0.0, a, 0.5, 1.0 - b, 1.0].map(at),
                strays_m: 0.0,
            };
            let off = |k: usize| {
                let place = swing.position(k as f64 / LOOKS as f64);
                let near = path
                    .iter()
                    .map(|pose| (pose.translation.vector - place).norm());
                near.fold(f64::INFINITY, f64::min)
            };
            swing.strays_m = (0..=LOOKS).map(off).fold(0.0, f64::max);
            swing
        });
        swings.min_by(|a, b| a.strays_m.total_cmp(&b.strays_m))
    }

    /// Where it is at a part of its time, W, m.
    pub fn position(&self, u: f64) -> Vector3<f64> {
        let ([a, b], [start, out, middle, over, end]) = (self.parts, self.places_W);
        let leave = |s: f64| 0.5 * (3.0 - s) * s * s;
        if u < a {
            return start + (out - start) * leave(u / a);
        }
        if u > 1.0 - b {
            return end + (over - end) * leave((1.0 - u) / b);
        }
        let (h, k) = (0.5 - a, 0.5 - b);
        let (v_out, v_over) = (1.5 / a * (out - start), 1.5 / b * (end - over));
        // The second derivatives of both sides are one in the middle.
        let rise = 3.0 * ((middle - out) / (h * h) + (over - middle) / (k * k));
        let v = (rise - v_out / h - v_over / k) / (2.0 / h + 2.0 / k);
        if u < 0.5 {
            hermite(out, v_out, middle, v, h, (u - a) / h)
        } else {
            hermite(middle, v, over, v_over, k, (u - 0.5) / k)
        }
    }
}

/// The cubic from p with velocity v to q with velocity w in a time h, at the part s of it.
fn hermite(
    p: Vector3<f64>,
    v: Vector3<f64>,
    q: Vector3<f64>,
    w: Vector3<f64>,
    h: f64,
    s: f64,
) -> Vector3<f64> {
    let (s2, s3) = (s * s, s * s * s);
    p * (2.0 * s3 - 3.0 * s2 + 1.0)
        + v * (h * (s3 - 2.0 * s2 + s))
        + q * (3.0 * s2 - 2.0 * s3)
        + w * (h * (s3 - s2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From rest to rest up, over and down, as the planner's swings go.
    fn path() -> Vec<Isometry3<f64>> {
        let place = |i: usize| {
            let u = i as f64 / 200.0;
            let s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            let along = s * s * (3.0 - 2.0 * s);
            Isometry3::translation(0.3 * along, 0.0, 0.2 * along + 0.4 * s * (1.0 - s))
        };
        (0..=200).map(place).collect()
    }

    #[test]
    fn it_stays_near_the_path_and_is_smooth() {
        let path = path();
        let swing = CubicSwing::along(&path).unwrap();
        assert!(swing.strays_m < 0.005, "{}", swing.strays_m);
        let [a, b] = swing.parts;
        let velocity = |u: f64| (swing.position(u + 1e-6) - swing.position(u - 1e-6)) / 2e-6;
        let curvature = |u: f64| (velocity(u + 1e-4) - velocity(u - 1e-4)) / 2e-4;
        for joint in [a, 0.5, 1.0 - b] {
            let jump = velocity(joint + 1e-5) - velocity(joint - 1e-5);
            assert!(jump.norm() < 1e-3, "{joint}: {jump}");
        }
        let bend = curvature(0.5 + 1e-3) - curvature(0.5 - 1e-3);
        assert!(bend.norm() < 0.5, "{bend}");
        for (u, place) in [(0.0, path[0]), (1.0, path[200])] {
            assert!((swing.position(u) - place.translation.vector).norm() < 1e-12);
            assert!(velocity(u.clamp(1e-6, 1.0 - 1e-6)).norm() < 1e-3);
        }
        assert!(CubicSwing::along(&path[..1]).is_none());
    }
}
