//! Clusters of neighbouring points with alike normals.

use std::collections::VecDeque;

use nalgebra::Point3;

use super::normals::{Neighbours, Normals};

/// Largest angle between the normals of two neighbours in a region, rad.
const SMOOTHNESS_RAD: f64 = 6.0_f64.to_radians();
/// Points of a larger curvature join a region but do not pass it on.
const CURVATURE_MAX: f64 = 1.0;
/// Neighbours of a point that are looked at.
pub(super) const NEIGHBOURS: usize = 30;
/// Neighbours farther than this are not neighbours, m.
const DISTANCE_MAX_M: f64 = 0.05;

/// Indices of the points of every region of `points_min` or more, regions in the order of their seeds.
///
/// The flattest point that is left seeds the next region; it grows to the neighbours whose
/// normals turn by less than the smoothness, and on from those that are flat enough.
///
/// Source: [brossette2013] III-C, [rabbani2006]; deviation: the distance limit, without which a
/// table's leg is one region with the floor.
pub(super) fn region_growing(
    points: &[Point3<f64>],
    normals: &Normals,
    neighbours: &Neighbours,
    points_min: usize,
) -> Vec<Vec<usize>> {
    let mut seeds: Vec<usize> = (0..points.len()).collect();
    let curvature = |i: usize| normals.curvatures[i];
    seeds.sort_by(|&a, &b| curvature(a).total_cmp(&curvature(b)).then(a.cmp(&b)));
    let cos = SMOOTHNESS_RAD.cos();
    let mut taken = vec![false; points.len()];
    let mut regions = Vec::new();
    for seed in seeds {
        if taken[seed] {
            continue;
        }
        taken[seed] = true;
        let mut region = vec![seed];
        let mut queue = VecDeque::from([seed]);
        while let Some(i) = queue.pop_front() {
            for &k in neighbours.of(i).iter().take(NEIGHBOURS + 1) {
                let k = k as usize;
                let near = (points[k] - points[i]).norm() <= DISTANCE_MAX_M;
                if taken[k] || !near || normals.normals[i].dot(&normals.normals[k]) < cos {
                    continue;
                }
                taken[k] = true;
                region.push(k);
                if curvature(k) <= CURVATURE_MAX {
                    queue.push_back(k);
                }
            }
        }
        if region.len() >= points_min {
            regions.push(region);
        }
    }
    regions
}

#[cfg(test)]
mod tests {
    use super::super::normals::{neighbours, normals};
    use super::*;
    use nalgebra::Vector3;

    /// Two parallel squares, the second shifted along x by `gap` beyond the first.
    fn squares(gap: f64) -> Vec<Point3<f64>> {
        let square = |x0: f64| {
            (0..400).map(move |i| {
                Point3::new(x0 + f64::from(i % 20) * 0.01, f64::from(i / 20) * 0.01, 1.0)
            })
        };
        square(0.0).chain(square(0.19 + gap)).collect()
    }

    #[test]
    fn the_distance_limit_parts_what_is_coplanar_but_apart() {
        for (gap, regions) in [(0.01, 1), (0.06, 2)] {
            let points = squares(gap);
            let near = neighbours(&points, 31).unwrap();
            let found = normals(&points, &near, 15, &Vector3::zeros());
            let grown = region_growing(&points, &found, &near, 150);
            assert_eq!(grown.len(), regions, "gap {gap}");
            assert_eq!(grown.iter().map(Vec::len).sum::<usize>(), 800);
        }
    }
}
