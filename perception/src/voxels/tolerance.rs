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

/// Noise does not come out smaller than this, m: coordinates have so many decimals.
const FLOOR_MIN_M: f64 = 1e-4;
/// The voxels that show slow errors, the largest; how many times what they show such errors are; and the least part of the
/// table's that is left. A plane in 0.32 m of a wave of [`super::lattice::WAVE_RAD`] 3 m away, 1.4 m long, leaves a ninth
/// of its root mean square: L² (2π/1.4 m)² √2 / (12 √5).
const SLOW_LEVEL: usize = 3;
const SLOW_FACTOR: f64 = 9.0;
const SLOW_PART_MIN: f64 = 0.2;

/// The noise by how far the points of the smallest voxels lie off their own planes: where that is more than the table
/// says in the median, as many times larger, at most `most` times; where it is less and the sensor is unknown, as they
/// lie near and far.
///
///   σ(r) = a + b (r − z₀)²  through the medians of the nearer and of the farther half of the voxels
///
/// Clouds of unknown or of several sensors have more noise than the table says, laser scanners and clouds that were
/// fused far less: their treads are lost in another sensor's. Of a sensor that is named it never comes out smaller.
pub(super) fn measured(levels: &[Level], noise: &Noise, most: f64) -> Noise {
    let mut found = levels.first().map_or_else(Vec::new, spreads);
    if found.len() < VOXELS_MIN {
        return *noise;
    }
    let ratios = found.iter().map(|[r, sigma]| sigma / noise.sigma_z_m(*r));
    let factor = median(ratios);
    if factor >= 1.0 || !noise.guessed {
        let factor = factor.clamp(1.0, most);
        return Noise {
            floor_m: factor * noise.floor_m,
            quadratic_per_m: factor * noise.quadratic_per_m,
            ..*noise
        };
    }
    found.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (near, far) = found.split_at(found.len() / 2);
    let [near, far] = [near, far].map(|half| {
        let square = |r: f64| (r - noise.knee_m).max(0.0).powi(2);
        let squares = half.iter().map(|[r, _]| square(*r));
        [
            median(squares),
            median(half.iter().map(|[_, sigma]| *sigma)),
        ]
    });
    let growth = (far[1] - near[1]) / (far[0] - near[0]).max(1e-6);
    let quadratic_per_m = growth.clamp(0.0, noise.quadratic_per_m);
    let white = Noise {
        floor_m: (near[1] - quadratic_per_m * near[0]).max(FLOOR_MIN_M),
        quadratic_per_m,
        ..*noise
    };
    // What larger voxels spread beyond that is slow.
    let larger = levels.get(SLOW_LEVEL).map_or_else(Vec::new, spreads);
    if larger.len() < VOXELS_MIN {
        return white;
    }
    let beyond =
        |[r, sigma]: &[f64; 2]| (sigma.powi(2) - white.sigma_z_m(*r).powi(2)).max(0.0) / (r * r);
    let slow = SLOW_FACTOR * median(larger.iter().map(beyond)).sqrt();
    let table = noise.systematic_ratio;
    Noise {
        systematic_ratio: slow.clamp(SLOW_PART_MIN * table, table),
        ..white
    }
}

/// Range, m, and root mean square along the ray, m, of the points of each dense voxel about their plane.
fn spreads(level: &Level) -> Vec<[f64; 2]> {
    let spread = (SPREAD_MIN * level.side_m).powi(2);
    let dense = level.cells.iter().filter(|cell| cell.n >= POINTS_MIN);
    let of = dense.filter_map(|cell| {
        let fit = cell.fit().filter(|fit| fit.middle >= spread)?;
        let mean = cell.mean();
        let rms = (fit.least.max(0.0) * cell.n / (cell.n - 3.0)).sqrt();
        Some([mean.norm(), rms / slant(&mean, &fit.plane)])
    });
    of.collect()
}

/// The median of what is not empty.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::sensor::Sensor;
    use crate::voxels::grid::Grid;

    #[test]
    fn noise_is_measured_where_it_is_more_than_the_table_says() {
        let unknown = Sensor::named("generic").unwrap().noise;
        let named = Noise {
            guessed: false,
            ..unknown
        };
        let sigma = unknown.sigma_z_m(1.0);
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
        for (noise, factor, most, expected) in [
            (named, 0.3, 9.0, 1.0),
            (unknown, 0.3, 9.0, 0.3),
            (unknown, 4.0, 9.0, 4.0),
            (unknown, 4.0, 3.0, 3.0),
        ] {
            let grid = Grid::new(floor(factor).into_iter(), 0.04, 1);
            let got = measured(&grid.levels, &noise, most).sigma_z_m(1.0) / sigma;
            assert!((got / expected - 1.0).abs() < 0.1, "{factor}: {got}");
        }
    }
}
