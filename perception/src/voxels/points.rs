//! Every point to the nearest of the planes around it, and the final planes.

use nalgebra::Vector3;

use super::grid::{self, Grid};
use super::lattice::POINTS_MIN;
use super::moments::{Moments, Plane};
use super::near::Near;
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
    /// Of every region how many points it has, and their weighted moments.
    sums: Vec<(usize, Moments)>,
}

/// Every point to the nearest of the planes around it.
pub(super) fn label(
    points: &Near,
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
    let count = points.places.len();
    let mut labels = Labels {
        of_point: Vec::with_capacity(count),
        sure: Vec::with_capacity(count),
        standing: vec![Vec::new(); found.regions.len()],
        sums: vec![Default::default(); found.regions.len()],
    };
    for (run, cell) in &grid.runs {
        let here = &candidates[starts[*cell as usize]..starts[*cell as usize + 1]];
        for number in run.clone() {
            let p = &points.at(number);
            let nearest = (here.iter())
                .map(|&r| (plane(r).height(p).abs(), r))
                .reduce(|a, b| if b < a { b } else { a });
            let limit = |r: u16| tolerance.at(p, plane(r), ON_PLANE.0, ON_PLANE.1);
            let own = nearest.filter(|(off, r)| *off <= limit(*r));
            let Some((_, own)) = own else {
                // The eye is the origin.
                let above = |r: u16| -plane(r).height(p) * plane(r).offset.signum();
                for r in here.iter().filter(|r| above(**r) > 0.0) {
                    labels.standing[usize::from(*r)].push(number);
                }
                labels.of_point.push(NONE);
                labels.sure.push(false);
                continue;
            };
            let agrees = |other: u16| {
                let on_plane = p - plane(own).normal * plane(own).height(p);
                let limit = tolerance.at(p, plane(other), 0.0, AMBIGUOUS_SYSTEMATICS);
                plane(other).height(&on_plane).abs() < limit
            };
            let others = here.iter().filter(|r| **r != own);
            labels.of_point.push(own);
            labels.sure.push(!others.copied().any(agrees));
            let (count, moments) = &mut labels.sums[usize::from(own)];
            *count += 1;
            moments.push(p, tolerance.weight(p, plane(own)));
        }
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
    pub fn toward(&self, eye_V: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let toward = if self.plane.offset > 0.0 { -1.0 } else { 1.0 };
        let normal = self.plane.normal * toward;
        (normal, -(self.plane.offset * toward + normal.dot(eye_V)))
    }
}

/// Weighted least squares on the points of every region.
pub(super) fn fit(points: &Near, labels: &mut Labels) -> Vec<Final> {
    let room = labels
        .sums
        .iter()
        .map(|(count, _)| Vec::with_capacity(*count));
    let mut members: Vec<Vec<u32>> = room.collect();
    for (i, &r) in (0_u32..).zip(&labels.of_point) {
        if r != NONE {
            members[usize::from(r)].push(i);
        }
    }
    let mut planes = Vec::new();
    let sets = members
        .into_iter()
        .zip(std::mem::take(&mut labels.standing));
    for ((_, moments), (members, standing)) in labels.sums.iter().zip(sets) {
        if members.len() < POINTS_MIN {
            continue;
        }
        // Weights are of the order of 1e5: as a count they are far above three.
        let Some(fit) = moments.fit() else { continue };
        let square: f64 = (members.iter())
            .map(|&i| fit.plane.height(&points.at(i)).powi(2))
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
