//! What growth asks of one cell: how well a plane fits it.

use super::image::Lens;
use super::moments::{InversePlane, Moments};
use crate::segmentation::MISFIT;
use crate::sensor::Noise;

/// One cell's noise, for the tests of growth and merging.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellNoise {
    /// σ of one pixel's inverse depth, 1/m.
    pub sigma: f64,
    /// Systematic error of inverse depth, 1/m: the sensor's κ w, and what the face is off its plane.
    pub systematic: f64,
}

/// What is built flat is so to this, m: the root mean square by which real treads, risers and floors are off
/// their planes along the normal.
const UNEVEN_M: f64 = 0.0025;

/// By how much the square of (ε/d), the part of its inverse depth by which a face is off its plane, is more than κ²: κ was
/// measured on walls seen from the front, and has what those are off. A plane seen at a flat angle is near to the
/// sensor's height, d, and off by the more.
pub(super) fn unevenness(lens: &Lens, plane: &InversePlane, noise: &Noise) -> f64 {
    let part = UNEVEN_M * UNEVEN_M * lens.normal(plane).norm_squared();
    (part - noise.systematic_ratio * noise.systematic_ratio).max(0.0)
}

impl CellNoise {
    /// At inverse depth `w`, 1/m, on a face of some [`unevenness`].
    pub fn at(noise: &Noise, w: f64, uneven: f64) -> Self {
        Self {
            sigma: noise.sigma_at_inverse(w),
            systematic: (noise.systematic_ratio.powi(2) + uneven).sqrt() * w,
        }
    }

    /// Largest mean square of a planar cell about its own plane, 1/m².
    pub fn planar(&self) -> f64 {
        self.square(PLANAR_SIGMAS, 0.3)
    }

    /// Largest mean square of a seed about its plane, 1/m².
    fn seed(&self) -> f64 {
        self.square(PLANAR_SIGMAS, 0.5 * MISFIT.1)
    }

    /// Largest mean square of a cell about its region's plane beyond that about its own, 1/m².
    pub fn misfit(&self) -> f64 {
        self.square(MISFIT.0, MISFIT.1)
    }

    /// (k σ)² + (m κ w)².
    pub fn square(&self, sigmas: f64, systematics: f64) -> f64 {
        (sigmas * self.sigma).powi(2) + (systematics * self.systematic).powi(2)
    }
}

/// A cell is planar while the root mean square about its own plane is below this many σ.
const PLANAR_SIGMAS: f64 = 1.8;

/// A cell about its own least-squares plane.
///
/// The mean square about any other plane is that about its own and a quadratic form of the
/// differences between both,
///
///   m² = d² + (Δa² Σu² + 2 Δa Δb Σuv + Δb² Σv²)/n
///
/// with d, the difference at the cell's mean pixel, and sums about that: all small numbers, for
/// which 32 bits do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Mean pixel, and inverse depth and slopes of the cell's plane there.
    u: f32,
    v: f32,
    w: f32,
    a: f32,
    b: f32,
    /// Mean squares and product of the pixels about their mean.
    uu: f32,
    uv: f32,
    vv: f32,
    /// Largest misfit to the plane of its region, were that even, 1/m².
    misfit_max: f32,
    /// Largest mean square of a seed about it, 1/m².
    pub seed_max: f32,
}

impl Cell {
    /// Of moments; `None` where they are not planar.
    pub fn new(m: &Moments, lens: &Lens, noise: &Noise) -> Option<Self> {
        let fit = m.fit()?;
        let even = CellNoise::at(noise, fit.w, 0.0);
        let noise = CellNoise::at(noise, fit.w, unevenness(lens, &fit.plane(), noise));
        (fit.square() <= noise.planar()).then_some(Self {
            u: fit.u as f32,
            v: fit.v as f32,
            w: fit.w as f32,
            a: fit.a as f32,
            b: fit.b as f32,
            uu: fit.uu as f32,
            uv: fit.uv as f32,
            vv: fit.vv as f32,
            misfit_max: even.misfit() as f32,
            seed_max: noise.seed() as f32,
        })
    }

    /// Whether its misfit to a plane, beyond its own noise, is below its limit.
    #[inline]
    pub fn fits(&self, &([a, b, c], uneven): &([f32; 3], f32)) -> bool {
        let d = a * self.u + b * self.v + c - self.w;
        let (a, b) = (a - self.a, b - self.b);
        let bend = a * (a * self.uu + 2.0 * b * self.uv) + b * b * self.vv;
        d * d + bend <= self.misfit_max + uneven * self.w * self.w
    }
}

/// A plane as [`Cell::fits`] takes it: its coefficients, and the square of what its unevenness adds to a misfit's
/// limit, as a part of inverse depth.
pub(super) fn test(lens: &Lens, plane: &InversePlane, noise: &Noise) -> ([f32; 3], f32) {
    let uneven = MISFIT.1 * MISFIT.1 * unevenness(lens, plane, noise);
    (coefficients(plane), uneven as f32)
}

/// A plane's coefficients in 32 bits.
pub(super) fn coefficients(plane: &InversePlane) -> [f32; 3] {
    plane.0.map(|x| x as f32).into()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::Sensor;
    use crate::organised::image::tests::grids_of;

    #[test]
    fn a_cell_fits_a_plane_as_its_moments_say() {
        let noise = Sensor::named("xtion").unwrap().noise;
        let mut m = Moments::default();
        // A cell of 4 × 4 without a corner, far from the centre, not quite flat.
        for (j, k) in (0..16).map(|i| (i % 4, i / 4)).filter(|p| *p != (0, 0)) {
            let rough = if (j + k) % 3 == 0 { 4e-4 } else { -2e-4 };
            let (u, v) = (f64::from(j - 300), f64::from(k + 201));
            m.push(u, v, 0.7 + 2e-4 * u - 1e-4 * v + rough);
        }
        let (lens, ..) = grids_of(|_, _| 1.0);
        let cell = Cell::new(&m, &lens, &noise).unwrap();
        let own = m.mean_square(&m.plane().unwrap());
        let (mut fits, mut not) = (0, 0);
        for i in 0..400 {
            let (i, j) = (f64::from(i % 20 - 10), f64::from(i / 20 - 10));
            let plane = Vector3::new(2e-4 + 4e-4 * i, -1e-4 + 3e-4 * j, 0.7);
            // Turned about the cell's own middle, and shifted.
            let c = plane.z + 2e-3 * i - (plane.x - 2e-4) * -298.5 - (plane.y + 1e-4) * 202.5;
            let plane = InversePlane(Vector3::new(plane.x, plane.y, c));
            let limit = CellNoise::at(&noise, m.mean(), unevenness(&lens, &plane, &noise)).misfit();
            let misfit = m.mean_square(&plane) - own;
            // Nothing so near the limit that 32 bits may decide.
            if (misfit / limit - 1.0).abs() > 1e-3 {
                assert_eq!(cell.fits(&test(&lens, &plane, &noise)), misfit <= limit);
                if misfit <= limit { fits += 1 } else { not += 1 }
            }
        }
        assert!(fits > 20 && not > 20, "{fits} {not}");
    }
}
