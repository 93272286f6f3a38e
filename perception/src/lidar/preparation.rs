//! A cloud → the points that the planes are looked for in.

use nalgebra::Vector3;

use super::calibration::LidarCalibration;
use super::cloud::LidarCloud;
use super::config::LidarConfig;
use super::field::Field;
use super::joint_fit::BiasPrior;
use super::outliers::{self, NEIGHBOURS, ring_mean_distances, tree_mean_distances};
use super::rings::Rings;
use super::scan::LidarCounts;
use crate::Error;

/// The points in view without isolated ones, with their normals and links; and counts along the way.
///
/// # Errors
/// [`Error::FewPoints`], [`Error::Neighbours`].
pub(super) fn prepared(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
) -> Result<(Field, LidarCounts), Error> {
    let mut counts = LidarCounts {
        points: cloud.len(),
        invalid: cloud.invalid,
        ..LidarCounts::default()
    };
    let mut view = cloud.cropped(config.view_rad)?;
    if let Some(calibration) = calibration {
        correct(&mut view, &calibration.ring_bias_m);
    }
    let limits = (config.range_min_m, config.range_max_m);
    let few = |left: usize| Error::FewPoints {
        left,
        points: cloud.len(),
        invalid: cloud.invalid,
    };
    if let Some(mut rings) = Rings::new(&view, limits) {
        counts.in_view = rings.len();
        if rings.len() < 3 {
            return Err(few(rings.len()));
        }
        let means = if config.as_published {
            let points: Vec<_> = (0..rings.len())
                .map(|i| [rings.x[i], rings.y[i], rings.z[i]])
                .collect();
            tree_mean_distances(&points, NEIGHBOURS)?
        } else {
            ring_mean_distances(&rings, NEIGHBOURS)
        };
        let keep = outliers::inliers(&means, &rings.range, config.as_published);
        rings.retain(&keep);
        counts.kept = rings.len();
        if rings.len() < 3 {
            return Err(few(rings.len()));
        }
        return Ok((Field::on_rings(rings), counts));
    }
    let range = |p: &[f32; 3]| p.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>().sqrt();
    let near: Vec<u32> = (0..view.len() as u32)
        .filter(|&i| (limits.0..=limits.1).contains(&range(&view.points_V[i as usize])))
        .collect();
    let mut points: Vec<[f32; 3]> = near.iter().map(|&i| view.points_V[i as usize]).collect();
    let mut source = near;
    counts.in_view = points.len();
    if points.len() < 3 {
        return Err(few(points.len()));
    }
    let means = tree_mean_distances(&points, NEIGHBOURS)?;
    let ranges: Vec<f32> = points.iter().map(|p| range(p) as f32).collect();
    let keep = outliers::inliers(&means, &ranges, config.as_published);
    let mut kept = keep.iter();
    points.retain(|_| *kept.next().unwrap_or(&true));
    let mut kept = keep.iter();
    source.retain(|_| *kept.next().unwrap_or(&true));
    counts.kept = points.len();
    if points.len() < 3 {
        return Err(few(points.len()));
    }
    Ok((Field::of_points(points, source)?, counts))
}

/// Takes the rings' known range errors away.
fn correct(cloud: &mut LidarCloud, bias_m: &[f64]) {
    for (p, ring) in cloud.points_V.iter_mut().zip(&cloud.ring) {
        let Some(bias) = bias_m.get(usize::from(*ring)) else {
            continue;
        };
        let range = Vector3::from(*p).norm();
        if range > 0.0 {
            *p = p.map(|c| c * (1.0 - *bias as f32 / range));
        }
    }
}

/// What is known of the rings' errors once the calibrated ones are taken away.
pub(super) fn bias_prior(field: &Field, calibration: Option<&LidarCalibration>) -> BiasPrior {
    let rings = field.ring.iter().max().map_or(0, |r| usize::from(*r) + 1);
    let mut prior = BiasPrior::unknown(rings);
    if let Some(calibration) = calibration {
        for (sigma, known) in prior.sigma_m.iter_mut().zip(&calibration.ring_bias_sigma_m) {
            *sigma = known.min(*sigma);
        }
    }
    prior
}
