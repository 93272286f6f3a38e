//! Ground and slopes fitted together, with the start lines parting their points.

use nalgebra::{RowDVector, Vector3};

use super::field::Field;
use super::joint_fit::{BiasPrior, JointFit, Observation, joint_fit};
use super::plane::{Plane, variance};
use super::slopes::Patch;

/// Points this near to a start line are of neither plane, m.
const MARGIN_M: f64 = 0.06;
/// Points of a slope are farther than this from the ground, m.
pub(super) const CLEAR_M: f64 = 0.05;
/// Points on the plane beyond a slope's edges are its own up to this distance, m: the width over
/// which the normals are mixed there.
const BORDER_M: f64 = 0.10;
/// Points are of a plane up to this many standard deviations from it.
const GATE_SIGMAS: f64 = 3.5;
/// Passes of parting and fitting.
const PASSES: usize = 2;

/// The planes of a scan, fitted together.
pub(super) struct Refined {
    /// Plane 0 is the ground where it was seen, then the slopes.
    pub fit: JointFit,
    /// Index of the first slope in the fit.
    pub first_slope: usize,
    /// The slopes' points.
    pub members: Vec<Vec<u32>>,
    /// The ground's points.
    pub ground: Vec<u32>,
}

/// A start line in V, for parting points.
struct Line {
    /// A point on it.
    origin: Vector3<f64>,
    /// Unit direction.
    l: Vector3<f64>,
    /// Unit direction along the ground, uphill.
    ahead: Vector3<f64>,
    /// Extent of the slope along l from the origin, m.
    extent: (f64, f64),
    /// Extent of the slope along `ahead` from the origin, m.
    depth: (f64, f64),
}

/// The joint fit; `None` when a plane is left with too few points.
pub(super) fn refined(
    field: &Field,
    ground: &Plane,
    ground_seen: bool,
    patches: &[Patch],
    prior: &BiasPrior,
) -> Option<Refined> {
    let first_slope = usize::from(ground_seen);
    let mut planes: Vec<Plane> = ground_seen.then_some(*ground).into_iter().collect();
    planes.extend(patches.iter().map(|patch| patch.plane));
    let mut members: Vec<Vec<u32>> = patches.iter().map(|p| p.members.clone()).collect();
    let mut bias = prior.mean_m.clone();
    let mut on_ground: Vec<u32> = Vec::new();
    let mut fit = None;
    for _ in 0..PASSES {
        let floor = if ground_seen { planes[0] } else { *ground };
        let lines: Vec<Option<Line>> = members
            .iter()
            .enumerate()
            .map(|(k, members)| line(field, &floor, &planes[first_slope + k], members))
            .collect();
        let known = bias.clone();
        // A point's distance from a plane, in standard deviations, with what is known of its ring.
        let sigmas = |i: usize, plane: &Plane| {
            let p = field.point(i);
            let range = p.norm();
            let n_u = plane.normal.dot(&p) / range;
            let ring = field.ring_of(i);
            let b = ring.and_then(|r| known.get(r)).copied().unwrap_or(0.0);
            let s = ring
                .and_then(|r| prior.sigma_m.get(r))
                .copied()
                .unwrap_or(0.0);
            let variance = variance(n_u, range) + (n_u * s).powi(2);
            (plane.distance(&p) - b * n_u).abs() / variance.sqrt()
        };
        let mut observations = Vec::new();
        let mut observe = |plane: usize, i: u32| {
            observations.push(Observation {
                plane,
                ring: field.ring_of(i as usize),
                p: field.point(i as usize),
            });
        };
        on_ground.clear();
        if ground_seen {
            for i in 0..field.len() {
                let p = field.point(i);
                let under = lines.iter().flatten().any(|line| line.holds(&p, -MARGIN_M));
                if sigmas(i, &floor) < GATE_SIGMAS && !under {
                    on_ground.push(i as u32);
                    observe(0, i as u32);
                }
            }
        }
        for (k, members) in members.iter().enumerate() {
            let plane = &planes[first_slope + k];
            for &i in members {
                let p = field.point(i as usize);
                let beyond = lines[k]
                    .as_ref()
                    .is_none_or(|line| line.ahead.dot(&(p - line.origin)) > MARGIN_M);
                // Near the line ground beside the slope lies in its plane as well.
                let clear =
                    floor.distance(&p).abs() > CLEAR_M && sigmas(i as usize, &floor) > GATE_SIGMAS;
                if beyond && clear && sigmas(i as usize, plane) < GATE_SIGMAS {
                    observe(first_slope + k, i);
                }
            }
        }
        let found = joint_fit(&observations, &planes, prior)?;
        planes.clone_from(&found.planes);
        bias.clone_from(&found.bias_m);
        fit = Some(found);
        // What the first consensus cut off near the ground's plane comes back.
        for (k, members) in members.iter_mut().enumerate() {
            let Some(line) = &lines[k] else { continue };
            let more = (0..field.len() as u32).filter(|&i| {
                let p = field.point(i as usize);
                // Its edges' normals are not its own, so that the first pass left them out.
                let clear = floor.distance(&p).abs() > CLEAR_M;
                (line.holds(&p, 0.0) || clear && line.holds(&p, -BORDER_M))
                    && sigmas(i as usize, &planes[first_slope + k]) < GATE_SIGMAS
            });
            members.extend(more);
            members.sort_unstable();
            members.dedup();
        }
    }
    Some(Refined {
        fit: fit?,
        first_slope,
        members,
        ground: on_ground,
    })
}

/// The line of two planes, with the extent of the slope's points.
fn line(field: &Field, ground: &Plane, slope: &Plane, members: &[u32]) -> Option<Line> {
    let l = slope.normal.cross(&ground.normal).try_normalize(1e-6)?;
    let ahead = l.cross(&ground.normal);
    let origin = meet(ground, slope, &Vector3::zeros())?;
    let (mut extent, mut depth) = (
        (f64::INFINITY, f64::NEG_INFINITY),
        (f64::INFINITY, f64::NEG_INFINITY),
    );
    for &i in members {
        let d = field.point(i as usize) - origin;
        let (t, s) = (d.dot(&l), d.dot(&ahead));
        extent = (extent.0.min(t), extent.1.max(t));
        depth = (depth.0.min(s), depth.1.max(s));
    }
    Some(Line {
        origin,
        l,
        ahead,
        extent,
        depth: (depth.0.min(0.0), depth.1),
    })
}

impl Line {
    /// Whether a point lies over the slope's extent, shrunk by `inset_m`.
    fn holds(&self, p: &Vector3<f64>, inset_m: f64) -> bool {
        let d = p - self.origin;
        let (t, s) = (d.dot(&self.l), d.dot(&self.ahead));
        t > self.extent.0 + inset_m
            && t < self.extent.1 - inset_m
            && s > self.depth.0 + inset_m
            && s < self.depth.1 - inset_m
    }
}

/// The point of two planes' line that is nearest to `p`.
pub(super) fn meet(a: &Plane, b: &Plane, p: &Vector3<f64>) -> Option<Vector3<f64>> {
    let l = a.normal.cross(&b.normal);
    let denominator = l.norm_squared();
    if denominator < 1e-12 {
        return None;
    }
    // Moved along both normals until both distances are zero.
    let c = a.normal.dot(&b.normal);
    let (da, db) = (a.distance(p), b.distance(p));
    let alpha = (-da + c * db) / denominator;
    let beta = (-db + c * da) / denominator;
    Some(p + a.normal * alpha + b.normal * beta)
}

impl Refined {
    /// The ground: as it was seen, or as it is known.
    pub fn ground_plane(&self, known: &Plane) -> Plane {
        match self.first_slope {
            0 => *known,
            _ => self.fit.planes[0],
        }
    }

    /// The variance of a linear function of the planes' errors, given its derivatives by (θ₁, θ₂, δ)
    /// of the ground and of slope `k`. A ground that was not seen adds `known`, the covariance of
    /// the same of the calibrated ground.
    pub fn variance(
        &self,
        k: usize,
        by_ground: &[f64; 3],
        by_slope: &[f64; 3],
        known: &nalgebra::Matrix3<f64>,
    ) -> f64 {
        let size = self.fit.covariance.nrows();
        let mut row = RowDVector::<f64>::zeros(size);
        let first = 3 * (self.first_slope + k);
        for i in 0..3 {
            row[first + i] += by_slope[i];
        }
        let mut extra = 0.0;
        if self.first_slope == 1 {
            for i in 0..3 {
                row[i] += by_ground[i];
            }
        } else {
            let g = Vector3::from(*by_ground);
            extra = g.dot(&(known * g));
        }
        let variance = (&row * &self.fit.covariance).dot(&row);
        variance.max(0.0) + extra
    }
}
