//! From a LiDAR's cloud to the ground and the slopes on it: the whole chain, read top-down.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::calibration::LidarCalibration;
use super::cloud::LidarCloud;
use super::description::Description;
use super::edges;
use super::field::Field;
use super::ground::{GroundConfig, ground};
use super::joint_fit::BiasPrior;
use super::outliers::{
    self, Normalisation, OutlierConfig, ring_mean_distances, tree_mean_distances,
};
use super::plane::{Plane, RangeErrors};
use super::prosac::ConsensusConfig;
use super::refine::{CLEAR_M, Refined, meet, refined};
use super::rings::Rings;
use super::slopes::{Patch, SlopeConfig, slopes};
use super::world::levelled;
use crate::Error;
use crate::error::within;

/// Parameters of the LiDAR chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LidarConfig {
    /// Horizontal field of view about V's x, rad.
    pub view_rad: f64,
    /// Nearer points are the robot's own, m.
    pub range_min_m: f64,
    /// Farther points are not used, m.
    pub range_max_m: f64,
    /// Errors of a measured point.
    pub errors: RangeErrors,
    /// Isolated points.
    pub outliers: OutlierConfig,
    /// The search for planes.
    pub consensus: ConsensusConfig,
    /// The ground.
    pub ground: GroundConfig,
    /// The slopes.
    pub slope: SlopeConfig,
}

impl Default for LidarConfig {
    /// Half a turn, as [meng] IV.
    fn default() -> Self {
        Self {
            view_rad: std::f64::consts::PI,
            range_min_m: 0.4,
            range_max_m: 20.0,
            errors: RangeErrors::default(),
            outliers: OutlierConfig::default(),
            consensus: ConsensusConfig::default(),
            ground: GroundConfig::default(),
            slope: SlopeConfig::default(),
        }
    }
}

impl LidarConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        let turn = std::f64::consts::TAU + 1e-9;
        within(
            "lidar.view_rad",
            self.view_rad,
            1e-3,
            turn,
            "must be in (0, 2π]",
        )?;
        within(
            "lidar.range_min_m",
            self.range_min_m,
            0.0,
            1e3,
            "must not be negative",
        )?;
        let cause = "must be more than range_min_m";
        within(
            "lidar.range_max_m",
            self.range_max_m,
            self.range_min_m + 1e-3,
            1e6,
            cause,
        )?;
        self.errors.check()?;
        self.outliers.check()?;
        self.consensus.check()?;
        self.ground.check()?;
        self.slope.check()
    }
}

/// How many points there were after each step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct LidarCounts {
    /// Finite points of the cloud.
    pub points: usize,
    /// Points that were invalid.
    pub invalid: usize,
    /// Points in the field of view and within range.
    pub in_view: usize,
    /// Points that are not isolated.
    pub kept: usize,
    /// Points on the ground.
    pub ground: usize,
}

/// The ground of a scan.
#[derive(Debug, Clone, PartialEq)]
#[allow(non_snake_case)]
pub struct Ground {
    /// The plane in V.
    pub plane_V: Plane,
    /// Whether this scan shows it; else it is the calibrated one.
    pub seen: bool,
    /// Root mean square distance of its points, m; 0 where it was not seen.
    pub rms_m: f64,
    /// Covariance of (rotation about x_W, rotation about y_W, height) at `centre_W`: rad, rad, m.
    pub covariance: Matrix3<f64>,
    /// The mean of its points, m.
    pub centre_W: Point3<f64>,
    /// Its points, indices into [`SlopeScan::points_W`].
    pub members: Vec<u32>,
}

/// A slope of a scan.
#[derive(Debug, Clone, PartialEq)]
#[allow(non_snake_case)]
pub struct Slope {
    /// Start line, orientation, angle.
    pub description: Description,
    /// Standard deviation of δ, rad.
    pub delta_sigma_rad: f64,
    /// Standard deviation of p₁ and p₂ across the start line, along the ground, m.
    pub across_sigma_m: [f64; 2],
    /// Standard deviation of p₁ and p₂ along the start line, m.
    pub along_sigma_m: [f64; 2],
    /// The plane in V.
    pub plane_V: Plane,
    /// Covariance of (tilt along t₁, tilt along t₂, distance) at `centre_V`: rad, rad, m.
    pub covariance: Matrix3<f64>,
    /// The mean of its points in V, m.
    pub centre_V: Vector3<f64>,
    /// The tangents t₁ and t₂ in V.
    pub tangents_V: [Vector3<f64>; 2],
    /// Root mean square distance of its points, m.
    pub rms_m: f64,
    /// Its points, indices into [`SlopeScan::points_W`].
    pub members: Vec<u32>,
}

/// What a scan shows of ground and slopes, in W.
#[derive(Debug, Clone, PartialEq)]
#[allow(non_snake_case)]
pub struct SlopeScan {
    /// Pose of V in W: the calibrated one, or the one that the ground gives.
    pub X_WV: Isometry3<f64>,
    /// The points that were used, in W, m.
    pub points_W: Vec<[f32; 3]>,
    /// Index in the cloud of every one of them.
    pub source: Vec<u32>,
    /// The ground.
    pub ground: Ground,
    /// The slopes, the largest consensus set first.
    pub slopes: Vec<Slope>,
    /// The rings' range errors beyond the calibrated ones, as this scan shows them, m.
    pub ring_bias_m: Vec<f64>,
    /// Counts along the way.
    pub counts: LidarCounts,
}

/// Ground and slopes of a cloud.
///
/// Without a calibration W is the frame that the ground gives ([`levelled`]). A cloud without a slope
/// gives none; that is a result and no error.
///
/// # Errors
/// [`Error::Config`]; [`Error::Calibration`]; [`Error::FewPoints`]; [`Error::NoGround`] when nothing
/// is ground and no calibration says where it is; [`Error::Neighbours`].
/// Source: [meng] III.
#[allow(non_snake_case)]
pub fn detect(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
) -> Result<SlopeScan, Error> {
    config.check()?;
    calibration.map_or(Ok(()), LidarCalibration::check)?;

    // 1. What lies ahead and within range, less the rings' known errors.
    let mut counts = LidarCounts {
        points: cloud.len(),
        invalid: cloud.invalid,
        ..LidarCounts::default()
    };
    let field = prepared(cloud, calibration, config, &mut counts)?;

    // 2. Ground: as seen, else as calibrated.
    let known = calibration.map(LidarCalibration::ground_V);
    let (search, errors) = (&config.consensus, &config.errors);
    let seen = ground(&field, known.as_ref(), &config.ground, search, errors);
    let floor = match (seen, known) {
        (Some(plane), _) => plane,
        (None, Some(plane)) => plane,
        (None, None) => {
            return Err(Error::NoGround {
                points: counts.kept,
            });
        }
    };

    // 3. Slopes on it.
    let patches = slopes(&field, &floor, &config.slope, search, errors);

    // 4. All planes and the rings' errors together.
    let prior = bias_prior(&field, calibration, errors);
    let fitted = fit(&field, &floor, seen.is_some(), patches, &prior, errors);

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
    Ok(SlopeScan {
        X_WV,
        points_W,
        source: field.source,
        ground,
        slopes,
        ring_bias_m: fitted.map(|f| f.fit.bias_m).unwrap_or_default(),
        counts,
    })
}

/// The points in view without isolated ones, with their normals and links.
///
/// # Errors
/// [`Error::FewPoints`], [`Error::Neighbours`].
pub(super) fn prepared(
    cloud: &LidarCloud,
    calibration: Option<&LidarCalibration>,
    config: &LidarConfig,
    counts: &mut LidarCounts,
) -> Result<Field, Error> {
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
    let filter = &config.outliers;
    if let Some(mut rings) = Rings::new(&view, limits) {
        counts.in_view = rings.len();
        if rings.len() < 3 {
            return Err(few(rings.len()));
        }
        if filter.enabled {
            let means = match filter.normalisation {
                Normalisation::Range => ring_mean_distances(&rings, filter.neighbours),
                // The paper's own, to the letter.
                Normalisation::Plain => {
                    let points: Vec<_> = (0..rings.len())
                        .map(|i| [rings.x[i], rings.y[i], rings.z[i]])
                        .collect();
                    tree_mean_distances(&points, filter.neighbours)?
                }
            };
            let keep = outliers::inliers(&means, &rings.range, filter);
            rings.retain(&keep);
        }
        counts.kept = rings.len();
        if rings.len() < 3 {
            return Err(few(rings.len()));
        }
        return Ok(Field::on_rings(rings));
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
    if filter.enabled {
        let means = tree_mean_distances(&points, filter.neighbours)?;
        let ranges: Vec<f32> = points.iter().map(|p| range(p) as f32).collect();
        let keep = outliers::inliers(&means, &ranges, filter);
        let mut kept = keep.iter();
        points.retain(|_| *kept.next().unwrap_or(&true));
        let mut kept = keep.iter();
        source.retain(|_| *kept.next().unwrap_or(&true));
    }
    counts.kept = points.len();
    if points.len() < 3 {
        return Err(few(points.len()));
    }
    Field::of_points(points, source)
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
pub(super) fn bias_prior(
    field: &Field,
    calibration: Option<&LidarCalibration>,
    errors: &RangeErrors,
) -> BiasPrior {
    let rings = field.ring.iter().max().map_or(0, |r| usize::from(*r) + 1);
    let mut prior = BiasPrior::unknown(rings, errors);
    if let Some(calibration) = calibration {
        for (sigma, known) in prior.sigma_m.iter_mut().zip(&calibration.ring_bias_sigma_m) {
            *sigma = known.min(*sigma);
        }
    }
    prior
}

/// The joint fit; slopes that leave it without a solution are dropped, the smallest first.
fn fit(
    field: &Field,
    ground: &Plane,
    seen: bool,
    mut patches: Vec<Patch>,
    prior: &BiasPrior,
    errors: &RangeErrors,
) -> Option<Refined> {
    loop {
        if !seen && patches.is_empty() {
            return None;
        }
        let fitted = refined(field, ground, seen, &patches, prior, errors);
        if fitted.is_some() || patches.pop().is_none() {
            return fitted;
        }
    }
}

/// Covariance of (rotation about x_W, about y_W, height) of the calibrated ground.
fn ground_covariance(calibration: &LidarCalibration) -> Matrix3<f64> {
    let rows = [0, 1, 3];
    Matrix3::from_fn(|i, j| calibration.covariance[rows[i]][rows[j]])
}

#[allow(non_snake_case)]
fn ground_of(
    fitted: &Option<Refined>,
    plane_V: Plane,
    seen: bool,
    X_WV: &Isometry3<f64>,
    known: Matrix3<f64>,
) -> Ground {
    let mut ground = Ground {
        plane_V,
        seen,
        rms_m: 0.0,
        covariance: known,
        centre_W: Point3::origin(),
        members: Vec::new(),
    };
    if let Some(fitted) = fitted.as_ref().filter(|f| f.first_slope == 1) {
        let (fit, n) = (&fitted.fit, plane_V.normal);
        // A tilt θ₁ along t₁ is a rotation by θ₁ about n × t₁.
        let [a, b] = fit.tangents[0].map(|t| X_WV * n.cross(&t));
        let turn = Matrix3::new(a.x, b.x, 0.0, a.y, b.y, 0.0, 0.0, 0.0, -1.0);
        let block = fit.covariance.fixed_view::<3, 3>(0, 0);
        ground.covariance = turn * block * turn.transpose();
        ground.rms_m = fit.rms_m[0];
        ground.centre_W = X_WV * Point3::from(fit.centres[0]);
        ground.members.clone_from(&fitted.ground);
    }
    ground
}

/// The description of slope `k` and its uncertainty; `None` where slope and ground do not meet.
#[allow(non_snake_case)]
fn described(
    field: &Field,
    fitted: &Refined,
    k: usize,
    ground: &Plane,
    X_WV: &Isometry3<f64>,
    known: &Matrix3<f64>,
    config: &LidarConfig,
) -> Option<Slope> {
    let fit = &fitted.fit;
    let at = fitted.first_slope + k;
    let plane = fit.planes[at];
    let (n_s, n_g) = (plane.normal, ground.normal);
    // Eqs. 11 and 14: l along the intersection, ψ uphill.
    let l = n_s.cross(&n_g).try_normalize(1e-6)?;
    let psi = l.cross(&n_s);
    let ahead = l.cross(&n_g);
    let delta = n_s.dot(&n_g).clamp(-1.0, 1.0).acos();
    let inclinations = config.slope.inclination_min_rad..=config.slope.inclination_max_rad;
    if !inclinations.contains(&delta) {
        return None;
    }
    // Ground beside the slope lies in its plane as well, near the line.
    let clear: Vec<u32> = (fitted.members[k].iter().copied())
        .filter(|&i| ground.distance(&field.point(i as usize)).abs() > CLEAR_M)
        .collect();
    let edges = edges::along(field, &clear, &l)?;
    let origin = meet(ground, &plane, &Vector3::zeros())?;
    let ends = [edges.low, edges.high].map(|t| origin + l * (t - origin.dot(&l)));

    // Derivatives by the planes' errors (θ₁, θ₂, δ).
    let [s1, s2] = fit.tangents[at];
    let ground_frame = (fitted.first_slope == 1).then(|| (fit.tangents[0], fit.centres[0]));
    // A calibrated ground's errors are rotations about x_W and y_W, and the height.
    let R_VW = X_WV.rotation.inverse();
    let ([g1, g2], g_centre, sign) = match ground_frame {
        Some((tangents, centre)) => (tangents, centre, 1.0),
        None => (
            [R_VW * -Vector3::y(), R_VW * Vector3::x()],
            X_WV.inverse_transform_point(&Point3::origin()).coords,
            -1.0,
        ),
    };
    let delta_variance = fitted.variance(
        k,
        &[ahead.dot(&g1), ahead.dot(&g2), 0.0],
        &[-psi.dot(&s1), -psi.dot(&s2), 0.0],
        known,
    );
    // Across the line the intersection moves by (e_s − e_g cos δ)/sin δ.
    let across = ends.map(|q| {
        let (ds, dg) = (q - fit.centres[at], q - g_centre);
        let by_slope = [s1.dot(&ds), s2.dot(&ds), 1.0].map(|v| v / delta.sin());
        let by_ground = [g1.dot(&dg), g2.dot(&dg), sign].map(|v| -v * delta.cos() / delta.sin());
        fitted.variance(k, &by_ground, &by_slope, known).sqrt()
    });
    let [p1_W, p2_W] = ends.map(|q| X_WV * Point3::from(q));
    let block = fit
        .covariance
        .fixed_view::<3, 3>(3 * at, 3 * at)
        .into_owned();
    Some(Slope {
        description: Description {
            p1_W,
            p2_W,
            l_W: X_WV * l,
            psi_W: X_WV * psi,
            normal_W: X_WV * n_s,
            delta_rad: delta,
        },
        delta_sigma_rad: delta_variance.sqrt(),
        across_sigma_m: across,
        along_sigma_m: [edges.low_sigma, edges.high_sigma],
        plane_V: plane,
        covariance: block,
        centre_V: fit.centres[at],
        tangents_V: fit.tangents[at],
        rms_m: fit.rms_m[at],
        members: fitted.members[k].clone(),
    })
}
