//! Ground and slopes fitted together, with the start lines parting their points.

use nalgebra::{RowDVector, Vector3};

use super::field::Field;
use super::ground::on_plane;
use super::joint_fit::{BiasPrior, JointFit, Observation, joint_fit};
use super::plane::{Plane, RING_BIAS_SIGMA_M, variance};
use super::prosac::DISTANCE_M;
use super::slopes::Patch;
use super::unevenness::uneven_m;

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
const PASSES: usize = 3;
/// Points on either side along a ring that lie on the plane of one that takes part.
const RIM: usize = 2;

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
    /// How much the slopes bend.
    pub unevenness_m: Vec<f64>,
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
///
/// Which points take part is told by where their beams meet the planes: by where they lie, noise would
/// choose among those near a border and tilt the plane. Next to the end of a run on a ring a footprint
/// may be on two surfaces, so that these points take no part. How noisy ranges are, and rings that are
/// not calibrated, is learnt from the residuals.
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
    let mut prior_now = prior.clone();
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
        // Whether a point is as near to a plane as its error, with what is known of its ring, may be.
        let (known, noise) = (bias.clone(), prior_now.noise);
        let near = |i: usize, plane: &Plane| {
            let p = field.point(i);
            let range = p.norm();
            let n_u = plane.normal.dot(&p) / range;
            let of_ring = |values: &[f64]| field.ring_of(i).and_then(|r| values.get(r)).copied();
            let (b, s) = (of_ring(&known), of_ring(&prior.sigma_m));
            let variance = noise * variance(n_u, range) + (n_u * s.unwrap_or(0.0)).powi(2);
            let off = plane.distance(&p) - b.unwrap_or(0.0) * n_u;
            off.powi(2) < GATE_SIGMAS * GATE_SIGMAS * variance
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
            let on: Vec<bool> = (0..field.len()).map(|i| near(i, &floor)).collect();
            for i in (0..field.len()).filter(|&i| on[i]) {
                let Some(q) = met(field, i, &floor) else {
                    continue;
                };
                if !lines.iter().flatten().any(|line| line.holds(&q, -MARGIN_M)) {
                    on_ground.push(i as u32);
                    // The foot of a wall is as near, and its ranges short by several times the noise.
                    if inner(field, &on, i) && on_plane(field, i, &floor, DISTANCE_M) {
                        observe(0, i as u32);
                    }
                }
            }
        }
        for (k, members) in members.iter().enumerate() {
            let plane = &planes[first_slope + k];
            let mut on = vec![false; field.len()];
            for &i in members {
                on[i as usize] = near(i as usize, plane);
            }
            for &i in members {
                let Some(q) = met(field, i as usize, plane) else {
                    continue;
                };
                let beyond = lines[k]
                    .as_ref()
                    .is_none_or(|line| line.ahead.dot(&(q - line.origin)) > MARGIN_M);
                // Near the line ground beside the slope lies in its plane as well.
                let clear = floor.distance(&q).abs() > CLEAR_M;
                if beyond && clear && inner(field, &on, i as usize) {
                    observe(first_slope + k, i);
                }
            }
        }
        let found = joint_fit(&observations, &planes, &prior_now)?;
        planes.clone_from(&found.planes);
        bias.clone_from(&found.bias_m);
        prior_now = learnt(&found, prior, &prior_now);
        // What the first consensus cut off near the ground's plane comes back.
        for (k, members) in members.iter_mut().enumerate() {
            let Some(line) = &lines[k] else { continue };
            let more = (0..field.len() as u32).filter(|&i| {
                let p = field.point(i as usize);
                // Its edges' normals are not its own, so that the first pass left them out.
                let clear = floor.distance(&p).abs() > CLEAR_M;
                (line.holds(&p, 0.0) || clear && line.holds(&p, -BORDER_M))
                    && near(i as usize, &planes[first_slope + k])
            });
            members.extend(more);
            members.sort_unstable();
            members.dedup();
        }
        fit = Some(found);
    }
    let fit = fit?;
    let floor = if ground_seen { planes[0] } else { *ground };
    let unevenness_m = (members.iter().enumerate())
        .map(|(k, members)| {
            let plane = &planes[first_slope + k];
            let clear = |i: &u32| {
                let q = met(field, *i as usize, plane);
                plane.distance(&field.point(*i as usize)).abs() <= DISTANCE_M
                    && q.is_some_and(|q| floor.distance(&q) > CLEAR_M)
            };
            let between = field.runs(members).into_iter();
            let between = between.flat_map(|run| run[0]..=run[run.len() - 1]);
            let points: Vec<u32> = match field.ring.is_empty() {
                true => members.iter().copied().filter(clear).collect(),
                false => between.filter(clear).collect(),
            };
            uneven_m(field, &points, plane, &fit.bias_m, prior, prior_now.noise)
        })
        .collect();
    Some(Refined {
        fit,
        first_slope,
        members,
        ground: on_ground,
        unevenness_m,
    })
}

/// Where the beam of a point meets a plane; `None` where it does not.
fn met(field: &Field, i: usize, plane: &Plane) -> Option<Vector3<f64>> {
    let u = field.point(i).normalize();
    let range = -plane.offset_m / plane.normal.dot(&u);
    (range > 0.0 && range.is_finite()).then(|| u * range)
}

/// Whether a point is marked, and on a ring its neighbours are.
fn inner(field: &Field, on: &[bool], i: usize) -> bool {
    let (from, to) = (i.saturating_sub(RIM), (i + RIM).min(on.len() - 1));
    match field.ring.is_empty() {
        true => on[i],
        false => (from..=to).all(|j| on[j] && field.ring[j] == field.ring[i]),
    }
}

/// What a fit tells of the errors of ranges: the noise by the residuals, and the size of unknown ring
/// errors by those that were found and what is not known of them, as much as half a ring that is as
/// `first` says would have it.
fn learnt(found: &JointFit, first: &BiasPrior, used: &BiasPrior) -> BiasPrior {
    let at = found.covariance.nrows() - found.bias_m.len();
    let (mut sum, mut rings) = (0.5 * RING_BIAS_SIGMA_M.powi(2), 0.5);
    for (ring, bias) in found.bias_m.iter().enumerate() {
        sum += (bias - first.mean_m[ring]).powi(2) + found.covariance[(at + ring, at + ring)];
        rings += 1.0;
    }
    let sigma = (sum / rings).sqrt();
    let narrowed = |s: &f64| if *s < RING_BIAS_SIGMA_M { *s } else { sigma };
    BiasPrior {
        noise: (used.noise * found.excess).max(1.0),
        mean_m: first.mean_m.clone(),
        sigma_m: first.sigma_m.iter().map(narrowed).collect(),
    }
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
