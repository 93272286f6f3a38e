//! The planes of one cluster, the largest first.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::Brossette2013Config;
use super::random::Stream;

/// Points nearer to a plane than this are its inliers, m.
const DISTANCE_MAX_M: f64 = 0.03;
/// Most samples of three points that are tried for one plane.
const SAMPLES_MAX: usize = 200;
/// Probability that one of the samples holds inliers only; fewer are tried once it is reached.
const CONFIDENCE: f64 = 0.999;
/// The extraction of a cluster stops when no more than this ratio of it is left.
const REST_RATIO: f64 = 0.01;

/// A plane and the points it was fitted to.
pub(super) struct PlaneFit {
    /// Unit normal, either way.
    pub normal: Vector3<f64>,
    /// Mean of the inliers: a point of the plane.
    pub centroid: Point3<f64>,
    /// Indices of the inliers.
    pub inliers: Vec<usize>,
    /// Root mean square distance of the inliers, m.
    pub rms_m: f64,
}

/// The planes of a cluster: the one with most inliers, then that of the rest, and so on until
/// the rest is small.
///
/// Source: [brossette2013] III-D; RANSAC [fischler1981], then a least-squares fit to the inliers.
pub(super) fn plane_extraction(
    points: &[Point3<f64>],
    cluster: &[usize],
    stream: u64,
    config: &Brossette2013Config,
) -> Vec<PlaneFit> {
    let mut rest = cluster.to_vec();
    let mut planes = Vec::new();
    while rest.len() >= config.points_min.max(3)
        && rest.len() as f64 > REST_RATIO * cluster.len() as f64
    {
        let random = Stream::new(config.seed, stream << 16 | planes.len() as u64);
        let Some(sampled) = consensus(points, &rest, &random) else {
            break;
        };
        let Some(plane) = refined(points, &rest, sampled) else {
            break;
        };
        if plane.inliers.len() < config.points_min {
            break;
        }
        let mut inlier = plane.inliers.iter().copied().peekable();
        // Both ascend in the order of `rest`.
        rest.retain(|&i| inlier.next_if_eq(&i).is_none());
        planes.push(plane);
    }
    planes
}

/// The plane through three of the points that most of them are near.
fn consensus(
    points: &[Point3<f64>],
    rest: &[usize],
    random: &Stream,
) -> Option<(Vector3<f64>, Point3<f64>)> {
    let mut best: Option<(usize, Vector3<f64>, Point3<f64>)> = None;
    let mut needed = SAMPLES_MAX;
    let mut trial = 0;
    while trial < needed {
        let pick = |k: usize| points[rest[random.below(3 * trial as u64 + k as u64, rest.len())]];
        let (a, b, c) = (pick(0), pick(1), pick(2));
        trial += 1;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else {
            continue;
        };
        let near = |i: &&usize| normal.dot(&(points[**i] - a)).abs() <= DISTANCE_MAX_M;
        let count = rest.iter().filter(near).count();
        if best.is_none_or(|(most, ..)| count > most) {
            best = Some((count, normal, a));
            // Samples until one is free of outliers with the wanted confidence.
            let good = (count as f64 / rest.len() as f64).powi(3);
            let enough = (1.0 - CONFIDENCE).ln() / (1.0 - good).max(1e-12).ln();
            needed = SAMPLES_MAX.min(enough.ceil().max(1.0) as usize);
        }
    }
    best.map(|(_, normal, point)| (normal, point))
}

/// Least squares on the inliers of a plane, and again on the inliers of that.
fn refined(
    points: &[Point3<f64>],
    rest: &[usize],
    (mut normal, mut point): (Vector3<f64>, Point3<f64>),
) -> Option<PlaneFit> {
    let mut plane = None;
    for _ in 0..2 {
        let near = |i: &usize| normal.dot(&(points[*i] - point)).abs() <= DISTANCE_MAX_M;
        let inliers: Vec<usize> = rest.iter().copied().filter(near).collect();
        if inliers.len() < 3 {
            return plane;
        }
        let n = inliers.len() as f64;
        let mean = inliers
            .iter()
            .map(|&i| points[i].coords)
            .sum::<Vector3<f64>>()
            / n;
        let scatter = inliers.iter().fold(Matrix3::zeros(), |sum, &i| {
            let d = points[i].coords - mean;
            sum + d * d.transpose()
        });
        let eigen = SymmetricEigen::new(scatter / n);
        let least = eigen.eigenvalues.imin();
        normal = eigen.eigenvectors.column(least).into_owned();
        point = Point3::from(mean);
        let rms_m = eigen.eigenvalues[least].max(0.0).sqrt();
        plane = Some(PlaneFit {
            normal,
            centroid: point,
            inliers,
            rms_m,
        });
    }
    plane
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_crossing_planes_come_out_one_after_the_other_whatever_the_seed() {
        let grid = |n: u32| (0..n).map(|i| (f64::from(i % 20) * 0.05, f64::from(i / 20) * 0.05));
        let points: Vec<Point3<f64>> = grid(600)
            .map(|(x, y)| Point3::new(x, y, 1.0))
            .chain(grid(400).map(|(x, y)| Point3::new(x, 2.0, 1.5 + y)))
            .collect();
        let cluster: Vec<usize> = (0..points.len()).collect();
        for seed in 0..5 {
            let config = Brossette2013Config {
                seed,
                ..Default::default()
            };
            let planes = plane_extraction(&points, &cluster, 0, &config);
            assert_eq!(planes.len(), 2);
            assert_eq!(planes[0].inliers, (0..600).collect::<Vec<_>>());
            assert!(planes[0].normal.z.abs() > 1.0 - 1e-9 && planes[0].rms_m < 1e-6);
            assert!(planes[1].normal.y.abs() > 1.0 - 1e-9);
            assert_eq!(planes[1].inliers.len(), 400);
        }
    }

    #[test]
    fn points_on_a_line_give_no_plane() {
        let points: Vec<_> = (0..500)
            .map(|i| Point3::new(f64::from(i), 0.0, 1.0))
            .collect();
        let cluster: Vec<usize> = (0..500).collect();
        let config = Brossette2013Config::default();
        assert!(plane_extraction(&points, &cluster, 0, &config).is_empty());
    }
}
