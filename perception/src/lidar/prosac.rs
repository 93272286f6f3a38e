//! Progressive sample consensus for planes: samples are drawn from the best points first.

use nalgebra::Vector3;

use super::config::LidarConfig;
use super::plane::Plane;
use crate::brossette2013::Stream;

/// Points nearer than this to a plane are in its consensus set, m.
pub(super) const DISTANCE_M: f64 = 0.03;
/// Most samples.
const SAMPLES_MAX: usize = 600;
/// η₀: probability of missing a larger consensus set at which the search ends.
const MISS: f64 = 0.01;
/// ψ: probability that a wrong plane has the consensus set at which the search may end.
const CHANCE: f64 = 0.05;
/// β: part of the points that lie near a wrong plane.
const WRONG_PART: f64 = 0.10;
/// The least height of a sample's triangle, m.
const TRIANGLE_MIN_M: f64 = 0.10;

/// Points from the best to the worst with their own normals, as columns.
#[derive(Default)]
pub(super) struct Ordered {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    u: Vec<f32>,
    v: Vec<f32>,
    w: Vec<f32>,
}

/// Cosine of the largest angle between a plane's normal and that of a point in its consensus set.
const AGREE: f32 = 0.94;

impl Ordered {
    /// Adds the next best point.
    pub fn push(&mut self, [x, y, z]: [f32; 3], [u, v, w]: [f32; 3]) {
        self.x.push(x);
        self.y.push(y);
        self.z.push(z);
        self.u.push(u);
        self.v.push(v);
        self.w.push(w);
    }

    /// Points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    fn point(&self, i: usize) -> Vector3<f64> {
        Vector3::new(
            f64::from(self.x[i]),
            f64::from(self.y[i]),
            f64::from(self.z[i]),
        )
    }

    /// Points near a plane whose own normals agree with it.
    fn count(&self, plane: &Plane, distance_m: f64) -> usize {
        let [a, b, c] = [plane.normal.x, plane.normal.y, plane.normal.z].map(|v| v as f32);
        let (d, bound) = (plane.offset_m as f32, distance_m as f32);
        let places = self.x.iter().zip(&self.y).zip(&self.z);
        let normals = self.u.iter().zip(&self.v).zip(&self.w);
        places
            .zip(normals)
            .map(|(((x, y), z), ((u, v), w))| {
                let near = (a * x + b * y + c * z + d).abs() < bound;
                u32::from(near & (a * u + b * v + c * w > AGREE))
            })
            .sum::<u32>() as usize
    }

    /// Whether point `i` counts.
    fn holds(&self, plane: &Plane, i: usize, distance_m: f64) -> bool {
        let n = plane.normal;
        let agrees =
            n.x * f64::from(self.u[i]) + n.y * f64::from(self.v[i]) + n.z * f64::from(self.w[i])
                > f64::from(AGREE);
        agrees && self.distance(plane, i) < distance_m
    }

    fn distance(&self, plane: &Plane, i: usize) -> f64 {
        plane.distance(&self.point(i)).abs()
    }
}

/// Points of a sample.
const M: usize = 3;
/// Samples after which PROSAC has become RANSAC (T_N).
const SAMPLES_OF_ALL: f64 = 200_000.0;
/// The quantile of the normal distribution that belongs to a probability of 5 %; others by the
/// logarithm of the tail.
fn quantile(chance: f64) -> f64 {
    // Abramowitz and Stegun 26.2.23: off by less than 4.5e-4.
    let t = (-2.0 * chance.clamp(1e-12, 0.5).ln()).sqrt();
    t - (2.515_517 + t * (0.802_853 + t * 0.010_328))
        / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)))
}

/// The plane with the largest consensus set among the samples that `gate` lets pass, and the size of
/// that set.
pub(super) fn consensus(
    points: &Ordered,
    config: &LidarConfig,
    stream: u64,
    gate: impl Fn(&Plane) -> bool,
) -> Option<(Plane, usize)> {
    if points.len() < M {
        return None;
    }
    let stream = Stream::new(config.seed, stream);
    if config.as_published {
        meng(points, stream, gate)
    } else {
        prosac(points, stream, gate)
    }
}

/// Source: [chum2005], Algorithm 1: the growth function of section 2.2, the non-randomness and
/// maximality conditions of section 2.3 (the binomial tail by the normal distribution). Deviation:
/// a point counts only where its own normal agrees, or planes through clutter would.
fn prosac(
    points: &Ordered,
    stream: Stream,
    gate: impl Fn(&Plane) -> bool,
) -> Option<(Plane, usize)> {
    let total = points.len();
    // T_m = T_N Π (m − i)/(N − i), and T'_m = 1.
    let mut expected = (0..M).fold(SAMPLES_OF_ALL, |t, i| {
        t * (M - i) as f64 / (total - i) as f64
    });
    let mut drawn_until = 1_u64;
    let (mut set, mut stop_at) = (M, total);
    let mut best: Option<(Plane, usize)> = None;
    let mut samples_needed = SAMPLES_MAX as f64;
    let mut draw = 0_u64;
    for t in 1..=SAMPLES_MAX as u64 {
        // 1. The set grows as the samples from it become as many as RANSAC would have drawn of it.
        while t > drawn_until && set < stop_at {
            let next = expected * (set + 1) as f64 / (set + 1 - M) as f64;
            drawn_until += (next - expected).ceil().max(1.0) as u64;
            expected = next;
            set += 1;
        }
        // 2. The newest point and two of the others; or any three once the set is complete.
        let mut sample = [0_usize; M];
        if t <= drawn_until && set > M - 1 {
            sample[M - 1] = set - 1;
            distinct(&mut sample[..M - 1], set - 1, &stream, &mut draw);
        } else {
            distinct(&mut sample, set, &stream, &mut draw);
        }
        // 3. Plane and consensus set.
        let [a, b, c] = sample.map(|i| points.point(i));
        let plane = Plane::through(&a, &b, &c, TRIANGLE_MIN_M).filter(&gate);
        if let Some(plane) = plane {
            let count = points.count(&plane, DISTANCE_M);
            if best.is_none_or(|(_, most)| count > most) {
                best = Some((plane, count));
                // 4. Where the search may end, and after how many samples.
                (stop_at, samples_needed) = termination(points, &plane);
                stop_at = stop_at.max(set);
            }
        }
        if best.is_some() && t as f64 >= samples_needed {
            break;
        }
    }
    best
}

/// The length n* of the set that needs the fewest samples to be sure of its plane, and how many.
fn termination(points: &Ordered, plane: &Plane) -> (usize, f64) {
    let z = quantile(CHANCE);
    let beta = WRONG_PART;
    let mut inliers = 0_usize;
    let mut least = (points.len(), SAMPLES_MAX as f64);
    for i in 0..points.len() {
        inliers += usize::from(points.holds(plane, i, DISTANCE_M));
        let n = i + 1;
        // Too short a set says nothing by the normal distribution.
        if n < 20 || inliers <= M {
            continue;
        }
        let others = (n - M) as f64;
        let random = M as f64 + others * beta + z * (others * beta * (1.0 - beta)).sqrt();
        if (inliers as f64) < random {
            continue;
        }
        let hit: f64 = (0..M)
            .map(|j| (inliers - j) as f64 / (n - j) as f64)
            .product();
        let needed = if hit >= 1.0 {
            1.0
        } else {
            MISS.ln() / (1.0 - hit).ln()
        };
        if needed < least.1 {
            least = (n, needed);
        }
    }
    least
}

/// Source: [meng] III-B: three points at random; of the consensus set the plane is fitted anew, and
/// points near it are preferred in the next sample. Kept for comparison: it settles on the largest
/// plane that the gate lets pass.
fn meng(points: &Ordered, stream: Stream, gate: impl Fn(&Plane) -> bool) -> Option<(Plane, usize)> {
    let mut best: Option<(Plane, usize)> = None;
    // Points of the consensus set by their distance from its plane.
    let mut preferred: Vec<usize> = Vec::new();
    let mut draw = 0_u64;
    for t in 0..SAMPLES_MAX {
        let mut sample = [0_usize; M];
        // Every other sample is free, so that a poor first plane is not the last.
        if preferred.len() > M && t % 2 == 1 {
            let n = preferred.len();
            for slot in &mut sample {
                // Linear preference: the least of two draws.
                let (a, b) = (stream.below(draw, n), stream.below(draw + 1, n));
                draw += 2;
                *slot = preferred[a.min(b)];
            }
        } else {
            distinct(&mut sample, points.len(), &stream, &mut draw);
        }
        let [a, b, c] = sample.map(|i| points.point(i));
        let Some(plane) = Plane::through(&a, &b, &c, TRIANGLE_MIN_M).filter(&gate) else {
            continue;
        };
        let inliers: Vec<usize> = (0..points.len())
            .filter(|&i| points.distance(&plane, i) < DISTANCE_M)
            .collect();
        if best.is_some_and(|(_, most)| inliers.len() <= most) {
            continue;
        }
        let fitted = Plane::fitted(inliers.iter().map(|&i| points.point(i)))
            .filter(&gate)
            .unwrap_or(plane);
        best = Some((fitted, inliers.len()));
        preferred = inliers;
        preferred.sort_by(|&a, &b| {
            let (da, db) = (points.distance(&fitted, a), points.distance(&fitted, b));
            da.total_cmp(&db).then(a.cmp(&b))
        });
        // Enough: all but one in ten agree.
        if preferred.len() * 10 >= points.len() * 9 {
            break;
        }
    }
    best
}

/// Different numbers below `n`, which is at least as many.
fn distinct(slots: &mut [usize], n: usize, stream: &Stream, draw: &mut u64) {
    for i in 0..slots.len() {
        loop {
            let value = stream.below(*draw, n);
            *draw += 1;
            if !slots[..i].contains(&value) {
                slots[i] = value;
                break;
            }
        }
    }
}
