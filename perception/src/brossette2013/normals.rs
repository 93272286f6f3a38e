//! Nearest neighbours, normals and curvature of points.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use crate::Error;

/// The k nearest neighbours of every point, nearest first, the point itself among them.
pub(crate) struct Neighbours {
    k: usize,
    items: Vec<u32>,
}

impl Neighbours {
    /// The neighbours of point `i`, nearest first.
    pub fn of(&self, i: usize) -> &[u32] {
        &self.items[i * self.k..(i + 1) * self.k]
    }
}

/// The k nearest neighbours of every point (all points where there are fewer).
///
/// # Errors
/// [`Error::Neighbours`] when the search tree refuses the points.
pub(crate) fn neighbours(points: &[Point3<f64>], k: usize) -> Result<Neighbours, Error> {
    let flat: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
    let k = k.min(flat.len());
    let Some(count) = NonZero::new(k) else {
        return Ok(Neighbours {
            k: 0,
            items: Vec::new(),
        });
    };
    let tree =
        ImmutableKdTree::<f64, 3>::new_from_slice(&flat).map_err(|source| Error::Neighbours {
            source: Box::new(source),
        })?;
    let items = flat
        .par_iter()
        .flat_map_iter(|p| {
            let found = tree
                .query(p)
                .nearest_n::<SquaredEuclidean<f64>>(count)
                .execute();
            found.into_iter().map(|item| item.item).collect::<Vec<_>>()
        })
        .collect();
    Ok(Neighbours { k, items })
}

/// Normal and curvature of every point.
pub(crate) struct Normals {
    /// Unit normals, toward the sensor.
    pub normals: Vec<Vector3<f64>>,
    /// λ₀ / (λ₀ + λ₁ + λ₂) of the neighbours' scatter: 0 on a plane, ⅓ for a ball.
    pub curvatures: Vec<f64>,
}

/// The direction of least scatter of every point's `count` nearest neighbours, turned to the sensor.
pub(crate) fn normals(
    points: &[Point3<f64>],
    neighbours: &Neighbours,
    count: usize,
    eye_V: &Vector3<f64>,
) -> Normals {
    let one = |i: usize| {
        let p = &points[i];
        let near = neighbours.of(i).iter().take(count);
        let (mut sum, mut square, mut n) = (Vector3::zeros(), Matrix3::zeros(), 0.0);
        for &k in near {
            let d = points[k as usize] - p;
            sum += d;
            square += d * d.transpose();
            n += 1.0;
        }
        let mean: Vector3<f64> = sum / n;
        let eigen = SymmetricEigen::new(square / n - mean * mean.transpose());
        let least = eigen.eigenvalues.imin();
        let total = eigen.eigenvalues.sum();
        let normal = eigen.eigenvectors.column(least).into_owned();
        let toward = if normal.dot(&(eye_V - p.coords)) < 0.0 {
            -normal
        } else {
            normal
        };
        let curvature = if total > 0.0 {
            eigen.eigenvalues[least].max(0.0) / total
        } else {
            0.0
        };
        (toward, curvature)
    };
    let (normals, curvatures) = (0..points.len()).into_par_iter().map(one).unzip();
    Normals {
        normals,
        curvatures,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_its_normal_toward_the_sensor_and_no_curvature() {
        // The plane x + z = 1 seen from the origin.
        let points: Vec<Point3<f64>> = (0..400)
            .map(|i| (f64::from(i % 20) * 0.01, f64::from(i / 20) * 0.01))
            .map(|(a, y)| Point3::new(a, y, 1.0 - a))
            .collect();
        let near = neighbours(&points, 12).unwrap();
        assert_eq!(near.of(7)[0], 7);
        let found = normals(&points, &near, 12, &Vector3::zeros());
        let expected = -Vector3::new(1.0, 0.0, 1.0).normalize();
        for (normal, curvature) in found.normals.iter().zip(&found.curvatures) {
            assert!((normal - expected).norm() < 1e-9);
            assert!(*curvature < 1e-12);
        }
    }

    #[test]
    fn fewer_points_than_neighbours_and_equal_points_are_fine() {
        let points = vec![Point3::new(1.0, 2.0, 3.0); 500];
        let near = neighbours(&points, 50).unwrap();
        assert_eq!(near.of(499).len(), 50);
        let few = neighbours(&points[..3], 50).unwrap();
        assert_eq!(few.of(2).len(), 3);
        let found = normals(&points, &near, 50, &Vector3::zeros());
        assert!(
            found
                .normals
                .iter()
                .all(|n| n.iter().all(|c| c.is_finite()))
        );
    }
}
