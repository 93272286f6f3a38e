//! The mount of a sensor from the ground's planes of several postures.
//!
//! Each posture i gives the ground twice: as the plane (n_R, h) that the robot's feet say, and as
//! the plane (n_V, d) that the sensor saw. With e the disagreement of the two,
//!
//!   min over X_RV  Σ ρ(eᵢᵀ Σᵢ⁻¹ eᵢ),   eᵢ = [ Tᵢᵀ (n_V − R_RVᵀ n_R) ;  d − (n_R · p_RV + h) ],
//!
//! where Tᵢ are the tangents of n_V, ρ is Huber's loss, and Σᵢ is what the sensor's noise *and* the
//! robot's pose noise make of e: a tilt of the body turns the normal and, over the lever p_RV,
//! moves the distance, and the two errors are weighted as the pair they are. The device's
//! distortion, which all frames share, is estimated along: unknowns c of unit variance that move
//! eᵢ by Cᵢ c.
//!
//! * [`paper`]: the six parameters as \[chai2015\] writes them.
//! * [`observability`]: what a set of poses can tell, and the names of those that cannot.
//! * [`design`]: which posture to add.
//! * [`identify_checked`]: postures that do not fit left out, the sensor's own model tested.
//!
//! Source: \[chai2015\] Section 4.3; deviation: Eq. 31 weighs direction cosines and metres alike and
//! takes the robot's pose for exact. Its two halves decouple, which gives the start: the rotation
//! by the nearest rotation of the normals, the position by linear least squares.

mod agreement;
mod check;
mod closed_form;
mod config;
pub mod design;
pub mod observability;
pub mod paper;
mod refine;
mod residual;
mod sensor_model;

pub use agreement::Agreement;
pub use check::{Checked, identify_checked, misfit};
pub use closed_form::closed_form;
pub use config::CameraConfig;
pub use design::{Candidate, NextPose, next_pose};
pub use observability::{Degeneracy, Observability};
pub use paper::PaperParameters;
pub use sensor_model::{Mistake, SensorModel};

use nalgebra::{Isometry3, Matrix6};

use crate::ground::CellEffect;
use crate::{Error, GroundPlane};

/// Root mean square by which the tilts must vary in every direction, rad.
const TILT_SPREAD_MIN_RAD: f64 = 1.0_f64.to_radians();

/// The ground of one posture, twice.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanePair {
    /// In R, from the robot's feet; its covariance is the robot's pose noise.
    pub robot: GroundPlane,
    /// In V, from the scan; its covariance is the sensor's noise, drawn anew in each frame.
    pub sensor: GroundPlane,
    /// What the device's distortion, which all frames share, does to `sensor`.
    pub common: Vec<CellEffect>,
}

impl PlanePair {
    /// A pair without errors that frames share.
    pub fn new(robot: GroundPlane, sensor: GroundPlane) -> Self {
        Self {
            robot,
            sensor,
            common: Vec::new(),
        }
    }
}

/// A mount, and how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// Pose of the sensor's frame V in the robot's frame R.
    pub X_RV: Isometry3<f64>,
    /// Covariance of (δθ, δp): R_RV = exp(δθ) R̂, p_RV = p̂ + δp, both in R; rad, m. It is already
    /// multiplied by [`Self::noise_factor`]² where that is above 1.
    pub covariance: Matrix6<f64>,
    /// √(χ²/(3n − 6)): how much larger the residuals are than the stated noise.
    pub noise_factor: f64,
    /// What the poses tell.
    pub observability: Observability,
    /// Disagreement of the two planes of every posture.
    pub agreement: Vec<Agreement>,
    /// Iterations of the refinement.
    pub iterations: usize,
}

/// The mount from the planes of at least three different tilts.
///
/// # Errors
/// [`Error::Degenerate`] for poses that do not determine all six parameters, by name;
/// [`Error::NotConverged`]; [`Error::Config`].
pub fn identify(pairs: &[PlanePair], config: &CameraConfig) -> Result<Identification, Error> {
    config.check()?;
    // 1. Can these poses tell?
    let observability = Observability::of(pairs, TILT_SPREAD_MIN_RAD);
    if let Some(degeneracy) = observability.degeneracy {
        return Err(Error::Degenerate(degeneracy));
    }
    // 2. Closed form, then the joint weighted problem.
    let start = closed_form(pairs)?;
    let refined = refine::refine(pairs, &start, config)?;
    let observability = observability.at(pairs, &refined.X_RV);
    // 3. What is left over.
    let weighed = pairs.iter().zip(&refined.weights);
    let agreement = weighed.map(|(pair, weight)| Agreement::of(pair, &refined.X_RV, *weight));
    let freedom = (3 * pairs.len()).saturating_sub(6).max(1) as f64;
    let noise_factor = (refined.chi2 / freedom).sqrt();
    Ok(Identification {
        X_RV: refined.X_RV,
        covariance: refined.covariance * noise_factor.max(1.0).powi(2),
        noise_factor,
        observability,
        agreement: agreement.collect(),
        iterations: refined.iterations,
    })
}
