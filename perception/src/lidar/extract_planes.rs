//! All planes of a cloud, and the rings' range errors from the planes of several clouds.

use nalgebra::{Matrix3, Vector3};

use super::cloud::LidarCloud;
use super::config::LidarConfig;
use super::field::Field;
use super::ground::ground;
use super::joint_fit::{BiasPrior, Observation, joint_fit};
use super::plane::{Plane, RING_BIAS_SIGMA_M, variance};
use super::preparation::prepared;
use super::prosac::DISTANCE_M;
use super::scan::LidarCounts;
use super::slopes::{PatchSearch, largest_part, patches};
use crate::Error;

/// The planes of a cloud in V.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExtractedPlanes {
    /// The points that were used, m.
    pub points_V: Vec<[f32; 3]>,
    /// Ring of each; empty where there are none.
    pub ring: Vec<u16>,
    /// The ground first where there is one, then walls and slopes, the largest consensus set first.
    pub planes: Vec<ExtractedPlane>,
    /// Whether the first plane is the ground.
    pub has_ground: bool,
    /// Points on no plane, indices into `points_V`.
    pub free: Vec<u32>,
    /// Counts along the way.
    pub counts: LidarCounts,
}

/// A plane and its points.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtractedPlane {
    /// The plane in V.
    pub plane: Plane,
    /// Its points, indices into [`ExtractedPlanes::points_V`].
    pub members: Vec<u32>,
    /// Root mean square distance of these, m.
    pub rms_m: f64,
}

/// Fewest points of a plane that is not the ground.
const POINTS_MIN: usize = 120;
/// Most planes beside the ground, and planes that are tried for each.
const PLANES_MAX: usize = 24;
pub(super) const TRIES: u64 = 8;
/// Points are of a plane up to this many standard deviations from it.
const GATE_SIGMAS: f64 = 3.5;
/// Cosine of the largest angle between their normals and its own.
const AGREE: f64 = 0.85;

/// The ground, walls and other planes of a cloud.
///
/// # Errors
/// [`Error::Config`], [`Error::FewPoints`], [`Error::Neighbours`].
pub fn extract_planes(cloud: &LidarCloud, config: &LidarConfig) -> Result<ExtractedPlanes, Error> {
    config.check()?;
    let (field, mut counts) = prepared(cloud, None, config)?;
    let floor = ground(&field, None, config);

    // What is not ground: planes of any direction that hang together.
    let mut free: Vec<bool> = (0..field.len())
        .map(|i| floor.is_none_or(|g| g.distance(&field.point(i)).abs() > DISTANCE_M))
        .collect();
    let wanted = PatchSearch {
        points_min: POINTS_MIN,
        count_max: PLANES_MAX,
        tries: TRIES,
        over: None,
    };
    let found = patches(
        &field,
        &mut free,
        &wanted,
        config,
        |_| true,
        |_| true,
        |_| true,
    );
    let mut planes: Vec<ExtractedPlane> = Vec::new();
    if let Some(plane) = floor {
        planes.push(surveyed(&field, plane, (0..field.len() as u32).collect()));
        counts.ground = planes[0].members.len();
    }
    let mut taken = vec![false; field.len()];
    for patch in found {
        let members = extended(&field, &patch.plane, |i| {
            !taken[i] && floor.is_none_or(|g| g.distance(&field.point(i)).abs() > DISTANCE_M)
        });
        if members.len() < POINTS_MIN {
            continue;
        }
        members.iter().for_each(|&i| taken[i as usize] = true);
        planes.push(surveyed(&field, patch.plane, members));
    }
    // Where two planes meet, points are of neither: they would bend both.
    let all: Vec<Plane> = planes.iter().map(|p| p.plane).collect();
    let mut folds: Vec<u32> = Vec::new();
    for (k, surveyed) in planes.iter_mut().enumerate() {
        surveyed.members.retain(|&i| {
            let mut crossing = all
                .iter()
                .filter(|other| other.normal.dot(&all[k].normal).abs() < AGREE);
            let alone = !crossing.any(|other| lies_on(&field, i as usize, other));
            if !alone {
                folds.push(i);
            }
            alone
        });
    }
    for plane in &planes {
        for &i in &plane.members {
            taken[i as usize] = true;
        }
    }
    for i in folds {
        taken[i as usize] = true;
    }
    Ok(ExtractedPlanes {
        free: (0..field.len() as u32)
            .filter(|&i| !taken[i as usize])
            .collect(),
        points_V: field.points,
        ring: field.ring,
        planes,
        has_ground: floor.is_some(),
        counts,
    })
}

/// The points that `among` names on a plane found by consensus, as far as they hang together: the
/// consensus set is cut off where rings with large errors have half their points.
pub(super) fn extended(field: &Field, plane: &Plane, among: impl Fn(usize) -> bool) -> Vec<u32> {
    let agrees = |i: usize| {
        let normal = field.normal(i);
        normal.is_none_or(|n| n.dot(&plane.normal) > AGREE)
    };
    let on: Vec<bool> = (0..field.len())
        .map(|i| among(i) && lies_on(field, i, plane) && agrees(i))
        .collect();
    largest_part(field, &on, |_| false)
}

/// A plane with those of the points that lie on it as well as their errors let them.
fn surveyed(field: &Field, plane: Plane, among: Vec<u32>) -> ExtractedPlane {
    let members: Vec<u32> = among
        .into_iter()
        .filter(|&i| lies_on(field, i as usize, &plane))
        .collect();
    let squares = members
        .iter()
        .map(|&i| plane.distance(&field.point(i as usize)).powi(2));
    ExtractedPlane {
        plane,
        rms_m: (squares.sum::<f64>() / members.len().max(1) as f64).sqrt(),
        members,
    }
}

/// Whether a point's distance from a plane is what its errors and its ring's may make it.
fn lies_on(field: &Field, i: usize, plane: &Plane) -> bool {
    let p = field.point(i);
    let n_u = plane.normal.dot(&p) / p.norm();
    let bias = n_u * RING_BIAS_SIGMA_M;
    let variance = variance(n_u, p.norm()) + bias * bias;
    plane.distance(&p).powi(2) < GATE_SIGMAS * GATE_SIGMAS * variance
}

/// The ground under a mounted LiDAR and its rings' constant range errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjustment {
    /// The ground in V.
    pub ground_V: Plane,
    /// Covariance of (rotation about x_V, about y_V, about z_V; the one about the normal is zero) and
    /// of the height over the point of the ground below the sensor: rad, m.
    pub ground_covariance: nalgebra::Matrix4<f64>,
    /// Constant range error of every ring, m; empty where clouds have no rings.
    pub ring_bias_m: Vec<f64>,
    /// Standard deviation of each, m.
    pub ring_bias_sigma_m: Vec<f64>,
    /// Root mean square residual of all planes before and after the rings' errors, m.
    pub rms_m: [f64; 2],
    /// Planes that took part.
    pub planes: usize,
}

/// The ground and the rings' range errors that explain the planes of all surveys best.
///
/// The mount is the same in all of them, so that their ground is one plane; walls and slopes are each
/// survey's own. `None` without a ground.
pub fn adjust(surveys: &[ExtractedPlanes]) -> Option<Adjustment> {
    let mut planes: Vec<Plane> = Vec::new();
    let mut observations: Vec<Observation> = Vec::new();
    let mut rings = 0;
    for survey in surveys.iter().filter(|s| s.has_ground) {
        for (k, surveyed) in survey.planes.iter().enumerate() {
            let index = if k == 0 && !planes.is_empty() {
                0
            } else {
                planes.push(surveyed.plane);
                planes.len() - 1
            };
            for &i in &surveyed.members {
                let ring = survey.ring.get(i as usize).map(|r| usize::from(*r));
                rings = rings.max(ring.map_or(0, |r| r + 1));
                observations.push(Observation {
                    plane: index,
                    ring,
                    p: Vector3::from(survey.points_V[i as usize].map(f64::from)),
                });
            }
        }
    }
    if planes.is_empty() {
        return None;
    }
    let none = BiasPrior {
        sigma_m: vec![1e-9; rings],
        ..BiasPrior::unknown(rings)
    };
    let plain = joint_fit(&observations, &planes, &none)?;
    let prior = BiasPrior::unknown(rings);
    let fit = joint_fit(&observations, &plain.planes, &prior)?;
    let total = |fit: &super::joint_fit::JointFit| {
        let mut counts = vec![0.0; planes.len()];
        observations.iter().for_each(|o| counts[o.plane] += 1.0);
        let squares: f64 = fit.rms_m.iter().zip(&counts).map(|(r, n)| r * r * n).sum();
        (squares / observations.len() as f64).sqrt()
    };
    let ground = fit.planes[0];
    // The plane's errors about its centre, as a rotation and the distance below the sensor.
    let [t1, t2] = fit.tangents[0];
    let block: Matrix3<f64> = fit.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let (r1, r2) = (ground.normal.cross(&t1), ground.normal.cross(&t2));
    let below = -ground.normal * ground.offset_m - fit.centres[0];
    let mut turn = nalgebra::Matrix4x3::zeros();
    turn.fixed_view_mut::<3, 1>(0, 0).copy_from(&r1);
    turn.fixed_view_mut::<3, 1>(0, 1).copy_from(&r2);
    turn.fixed_view_mut::<1, 3>(3, 0)
        .copy_from(&nalgebra::RowVector3::new(
            t1.dot(&below),
            t2.dot(&below),
            1.0,
        ));
    let first = 3 * planes.len();
    let sigma = |ring: usize| fit.covariance[(first + ring, first + ring)].max(0.0).sqrt();
    Some(Adjustment {
        ground_V: ground,
        ground_covariance: turn * block * turn.transpose(),
        ring_bias_sigma_m: (0..rings).map(sigma).collect(),
        rms_m: [total(&plain), total(&fit)],
        ring_bias_m: fit.bias_m,
        planes: planes.len(),
    })
}
