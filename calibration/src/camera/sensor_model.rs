//! Whether the sensor is what it is taken for: its intrinsics and the scale of its depths.
//!
//! With pixels u = f x + c the ground is 1/z = m·(x, y, 1), whatever f and c are, so that one frame
//! fits as well with wrong ones. But m is then another plane's:
//!
//!   m = ((1 + a) m'_x, (1 + b) m'_y, m'_z + c m'_x + e m'_y)/(1 + s),
//!   a = f_x/f'_x − 1,  b = f_y/f'_y − 1,  c = (c_x − c'_x)/f'_x,  e = (c_y − c'_y)/f'_y,
//!
//! s the part by which depths are too short, and the robot's poses tell. They tell little of all five at once, and
//! more of one mistake: both focal lengths by the same factor, the principal point, the scale. Each is tried alone, and
//! of those that explain about the same none is called the one.

use nalgebra::{Unit, Vector3};

use super::refine::refine;
use super::{CameraConfig, PlanePair};
use crate::ground::CellEffect;
use crate::{Error, GroundPlane};

/// Standard deviation of each unknown beforehand.
const PRIOR: f64 = 0.1;
/// Cell of the first among the unknowns.
const CELL: u32 = u32::MAX - 8;
/// Times that the planes are corrected and the rest is found anew.
const ROUNDS: usize = 3;
/// Step of the difference quotients.
const STEP: f64 = 1e-6;
/// χ² by which one, two and five true zeros improve a fit once in 4000 times.
const GAINS: [f64; 3] = [13.4, 16.6, 23.7];
/// Mistakes that are no more than this behind the best one may as well be made.
const ALIKE: f64 = GAINS[0];

/// What may be wrong with a sensor's model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// Both focal lengths, by one factor.
    Focal,
    /// The principal point.
    Centre,
    /// The scale of the depths.
    Scale,
    /// Several of these.
    Several,
}

impl Mistake {
    const ALL: [Self; 4] = [Self::Focal, Self::Centre, Self::Scale, Self::Several];

    /// Directions of the five in which it moves them.
    fn directions(self) -> &'static [[f64; 5]] {
        const AXES: [[f64; 5]; 5] = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ];
        match self {
            Self::Focal => &[[1.0, 1.0, 0.0, 0.0, 0.0]],
            Self::Centre => &AXES[2..4],
            Self::Scale => &AXES[4..],
            Self::Several => &AXES,
        }
    }

    /// χ² by which it has to improve the fit.
    fn gain_min(self) -> f64 {
        match self.directions().len() {
            1 => GAINS[0],
            2 => GAINS[1],
            _ => GAINS[2],
        }
    }
}

/// What a set of poses says of the sensor, were one mistake made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    /// The mistake.
    pub mistake: Mistake,
    /// a, b: focal lengths over those given, less 1; c, e: the principal point's shift over the focal
    /// length; s: depths over those given, less 1. Without the mistake they are zero.
    pub values: [f64; 5],
    /// Standard deviation of each; zero of those that the mistake leaves alone.
    pub sigmas: [f64; 5],
    /// By how much χ² is less with them, over the square of the residuals' ratio to their noise.
    pub gain: f64,
}

impl SensorModel {
    /// The models that fit best beside the mount, for each mistake.
    pub(super) fn all(
        pairs: &[PlanePair],
        start: &super::Identification,
        config: &CameraConfig,
    ) -> Result<Vec<Self>, Error> {
        let of = |mistake| Self::of(mistake, pairs, start, config);
        Mistake::ALL.into_iter().map(of).collect()
    }

    fn of(
        mistake: Mistake,
        pairs: &[PlanePair],
        start: &super::Identification,
        config: &CameraConfig,
    ) -> Result<Self, Error> {
        let mut model = Self {
            mistake,
            values: [0.0; 5],
            sigmas: [0.0; 5],
            gain: 0.0,
        };
        let directions = mistake.directions();
        let mut chi2 = 0.0;
        for _ in 0..ROUNDS {
            let freed: Vec<PlanePair> = pairs.iter().map(|pair| model.freed(pair)).collect();
            let refined = refine(&freed, &start.X_RV, config)?;
            model.sigmas = [0.0; 5];
            for (cell, value, sigma) in refined.distortion {
                let Some(direction) = cell.checked_sub(CELL).map(|k| directions[k as usize]) else {
                    continue;
                };
                for (k, part) in direction.into_iter().enumerate() {
                    model.values[k] += PRIOR * value * part;
                    model.sigmas[k] += PRIOR * sigma * part;
                }
            }
            chi2 = refined.chi2;
        }
        let freedom = (3 * pairs.len()).saturating_sub(6 + directions.len());
        let before = start.noise_factor.powi(2) * (3 * pairs.len()).saturating_sub(6) as f64;
        model.gain = (before - chi2) / (chi2 / freedom.max(1) as f64).max(1.0);
        Ok(model)
    }

    /// The mistakes that may have been made, the likeliest first: none where the model as given fits, several where they
    /// cannot be told apart. Several at once are one only where they explain more than each alone.
    pub fn likely(models: &[Self]) -> Vec<Self> {
        let mut likely: Vec<Self> = (models.iter().copied())
            .filter(|model| model.gain > model.mistake.gain_min())
            .collect();
        // What has more unknowns has to explain the more.
        let score = |model: &Self| model.gain - model.mistake.gain_min();
        likely.sort_by(|a, b| score(b).total_cmp(&score(a)));
        let best = likely.first().map_or(0.0, score);
        likely.retain(|model| best - score(model) < ALIKE);
        if likely.iter().any(|model| model.mistake != Mistake::Several) {
            likely.retain(|model| model.mistake != Mistake::Several);
        }
        likely
    }

    /// How large the values have to be for the mistake to be noticed.
    pub fn noticed(&self) -> [f64; 5] {
        self.sigmas
            .map(|sigma| self.mistake.gain_min().sqrt() * sigma)
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

    /// A pair with its sensor's plane corrected, what the mistake moves among its unknowns.
    fn freed(&self, pair: &PlanePair) -> PlanePair {
        let sensor = self.corrected(&pair.sensor);
        let mut common = pair.common.clone();
        for (cell, direction) in (CELL..).zip(self.mistake.directions()) {
            let mut other = *self;
            for (value, part) in other.values.iter_mut().zip(direction) {
                *value += STEP * part;
            }
            let moved = other.corrected(&pair.sensor);
            let turn = sensor.tangents().transpose()
                * (moved.normal.into_inner() - sensor.normal.into_inner());
            let change = Vector3::new(turn.x, turn.y, moved.distance_m - sensor.distance_m);
            common.push(CellEffect {
                cell,
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
