//! Thin upright things in a cloud.

use nalgebra::{Isometry3, Point3, Vector2, Vector3};
use perception::lidar::{ExtractedPlanes, gathered};

use super::LidarExtrinsicsConfig;

/// A pole in the levelled frame R below the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pole {
    /// Its axis: x and y in R, m.
    pub p_R: Vector2<f64>,
    /// Points on it.
    pub points: usize,
    /// Height over which it is seen, m.
    pub height_m: f64,
}

/// A pole's points lie within this of its axis, m.
const RADIUS_MAX_M: f64 = 0.10;
/// Least height over which a pole is seen, m.
const HEIGHT_MIN_M: f64 = 0.4;
/// Fewest points of a pole.
const POINTS_MIN: usize = 20;
/// Edge of the cells that points are gathered in, m; points in neighbouring cells belong together.
const CELL_M: f64 = 0.08;
/// Mean depth of a cylinder's visible side before its axis, in radii: ∫ cos² / ∫ cos = π/4.
const VISIBLE: f64 = std::f64::consts::FRAC_PI_4;

/// The poles among the points on no plane, by bearing from the right to the left.
///
/// Points of one column of the ground plan that hang together are a pole where they are thin, high
/// enough, and enough. Rings' errors are taken away first.
pub fn poles(
    survey: &ExtractedPlanes,
    X_RV: &Isometry3<f64>,
    ring_bias_m: &[f64],
    config: &LidarExtrinsicsConfig,
) -> Vec<Pole> {
    // 1. Free points in R over the ground.
    let free: Vec<Vector3<f64>> = (survey.free.iter())
        .map(|&i| {
            let p_V = Vector3::from(survey.points_V[i as usize].map(f64::from));
            let ring = survey.ring.get(i as usize).map(|r| usize::from(*r));
            let bias = ring
                .and_then(|r| ring_bias_m.get(r))
                .copied()
                .unwrap_or(0.0);
            (X_RV * Point3::from(p_V * (1.0 - bias / p_V.norm()))).coords
        })
        .collect();
    // 2. Gathered in the plan; thin, high and many.
    let plan: Vec<Vector2<f64>> = free.iter().map(|p| p.xy()).collect();
    let mut found: Vec<Pole> = gathered(&plan, CELL_M)
        .into_iter()
        .filter_map(|group| {
            let points: Vec<Vector3<f64>> = group.iter().map(|&i| free[i as usize]).collect();
            pole(&points, config)
        })
        .collect();
    found.sort_by(|a, b| {
        let bearing = |pole: &Pole| pole.p_R.y.atan2(pole.p_R.x);
        bearing(a).total_cmp(&bearing(b))
    });
    found
}

fn pole(points: &[Vector3<f64>], config: &LidarExtrinsicsConfig) -> Option<Pole> {
    if points.len() < POINTS_MIN {
        return None;
    }
    // The median is not moved by the strays that were gathered too.
    let median = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let middle = Vector2::new(median(0), median(1));
    let near: Vec<&Vector3<f64>> = points
        .iter()
        .filter(|p| (p.xy() - middle).norm() <= RADIUS_MAX_M)
        .collect();
    // A group that is mostly wider is no pole.
    if near.len() * 10 < points.len() * 8 || near.len() < POINTS_MIN {
        return None;
    }
    let low = near.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let high = near.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    if high - low < HEIGHT_MIN_M {
        return None;
    }
    // Bearing and distance apart: the range is noisier.
    let n = near.len() as f64;
    let mean: Vector2<f64> = near.iter().map(|p| p.xy()).sum::<Vector2<f64>>() / n;
    let ahead = mean.try_normalize(1e-6)?;
    Some(Pole {
        p_R: mean + ahead * (VISIBLE * config.pole_diameter_m / 2.0),
        points: near.len(),
        height_m: high - low,
    })
}
