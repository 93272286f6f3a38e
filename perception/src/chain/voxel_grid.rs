//! One point for every occupied voxel.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// The voxel grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VoxelGridConfig {
    /// Side of a voxel, m.
    pub leaf_m: f64,
}

impl Default for VoxelGridConfig {
    fn default() -> Self {
        Self { leaf_m: 0.016 }
    }
}

impl VoxelGridConfig {
    pub(super) fn check(&self, range_max_m: f64) -> Result<(), Error> {
        // A voxel's place along an axis has to fit 21 bits.
        let least = (range_max_m / f64::from(1 << 19)).max(1e-6);
        within(
            "leaf_m",
            self.leaf_m,
            least,
            1e3,
            "must be positive, and not tiny for the range",
        )
    }
}

/// The centroids of the points in every voxel of a grid about `origin`, in the order of the voxels.
///
/// Source: [brossette2013] III-B: the centroid stands for the real surface better than the
/// voxel's centre.
pub(super) fn voxel_grid(
    points: &[Point3<f64>],
    origin: &Vector3<f64>,
    config: &VoxelGridConfig,
) -> Vec<Point3<f64>> {
    const HALF: f64 = (1 << 20) as f64;
    let key = |p: &Point3<f64>| {
        let cell = (p.coords - origin) / config.leaf_m;
        let [x, y, z] = [cell.x, cell.y, cell.z]
            .map(|c| (c.floor() + HALF).clamp(0.0, 2.0 * HALF - 1.0) as u64);
        z << 42 | y << 21 | x
    };
    let mut order: Vec<(u64, u32)> = points
        .iter()
        .zip(0_u32..)
        .map(|(p, i)| (key(p), i))
        .collect();
    order.sort_unstable();
    order
        .chunk_by(|a, b| a.0 == b.0)
        .map(|voxel| {
            let sum: Vector3<f64> = voxel.iter().map(|(_, i)| points[*i as usize].coords).sum();
            Point3::from(sum / voxel.len() as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voxel_gives_its_centroid() {
        let points = [[0.01, 0.01, 0.01], [-0.01, 0.0, 0.0], [0.03, 0.05, 0.09]].map(Point3::from);
        let config = VoxelGridConfig { leaf_m: 0.1 };
        let voxels = voxel_grid(&points, &Vector3::zeros(), &config);
        assert_eq!(voxels.len(), 2);
        assert!((voxels[0] - points[1]).norm() < 1e-15);
        assert!((voxels[1] - Point3::new(0.02, 0.03, 0.05)).norm() < 1e-12);
    }
}
