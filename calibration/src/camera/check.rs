//! The mount from postures of which some may be wrong, and the sensor's model tested.

use nalgebra::Isometry3;

use super::refine::whitening;
use super::residual::Residual;
use super::{
    Agreement, CameraConfig, Identification, PlanePair, SensorModel, closed_form, identify,
};
use crate::Error;

/// Postures that disagree by more than this, in standard deviations, are left out; where most disagree
/// more than their noise says, in those of the median.
const OUTLIER: f64 = 5.0;
/// Median of the length of three Gaussians.
const MEDIAN: f64 = 1.54;
/// The part of the postures that may be left out.
const PART_MAX: f64 = 0.25;

/// A mount that was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// The mount from the postures that are left, with the agreement of all.
    pub found: Identification,
    /// Postures that are left out, ascending.
    pub left_out: Vec<usize>,
    /// Two of them that fit with their frames exchanged.
    pub swapped: Option<[usize; 2]>,
    /// What the postures say of the sensor, for each mistake that its model may have.
    pub sensor: Vec<SensorModel>,
}

/// The mount from the postures that agree on one.
///
/// The worst is left out as long as it disagrees by far, and comes back where it fits what is found
/// without it.
///
/// # Errors
/// As [`identify`].
pub fn identify_checked(pairs: &[PlanePair], config: &CameraConfig) -> Result<Checked, Error> {
    let mut kept: Vec<usize> = (0..pairs.len()).collect();
    let of = |kept: &[usize]| kept.iter().map(|&i| pairs[i].clone()).collect::<Vec<_>>();
    let most = (PART_MAX * pairs.len() as f64) as usize;
    loop {
        let chosen = of(&kept);
        // Where the refinement does not come to an end, the closed form tells who disagrees.
        let (refined, X_RV) = match identify(&chosen, config) {
            Ok(found) => (Ok(found.clone()), found.X_RV),
            Err(error @ Error::NotConverged { .. }) => (Err(error), closed_form(&chosen)?),
            Err(error) => return Err(error),
        };
        let off: Vec<f64> = pairs.iter().map(|pair| misfit_of(pair, &X_RV)).collect();
        let mut sorted: Vec<f64> = kept.iter().map(|&i| off[i]).collect();
        sorted.sort_by(f64::total_cmp);
        let limit = OUTLIER * (sorted[sorted.len() / 2] / MEDIAN).max(1.0);
        let worst = kept
            .iter()
            .copied()
            .max_by(|&a, &b| off[a].total_cmp(&off[b]));
        if let Some(worst) = worst
            && off[worst] > limit
            && pairs.len() - kept.len() < most
        {
            kept.retain(|&i| i != worst);
            continue;
        }
        let mut found = refined?;
        let left_out: Vec<usize> = (0..pairs.len()).filter(|i| !kept.contains(i)).collect();
        let sensor = SensorModel::all(&chosen, &found, config)?;
        let mut agreed = found.agreement.into_iter();
        found.agreement = (0..pairs.len())
            .filter_map(|i| match left_out.contains(&i) {
                true => Some(Agreement::of(&pairs[i], &X_RV, 0.0)),
                false => agreed.next(),
            })
            .collect();
        let fits = |robot: usize, sensor: usize| {
            let exchanged = PlanePair {
                robot: pairs[robot].robot,
                ..pairs[sensor].clone()
            };
            misfit_of(&exchanged, &X_RV) <= limit
        };
        let mut exchanged = left_out.iter().enumerate().flat_map(|(k, &i)| {
            let later = left_out[k + 1..].iter();
            later.map(move |&j| [i, j])
        });
        let swapped = exchanged.find(|&[i, j]| fits(i, j) && fits(j, i));
        return Ok(Checked {
            found,
            left_out,
            swapped,
            sensor,
        });
    }
}

/// Root mean square of what the postures disagree at the mount that fits them in the closed form, in
/// standard deviations.
///
/// # Errors
/// [`Error::Collinear`].
pub fn misfit(pairs: &[PlanePair]) -> Result<f64, Error> {
    let X_RV = closed_form(pairs)?;
    let squares = pairs.iter().map(|pair| misfit_of(pair, &X_RV).powi(2));
    Ok((squares.sum::<f64>() / (3 * pairs.len()).max(1) as f64).sqrt())
}

/// √(eᵀΣ⁻¹e) of a posture, what the device's distortion may do among Σ.
fn misfit_of(pair: &PlanePair, X_RV: &Isometry3<f64>) -> f64 {
    let residual = Residual::of(pair, X_RV);
    let common = pair.common.iter().map(|c| c.effect * c.effect.transpose());
    let covariance = residual.covariance + common.sum::<nalgebra::Matrix3<f64>>();
    (whitening(&covariance) * residual.value).norm()
}
