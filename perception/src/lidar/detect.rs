//! From a LiDAR's cloud to the ground and the slopes on it: the whole chain, read top-down.

use nalgebra::{Matrix3, Point3};

use super::calibration::LidarCalibration;
use super::cloud::LidarCloud;
use super::config::LidarConfig;
use super::describe::{described, ground_covariance, ground_of};
use super::field::Field;
use super::ground::ground;
use super::joint_fit::BiasPrior;
use super::plane::Plane;
use super::preparation::{bias_prior, prepared};
use super::refine::{Refined, refined};
use super::scan::{LidarCounts, SlopeScan};
use super::slopes::{Patch, slopes};
use super::surroundings::{Surroundings, surroundings};
use super::world::levelled;
use crate::Error;

/// Ground and slopes of a cloud.
///
/// Without a calibration W is the frame that the ground gives ([`levelled`]). A cloud without a slope
/// gives none; that is a result and no error.
///
/// # Errors
/// [`Error::Config`]; [`Error::Calibration`]; [`Error::FewPoints`]; [`Error::NoGround`] when nothing
/// is ground and no calibration says where it is; [`Error::Neighbours`].
/// Source: \[meng\] III.
pub fn detect(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
) -> Result<SlopeScan, Error> {
    let (scan, _, counts) = chain(cloud, calibration, config)?;
    scan.ok_or(Error::NoGround {
        points: counts.kept,
    })
}

/// Ground and slopes of a cloud as [`detect`], and what else stands around.
///
/// Where nothing is ground there is no scan; walls and things are then in V, and counted as without
/// a calibration.
///
/// # Errors
/// As [`detect`], but for [`Error::NoGround`].
pub fn segment_cloud(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
) -> Result<SegmentedCloud, Error> {
    let (scan, field, counts) = chain(cloud, calibration, config)?;
    let around = surroundings(&field, scan.as_ref(), config);
    Ok(SegmentedCloud {
        scan,
        around,
        counts,
    })
}

/// What a cloud shows.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentedCloud {
    /// Ground and slopes; `None` where nothing is ground.
    pub scan: Option<SlopeScan>,
    /// Walls and things.
    pub around: Surroundings,
    /// Counts along the way.
    pub counts: LidarCounts,
}

/// The chain; no scan where nothing is ground and no calibration says where it is.
fn chain(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
) -> Result<(Option<SlopeScan>, Field, LidarCounts), Error> {
    config.check()?;
    calibration.map_or(Ok(()), LidarCalibration::check)?;

    // 1. What lies ahead and within range, less the rings' known errors.
    let (field, mut counts) = prepared(cloud, calibration, config)?;

    // 2. Ground: as seen, else as calibrated.
    let known = calibration.map(LidarCalibration::ground_V);
    let seen = ground(&field, known.as_ref(), config);
    let floor = match (seen, known) {
        (Some(plane), _) => plane,
        (None, Some(plane)) => plane,
        (None, None) => return Ok((None, field, counts)),
    };

    // 3. Slopes on it.
    let patches = slopes(&field, &floor, config);

    // 4. All planes and the rings' errors together.
    let prior = bias_prior(&field, calibration);
    let fitted = fit(&field, &floor, seen.is_some(), patches, &prior);

    // 5. In W, described.
    let ground_V = fitted.as_ref().map_or(floor, |f| f.ground_plane(&floor));
    let X_WV = calibration.map_or_else(|| levelled(&ground_V), LidarCalibration::X_WV);
    let known_covariance = calibration.map_or_else(Matrix3::zeros, ground_covariance);
    let slopes = match &fitted {
        Some(fitted) => (0..fitted.members.len())
            .filter_map(|k| {
                described(
                    &field,
                    fitted,
                    k,
                    &ground_V,
                    &X_WV,
                    &known_covariance,
                    config,
                )
            })
            .collect(),
        None => Vec::new(),
    };
    let points_W = field
        .points
        .iter()
        .map(|p| {
            (X_WV * Point3::from(p.map(f64::from)))
                .coords
                .map(|c| c as f32)
                .into()
        })
        .collect();
    let ground = ground_of(&fitted, ground_V, seen.is_some(), &X_WV, known_covariance);
    counts.ground = ground.members.len();
    let scan = SlopeScan {
        X_WV,
        points_W,
        source: field.source.clone(),
        ground,
        slopes,
        ring_bias_m: fitted.map(|f| f.fit.bias_m).unwrap_or_default(),
        counts,
    };
    Ok((Some(scan), field, counts))
}

/// Most that a slope may bend, root mean square, m: less than half of the 14 mm of 5 cm risers.
const UNEVEN_MAX_M: f64 = 0.006;

/// The joint fit; slopes that leave it without a solution are dropped, the smallest first, and those
/// that bend more than the noise and an uneven ramp explain: stairs, rubble.
fn fit(
    field: &Field,
    ground: &Plane,
    seen: bool,
    mut patches: Vec<Patch>,
    prior: &BiasPrior,
) -> Option<Refined> {
    loop {
        if !seen && patches.is_empty() {
            return None;
        }
        let Some(fitted) = refined(field, ground, seen, &patches, prior) else {
            patches.pop()?;
            continue;
        };
        let mut uneven = fitted.unevenness_m.iter().map(|bend| *bend > UNEVEN_MAX_M);
        let count = patches.len();
        patches.retain(|_| !uneven.next().unwrap_or(false));
        if patches.len() == count {
            return Some(fitted);
        }
    }
}
