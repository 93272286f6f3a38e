//! Whether the sensor is what it is taken for: its intrinsics and the scale of its depths.
//!
//! With pixels u = f x + c the ground is 1/z = m·(x, y, 1), whatever f and c are, so that one frame
//! fits as well with wrong ones. But m is then another plane's:
//!
//!   m = ((1 + a) m'_x, (1 + b) m'_y, m'_z + c m'_x + e m'_y)/(1 + s),
//!   a = f_x/f'_x − 1,  b = f_y/f'_y − 1,  c = (c_x − c'_x)/f'_x,  e = (c_y − c'_y)/f'_y,
//!
//! s the part by which depths are too short, and the robot's poses tell.

use nalgebra::{Unit, Vector3};

use super::refine::refine;
use super::{CameraConfig, PlanePair};
use crate::ground::CellEffect;
use crate::{Error, GroundPlane};

/// Standard deviation of each of the five beforehand.
const PRIOR: f64 = 0.1;
/// Cell of the first among the unknowns.
const CELL: u32 = u32::MAX - 5;
/// Times that the planes are corrected and the rest is found anew.
const ROUNDS: usize = 3;
/// Step of the difference quotients.
const STEP: f64 = 1e-6;
/// χ² by which five true zeros improve a fit once in 10 000 times.
const GAIN: f64 = 25.7;

/// What a set of poses says of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// a, b: focal lengths over those given, less 1; c, e: the principal point's shift over the focal
    /// length; s: depths over those given, less 1.
    pub values: [f64; 5],
    /// Standard deviation of each.
    pub sigmas: [f64; 5],
    /// By how much χ² is less with them, over the square of the residuals' ratio to their noise.
    pub gain: f64,
}

impl SensorModel {
    /// The model that fits best beside the mount.
    pub(super) fn of(
        pairs: &[PlanePair],
        start: &super::Identification,
        config: &CameraConfig,
    ) -> Result<Self, Error> {
        let mut model = Self {
            values: [0.0; 5],
            sigmas: [PRIOR; 5],
            gain: 0.0,
        };
        let mut chi2 = 0.0;
        for _ in 0..ROUNDS {
            let freed: Vec<PlanePair> = pairs.iter().map(|pair| model.freed(pair)).collect();
            let refined = refine(&freed, &start.X_RV, config)?;
            for (cell, value, sigma) in refined.distortion {
                if cell >= CELL {
                    let k = (cell - CELL) as usize;
                    model.values[k] += PRIOR * value;
                    model.sigmas[k] = PRIOR * sigma;
                }
            }
            chi2 = refined.chi2;
        }
        let freedom = (3 * pairs.len()).saturating_sub(11).max(1) as f64;
        let before = start.noise_factor.powi(2) * (3 * pairs.len()).saturating_sub(6) as f64;
        model.gain = (before - chi2) / (chi2 / freedom).max(1.0);
        Ok(model)
    }

    /// Whether the sensor is another than it is taken for.
    pub fn is_wrong(&self) -> bool {
        self.gain > GAIN
    }

    /// A plane as it would have been measured with this model.
    fn corrected(&self, plane: &GroundPlane) -> GroundPlane {
        let m = -plane.normal.into_inner() / plane.distance_m;
        let [a, b, c, e, s] = self.values;
        let z = m.z + c * m.x + e * m.y;
        let m = Vector3::new((1.0 + a) * m.x, (1.0 + b) * m.y, z) / (1.0 + s);
        GroundPlane {
            normal: Unit::new_normalize(-m),
            distance_m: 1.0 / m.norm(),
            covariance: plane.covariance,
        }
    }

    /// A pair with its sensor's plane corrected, the five among its unknowns.
    fn freed(&self, pair: &PlanePair) -> PlanePair {
        let sensor = self.corrected(&pair.sensor);
        let mut common = pair.common.clone();
        for k in 0..5 {
            let mut other = *self;
            other.values[k] += STEP;
            let moved = other.corrected(&pair.sensor);
            let turn = sensor.tangents().transpose()
                * (moved.normal.into_inner() - sensor.normal.into_inner());
            let change = Vector3::new(turn.x, turn.y, moved.distance_m - sensor.distance_m);
            common.push(CellEffect {
                cell: CELL + k as u32,
                // The correction takes away what is measured too much.
                effect: -change * (PRIOR / STEP),
            });
        }
        PlanePair {
            robot: pair.robot,
            sensor,
            common,
        }
    }
}
