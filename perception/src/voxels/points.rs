//! Every point to the nearest of the planes around it, and the final planes.

use nalgebra::Vector3;

use super::grid::{self, Grid};
use super::lattice::POINTS_MIN;
use super::moments::{Moments, Plane};
use super::tolerance::Tolerance;
use crate::segmentation::{AMBIGUOUS_SYSTEMATICS, NONE, ON_PLANE, Partition};

/// The region of every point, or [`NONE`], and whether it surely is that: where another plane that it may
/// belong to agrees with its own, the border between both is anywhere.
pub(super) fn label(
    points: &[Vector3<f64>],
    grid: &Grid,
    found: &Partition<Moments>,
    tolerance: &Tolerance,
) -> (Vec<u16>, Vec<bool>) {
    let level = &grid.levels[0];
    // The planes that each voxel's points may belong to: its own and its neighbours'.
    let mut candidates: Vec<u16> = Vec::with_capacity(2 * level.cells.len());
    let mut starts = Vec::with_capacity(level.cells.len() + 1);
    for (i, around) in level.around.iter().enumerate() {
        let start = candidates.len();
        starts.push(start);
        let own = std::iter::once(found.owner[i]);
        let beside = around
            .iter()
            .filter(|k| **k != grid::NONE)
            .map(|&k| found.owner[k as usize]);
        for r in own.chain(beside).filter(|r| *r != NONE) {
            if !candidates[start..].contains(&r) {
                candidates.push(r);
            }
        }
    }
    starts.push(candidates.len());
    points
        .iter()
        .zip(&grid.of_point)
        .map(|(p, &cell)| {
            let here = &candidates[starts[cell as usize]..starts[cell as usize + 1]];
            let nearest = here
                .iter()
                .map(|&r| (found.regions[usize::from(r)].plane.height(p).abs(), r))
                .reduce(|a, b| if b < a { b } else { a });
            let Some((off, r)) = nearest else {
                return (NONE, false);
            };
            let plane = &found.regions[usize::from(r)].plane;
            if off > tolerance.at(p, plane, ON_PLANE.0, ON_PLANE.1) {
                return (NONE, false);
            }
            let on_plane = p - plane.normal * plane.height(p);
            let agrees = |other: &u16| {
                let other = &found.regions[usize::from(*other)].plane;
                let limit = tolerance.at(p, other, 0.0, AMBIGUOUS_SYSTEMATICS);
                other.height(&on_plane).abs() < limit
            };
            (r, !here.iter().filter(|other| **other != r).any(agrees))
        })
        .unzip()
}

/// The final plane of one region.
pub(super) struct Final {
    pub plane: Plane,
    /// Its points.
    pub members: Vec<u32>,
    /// Root mean square distance of the points, m.
    pub rms_m: f64,
}

impl Final {
    /// Unit normal n toward the eye, and d with n·p = −d for points p of V.
    #[allow(non_snake_case)]
    pub fn toward(&self, eye_V: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let toward = if self.plane.offset > 0.0 { -1.0 } else { 1.0 };
        let normal = self.plane.normal * toward;
        (normal, -(self.plane.offset * toward + normal.dot(eye_V)))
    }
}

/// Weighted least squares on the points of every region: an error of σ along the ray is one of
/// σ |n·ray| along the normal.
///
///   min Σ (n·p − d)² / (σ² + (κ r)²) (n·r̂)²
pub(super) fn fit(
    points: &[Vector3<f64>],
    labels: &[u16],
    found: &Partition<Moments>,
    tolerance: &Tolerance,
) -> Vec<Final> {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); found.regions.len()];
    for (i, &r) in (0_u32..).zip(labels) {
        if r != NONE {
            members[usize::from(r)].push(i);
        }
    }
    let mut planes = Vec::new();
    for (region, members) in found.regions.iter().zip(members) {
        if members.len() < POINTS_MIN {
            continue;
        }
        let mut moments = Moments::default();
        for &i in &members {
            let p = &points[i as usize];
            // Without the cap of the distance limit: that one says nothing of the noise.
            let range = p.norm();
            let sigma = tolerance.noise.sigma_z_m(range);
            let slow = tolerance.noise.systematic_ratio * range;
            let slant = (region.plane.normal.dot(p).abs() / range.max(1e-9)).max(0.1);
            moments.push(p, 1.0 / ((sigma * sigma + slow * slow) * slant * slant));
        }
        // Weights are of the order of 1e5: as a count they are far above three.
        let Some(fit) = moments.fit() else { continue };
        let square: f64 = (members.iter())
            .map(|&i| fit.plane.height(&points[i as usize]).powi(2))
            .sum();
        planes.push(Final {
            plane: fit.plane,
            rms_m: (square / members.len() as f64).sqrt(),
            members,
        });
    }
    planes
}
