//! The errors of a time-of-flight range finder.

use super::super::rng::Stream;
use super::device::RINGS;

/// Errors of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeNoise {
    /// Standard deviation of one range, m.
    pub range_sigma_m: f64,
    /// Standard deviation of the constant error that a ring has, m.
    pub ring_bias_sigma_m: f64,
    /// Full width of the beam across, rad.
    pub divergence_across_rad: f64,
    /// Full height of the beam, rad.
    pub divergence_along_rad: f64,
    /// Two surfaces in one footprint nearer than this to each other give one range between them, m;
    /// of two that are farther apart one is reported.
    pub merge_m: f64,
    /// Part of the beams that meet something in the air.
    pub stray: f64,
    /// Step of the reported ranges, m.
    pub step_m: f64,
}

impl Default for RangeNoise {
    /// 8 mm of noise and 8 mm of bias (the VLP-16's sheet allows 30 mm in all); a footprint of
    /// 3.0 × 1.5 mrad; pulses of about 6 ns; 2 ‰ strays; steps of 2 mm.
    fn default() -> Self {
        Self {
            range_sigma_m: 0.008,
            ring_bias_sigma_m: 0.008,
            divergence_across_rad: 0.003,
            divergence_along_rad: 0.0015,
            merge_m: 0.9,
            stray: 0.002,
            step_m: 0.002,
        }
    }
}

impl RangeNoise {
    /// A sensor without errors.
    pub fn none() -> Self {
        Self {
            range_sigma_m: 0.0,
            ring_bias_sigma_m: 0.0,
            divergence_across_rad: 0.0,
            divergence_along_rad: 0.0,
            merge_m: 0.0,
            stray: 0.0,
            step_m: 0.0,
        }
    }

    /// The constant error of every ring of the device with this serial number, m.
    pub fn ring_bias_m(&self, device: u64) -> [f64; RINGS] {
        let stream = Stream::new(device, 0xB1A5);
        std::array::from_fn(|ring| self.ring_bias_sigma_m * stream.normal(ring as u64))
    }
}
