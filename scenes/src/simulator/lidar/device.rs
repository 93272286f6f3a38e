//! Where the beams of a VLP-16 are.

use nalgebra::{Point3, Vector3};

/// Beams.
pub const RINGS: usize = 16;
/// Vertical angle of the lowest beam, degrees.
const LOWEST_DEG: f64 = -15.0;
/// Angle between two beams, degrees.
const STEP_DEG: f64 = 2.0;
/// One firing cycle of the sixteen beams, s.
pub(super) const CYCLE_S: f64 = 55.296e-6;
/// Time between two beams of a cycle, s.
pub(super) const BEAM_S: f64 = 2.304e-6;
/// The beams cross on the axis of view this far ahead of the axis of rotation, m: beam ω leaves the
/// axis of rotation at the height −0.0418 tan ω. This gives the manual's vertical corrections
/// (±11.2 mm at ∓15°) to a tenth of a millimetre.
const CROSSING_M: f64 = 0.0418;

/// How a VLP-16 is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vlp16 {
    /// Angle between two firings of a beam, rad.
    pub step_rad: f64,
    /// Horizontal field of view, centred on x, rad; 2π is a whole turn.
    pub view_rad: f64,
    /// Nearest range that is reported, m.
    pub range_min_m: f64,
    /// Farthest range that is reported, m.
    pub range_max_m: f64,
}

impl Default for Vlp16 {
    /// 1350 firings over half a turn: 21 600 beams, as in \[meng\] IV.
    fn default() -> Self {
        Self {
            step_rad: std::f64::consts::PI / 1350.0,
            view_rad: std::f64::consts::PI,
            range_min_m: 0.4,
            range_max_m: 100.0,
        }
    }
}

impl Vlp16 {
    /// Firings over the field of view.
    pub fn firings(&self) -> usize {
        (self.view_rad / self.step_rad).round().max(1.0) as usize
    }

    /// Azimuth of a ring's beam in a firing, rad: the head turns clockwise, on while the beams are
    /// fired one after the other.
    pub fn azimuth_rad(&self, firing: usize, ring: usize) -> f64 {
        let cycles = firing as f64 + fired_at(ring) as f64 * BEAM_S / CYCLE_S;
        self.view_rad / 2.0 - cycles * self.step_rad
    }

    /// Vertical angle of a ring, from the lowest one, rad.
    pub fn elevation_rad(ring: usize) -> f64 {
        (LOWEST_DEG + STEP_DEG * ring as f64).to_radians()
    }

    /// Where a ring's beam leaves the axis, and its direction at an azimuth, in V.
    pub fn beam_V(ring: usize, azimuth_rad: f64, tilt_rad: f64) -> (Point3<f64>, Vector3<f64>) {
        let elevation = Self::elevation_rad(ring);
        let origin = Point3::new(0.0, 0.0, -CROSSING_M * elevation.tan());
        let (s, c) = (elevation + tilt_rad).sin_cos();
        let direction = Vector3::new(c * azimuth_rad.cos(), c * azimuth_rad.sin(), s);
        (origin, direction)
    }
}

/// When in a cycle a ring is fired: the lower and the upper half take turns.
pub(super) fn fired_at(ring: usize) -> usize {
    if ring < RINGS / 2 {
        2 * ring
    } else {
        2 * (ring - RINGS / 2) + 1
    }
}
