//! One sweep over the field of view.

use nalgebra::{Isometry3, Point3};

use super::super::body::{Hit, World};
use super::super::rng::Stream;
use super::device::{BEAM_S, CYCLE_S, RINGS, Vlp16, fired_at};
use super::noise::RangeNoise;

/// One range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Return {
    /// Ring, from the lowest beam.
    pub ring: usize,
    /// Firing, in the order of time.
    pub firing: usize,
    /// Azimuth, rad.
    pub azimuth_rad: f64,
    /// Time since the sweep began, s.
    pub time_s: f64,
    /// Measured range, m.
    pub range_m: f64,
    /// The measured point in V, m.
    pub p_V: Point3<f64>,
    /// The face of the world that the middle of the beam meets; none where the range is a stray's or
    /// a mixture's.
    pub face: Option<usize>,
}

/// The ranges of one sweep, ring by ring, and the device's constant errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Beams that were sent out.
    pub beams: usize,
    /// What came back, ring by ring and in the order of time.
    pub returns: Vec<Return>,
    /// The constant range error of every ring, m.
    pub ring_bias_m: [f64; RINGS],
}

/// Random streams, one an error.
#[derive(Clone, Copy)]
enum Source {
    Range,
    Stray,
    StrayRange,
    Mixture,
}

/// The sweep that a sensor at `X_WV` takes of `world`; ring errors belong to the `device`, all
/// others to the `seed`.
///
///   r' = quantise( r + b_ring + σ n ),   r a mixture where the footprint meets two surfaces
pub fn sweep(
    world: &World,
    sensor: &Vlp16,
    X_WV: &Isometry3<f64>,
    noise: &RangeNoise,
    device: u64,
    seed: u64,
) -> Sweep {
    let stream = |source: Source| Stream::new(seed, 0x1_0000 + source as u64);
    let (normal, mixture) = (stream(Source::Range), stream(Source::Mixture));
    let (stray, stray_range) = (stream(Source::Stray), stream(Source::StrayRange));
    let ring_bias_m = noise.ring_bias_m(device);
    let cast = |ring: usize, azimuth: f64, tilt: f64| -> Option<Hit> {
        let (origin, direction) = Vlp16::beam_V(ring, azimuth, tilt);
        world.cast(&(X_WV * origin), &(X_WV * direction))
    };

    let firings = sensor.firings();
    let mut returns = Vec::new();
    for (ring, bias_m) in ring_bias_m.iter().enumerate() {
        for firing in 0..firings {
            let index = (ring * firings + firing) as u64;
            let azimuth_rad = sensor.azimuth_rad(firing, ring);

            // 1. What the middle and the rim of the footprint meet.
            let middle = cast(ring, azimuth_rad, 0.0);
            let (across, along) = (
                noise.divergence_across_rad / 2.0 / Vlp16::elevation_rad(ring).cos(),
                noise.divergence_along_rad / 2.0,
            );
            let mut seen = middle;
            let mut range = middle.map(|hit| hit.t);
            let mut face = middle.map(|hit| hit.face);
            if across > 0.0 || along > 0.0 {
                let rim = [(across, 0.0), (-across, 0.0), (0.0, along), (0.0, -along)]
                    .map(|(a, t)| cast(ring, azimuth_rad + a, t));
                let other = rim.into_iter().flatten().find(|hit| Some(hit.face) != face);
                if let (Some(own), Some(other)) = (middle, other) {
                    let gap = (own.t - other.t).abs();
                    // A fold is no edge: both faces lie within the noise of the range.
                    if gap > 3.0 * noise.range_sigma_m {
                        let part = mixture.uniform(index);
                        if gap < noise.merge_m {
                            range = Some(own.t + (other.t - own.t) * 0.5 * part);
                            face = None;
                        } else if part < 0.25 {
                            range = Some(other.t);
                            face = Some(other.face);
                        }
                    }
                } else if middle.is_none() && other.is_some() && mixture.uniform(index) < 0.5 {
                    seen = other;
                    range = other.map(|hit| hit.t);
                    face = other.map(|hit| hit.face);
                }
            }

            // 2. Something in the air.
            if seen.is_some() && stray.uniform(index) < noise.stray {
                range = range.map(|r| r * (0.3 + 0.65 * stray_range.uniform(index)));
                face = None;
            }

            // 3. Noise, bias, steps, limits.
            let Some(true_range) = range else { continue };
            let error = bias_m + noise.range_sigma_m * normal.normal(index);
            let mut range_m = true_range + error;
            if noise.step_m > 0.0 {
                range_m = (range_m / noise.step_m).round() * noise.step_m;
            }
            if !(sensor.range_min_m..=sensor.range_max_m).contains(&range_m) {
                continue;
            }
            let (origin, direction) = Vlp16::beam_V(ring, azimuth_rad, 0.0);
            returns.push(Return {
                ring,
                firing,
                azimuth_rad,
                time_s: firing as f64 * CYCLE_S + fired_at(ring) as f64 * BEAM_S,
                range_m,
                p_V: origin + direction * range_m,
                face,
            });
        }
    }
    Sweep {
        beams: RINGS * firings,
        returns,
        ring_bias_m,
    }
}
