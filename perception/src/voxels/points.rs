//! Every point to the nearest of the planes around it, and the final planes.

use nalgebra::Vector3;

use super::grid::{self, Grid};
use super::lattice::POINTS_MIN;
use super::moments::{Moments, Plane};
use super::tolerance::Tolerance;
use crate::segmentation::{AMBIGUOUS_SYSTEMATICS, NONE, ON_PLANE, Partition};

/// Which points are whose.
pub(super) struct Labels {
    /// The region of every point, or [`NONE`].
    pub of_point: Vec<u16>,
    /// Whether it surely is that: where another plane that it may belong to agrees with its own, the border between
    /// both is anywhere.
    pub sure: Vec<bool>,
    /// For every region the points of no plane that are beside it on its free side. The lowest points of what stands on
    /// a face without a plane of its own, the foot of a table's leg, are as near to its plane as the face's own.
    pub standing: Vec<Vec<u32>>,
}

/// Every point to the nearest of the planes around it.
pub(super) fn label(
    points: &[Vector3<f64>],
    grid: &Grid,
    found: &Partition<Moments>,
    tolerance: &Tolerance,
) -> Labels {
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
    let plane = |r: u16| &found.regions[usize::from(r)].plane;
    let mut labels = Labels {
        of_point: Vec::with_capacity(points.len()),
        sure: Vec::with_capacity(points.len()),
        standing: vec![Vec::new(); found.regions.len()],
    };
    for (number, (p, &cell)) in (0..).zip(points.iter().zip(&grid.of_point)) {
        let here = &candidates[starts[cell as usize]..starts[cell as usize + 1]];
        let nearest = (here.iter())
            .map(|&r| (plane(r).height(p).abs(), r))
            .reduce(|a, b| if b < a { b } else { a });
        let limit = |r: u16| tolerance.at(p, plane(r), ON_PLANE.0, ON_PLANE.1);
        let own = nearest.filter(|(off, r)| *off <= limit(*r));
        let own = own.map_or(NONE, |(_, r)| r);
        let others = || here.iter().copied().filter(|r| *r != own);
        // The eye is the origin.
        let above = |r: u16| -plane(r).height(p) * plane(r).offset.signum();
        for r in here.iter().filter(|r| own == NONE && above(**r) > 0.0) {
            labels.standing[usize::from(*r)].push(number);
        }
        labels.of_point.push(own);
        labels.sure.push(
            own != NONE && {
                let on_plane = p - plane(own).normal * plane(own).height(p);
                let agrees = |other: u16| {
                    let limit = tolerance.at(p, plane(other), 0.0, AMBIGUOUS_SYSTEMATICS);
                    plane(other).height(&on_plane).abs() < limit
                };
                !others().any(agrees)
            },
        );
    }
    labels
}

/// The final plane of one region.
pub(super) struct Final {
    pub plane: Plane,
    /// Its points, and those that stand on it.
    pub members: Vec<u32>,
    pub standing: Vec<u32>,
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
    labels: &mut Labels,
    found: &Partition<Moments>,
    tolerance: &Tolerance,
) -> Vec<Final> {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); found.regions.len()];
    for (i, &r) in (0_u32..).zip(&labels.of_point) {
        if r != NONE {
            members[usize::from(r)].push(i);
        }
    }
    let mut planes = Vec::new();
    let sets = members
        .into_iter()
        .zip(std::mem::take(&mut labels.standing));
    for (region, (members, standing)) in found.regions.iter().zip(sets) {
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
            standing,
        });
    }
    planes
}
