//! One point for every occupied voxel.

use nalgebra::{Point3, Vector3};

/// The centroids of the points in every voxel of a grid about `origin`, in the order of the voxels.
///
/// Source: [brossette2013] III-B: the centroid stands for the real surface better than the
/// voxel's centre.
pub(super) fn voxel_grid(
    points: &[Point3<f64>],
    origin: &Vector3<f64>,
    leaf_m: f64,
) -> Vec<Point3<f64>> {
    const HALF: f64 = (1 << 20) as f64;
    let key = |p: &Point3<f64>| {
        let cell = (p.coords - origin) / leaf_m;
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
        let voxels = voxel_grid(&points, &Vector3::zeros(), 0.1);
        assert_eq!(voxels.len(), 2);
        assert!((voxels[0] - points[1]).norm() < 1e-15);
        assert!((voxels[1] - Point3::new(0.02, 0.03, 0.05)).norm() < 1e-12);
    }
}
