//! Clusters of neighbouring points with alike normals.

use std::collections::VecDeque;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::normals::{Neighbours, Normals};
use crate::Error;
use crate::error::within;

/// Region growing on normals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RegionGrowingConfig {
    /// Largest angle between the normals of two neighbours in a region, rad.
    pub smoothness_rad: f64,
    /// Points of a larger curvature join a region but do not pass it on.
    pub curvature_max: f64,
    /// Neighbours of a point that are looked at.
    pub neighbours: usize,
    /// Neighbours farther than this are not neighbours, m.
    pub distance_max_m: f64,
    /// Smallest region that is kept, points.
    pub points_min: usize,
    /// Largest region that is kept, points.
    pub points_max: usize,
}

impl Default for RegionGrowingConfig {
    fn default() -> Self {
        Self {
            smoothness_rad: 6.0_f64.to_radians(),
            curvature_max: 1.0,
            neighbours: 30,
            distance_max_m: 0.05,
            points_min: 150,
            points_max: 10_000_000,
        }
    }
}

impl RegionGrowingConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let pi = std::f64::consts::PI;
        within(
            "smoothness_rad",
            self.smoothness_rad,
            0.0,
            pi,
            "must be in [0, π]",
        )?;
        within(
            "curvature_max",
            self.curvature_max,
            0.0,
            1.0,
            "must be in [0, 1]",
        )?;
        within(
            "neighbours",
            self.neighbours as f64,
            1.0,
            1000.0,
            "must be in [1, 1000]",
        )?;
        within(
            "distance_max_m",
            self.distance_max_m,
            0.0,
            1e6,
            "must not be negative",
        )
    }
}

/// Indices of the points of every region, regions in the order of their seeds.
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
    config: &RegionGrowingConfig,
) -> Vec<Vec<usize>> {
    let mut seeds: Vec<usize> = (0..points.len()).collect();
    let curvature = |i: usize| normals.curvatures[i];
    seeds.sort_by(|&a, &b| curvature(a).total_cmp(&curvature(b)).then(a.cmp(&b)));
    let cos = config.smoothness_rad.cos();
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
            for &k in neighbours.of(i).iter().take(config.neighbours + 1) {
                let k = k as usize;
                let near = (points[k] - points[i]).norm() <= config.distance_max_m;
                if taken[k] || !near || normals.normals[i].dot(&normals.normals[k]) < cos {
                    continue;
                }
                taken[k] = true;
                region.push(k);
                if curvature(k) <= config.curvature_max {
                    queue.push_back(k);
                }
            }
        }
        if (config.points_min..=config.points_max).contains(&region.len()) {
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
            let config = RegionGrowingConfig {
                distance_max_m: 0.03,
                ..Default::default()
            };
            let grown = region_growing(&points, &found, &near, &config);
            assert_eq!(grown.len(), regions, "gap {gap}");
            assert_eq!(grown.iter().map(Vec::len).sum::<usize>(), 800);
        }
    }
}
