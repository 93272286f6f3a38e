//! What distances from a plane are due to the sensor.

use nalgebra::Vector3;

use super::grid::Level;
use super::moments::Plane;
use crate::sensor::Noise;

/// Bounds on the distances of points from their planes.
pub(super) struct Tolerance<'a> {
    pub noise: &'a Noise,
    pub distance_max_m: f64,
}

impl Tolerance<'_> {
    /// min(√((k σ)² + (m κ r)²), limit) along the normal of a plane, at a place seen from the
    /// origin, m. The sensor errs along its rays: a plane seen at a flat angle is off by less.
    pub fn at(&self, p: &Vector3<f64>, plane: &Plane, k: f64, m: f64) -> f64 {
        let sigma = k * self.noise.sigma_z_m(p.norm());
        let slow = m * self.noise.systematic_ratio * p.norm();
        ((sigma * sigma + slow * slow).sqrt() * slant(p, plane)).min(self.distance_max_m)
    }

    /// The weight of a point in its plane, 1/m²: an error of σ along the ray is one of σ |n·ray| along the normal.
    ///
    ///   min Σ (n·p − d)² / (σ² + (κ r)²) (n·r̂)²
    ///
    /// Without the cap of the distance limit: that one says nothing of the noise.
    pub fn weight(&self, p: &Vector3<f64>, plane: &Plane) -> f64 {
        let range = p.norm();
        let sigma = self.noise.sigma_z_m(range);
        let slow = self.noise.systematic_ratio * range;
        let slant = (plane.normal.dot(p).abs() / range.max(1e-9)).max(0.1);
        1.0 / ((sigma * sigma + slow * slow) * slant * slant)
    }
}

/// Cosine of the angle between the normal and the ray, at flat angles that at which the noise across
/// the ray counts.
fn slant(p: &Vector3<f64>, plane: &Plane) -> f64 {
    (plane.normal.dot(p).abs() / p.norm().max(1e-9)).max(0.25)
}

/// Voxels of fewer points tell too little of their noise.
const POINTS_MIN: f64 = 15.0;
/// So many of them make a median.
const VOXELS_MIN: usize = 20;
/// Points that spread less than this part of a voxel's side across lie on a line.
const SPREAD_MIN: f64 = 0.2;

/// The noise, as many times larger as the points of the smallest voxels lie off their own planes in
/// the median, at most `most` times: clouds of unknown or of several sensors have more than the
/// table says. It never comes out smaller.
pub(super) fn measured(level: &Level, noise: &Noise, most: f64) -> Noise {
    let spread = (SPREAD_MIN * level.side_m).powi(2);
    let dense = level.cells.iter().filter(|cell| cell.n >= POINTS_MIN);
    let mut ratios: Vec<f64> = dense
        .filter_map(|cell| {
            let fit = cell.fit().filter(|fit| fit.middle >= spread)?;
            let mean = cell.mean();
            let rms = (fit.least.max(0.0) * cell.n / (cell.n - 3.0)).sqrt();
            Some(rms / (noise.sigma_z_m(mean.norm()) * slant(&mean, &fit.plane)))
        })
        .collect();
    if ratios.len() < VOXELS_MIN {
        return *noise;
    }
    let middle = ratios.len() / 2;
    let (_, median, _) = ratios.select_nth_unstable_by(middle, f64::total_cmp);
    let factor = median.clamp(1.0, most);
    Noise {
        floor_m: factor * noise.floor_m,
        quadratic_per_m: factor * noise.quadratic_per_m,
        ..*noise
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::sensor::Sensor;
    use crate::voxels::grid::Grid;

    #[test]
    fn noise_is_measured_where_it_is_more_than_the_table_says() {
        let noise = Sensor::named("generic").unwrap().noise;
        let sigma = noise.sigma_z_m(1.0);
        // A floor about 1 m below the eye, in the middle of a layer of voxels, off by ± a σ: a root mean square of a σ.
        let floor = |factor: f64| -> Vec<Vector3<f64>> {
            let place = |i: usize| (i as f64 * 0.618_034).fract() - 0.5;
            (0..20_000)
                .map(|i| {
                    let z = if i % 2 == 0 { sigma } else { -sigma };
                    Vector3::new(place(i), i as f64 / 20_000.0 - 0.5, factor * z - 1.02)
                })
                .collect()
        };
        for (factor, most, expected) in [(0.3, 9.0, 1.0), (4.0, 9.0, 4.0), (4.0, 3.0, 3.0)] {
            let grid = Grid::new(floor(factor).into_iter(), 0.04, 1);
            let got = measured(&grid.levels[0], &noise, most).floor_m / noise.floor_m;
            assert!((got / expected - 1.0).abs() < 0.1, "{factor}: {got}");
        }
    }
}
