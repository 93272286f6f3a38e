//! Additive moments of inverse depth, and the plane they give.

use std::ops::{Add, Div, Mul, Sub};

use nalgebra::Vector3;
use wide::f64x2;

use crate::segmentation;

/// A plane seen through a pinhole: inverse depth linear in the pixel.
///
///   1/z = a u + b v + c
///
/// u and v count from the image's centre, px; so a and b are 1/(m·px), c is 1/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct InversePlane(pub Vector3<f64>);

impl InversePlane {
    /// Inverse depth at a pixel, 1/m.
    pub fn at(&self, u: f64, v: f64) -> f64 {
        self.0.x * u + self.0.y * v + self.0.z
    }
}

/// A region of the image.
pub(super) type Region = segmentation::Region<Moments>;

/// Sums over pixels of the products of u, v, 1 and w = 1/z that a least-squares plane needs.
///
/// Moments of disjoint sets of pixels add; no other pass over the pixels is needed to fit the
/// plane of a union or to ask how well any plane fits it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moments {
    pub n: f64,
    pub u: f64,
    pub v: f64,
    pub uu: f64,
    pub uv: f64,
    pub vv: f64,
    pub w: f64,
    pub uw: f64,
    pub vw: f64,
    pub ww: f64,
}

/// Pixels about their mean, and their least-squares plane there; or those of two sets at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit<T = f64> {
    /// Mean pixel and inverse depth.
    pub u: T,
    pub v: T,
    pub w: T,
    /// Mean squares and product of the pixels about their mean.
    pub uu: T,
    pub uv: T,
    pub vv: T,
    /// Slopes of the plane.
    pub a: T,
    pub b: T,
    /// Mean square of the residuals, 1/m²; by rounding it may be below zero.
    square: T,
    /// Determinant of the mean squares, px⁴.
    det: T,
}

impl Fit {
    /// The plane on the image.
    pub fn plane(&self) -> InversePlane {
        let c = self.w - self.a * self.u - self.b * self.v;
        InversePlane(Vector3::new(self.a, self.b, c))
    }
}

/// One number, or one for each of two sets.
pub(super) trait Real:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl Real for f64 {}
impl Real for f64x2 {}

impl<T: Real> Fit<T> {
    /// Of sums in the order in which [`Moments`] has them.
    #[inline(always)]
    fn new([n, u, v, uu, uv, vv, w, uw, vw, ww]: [T; 10]) -> Self {
        // Centred, so that the 2×2 system keeps its digits far from the image's centre.
        let inverse = T::from(1.0) / n;
        let (u, v, w) = (u * inverse, v * inverse, w * inverse);
        let uu = uu * inverse - u * u;
        let uv = uv * inverse - u * v;
        let vv = vv * inverse - v * v;
        let (uw, vw) = (uw * inverse - u * w, vw * inverse - v * w);
        let det = uu * vv - uv * uv;
        let scale = T::from(1.0) / det;
        let a = (uw * vv - vw * uv) * scale;
        let b = (vw * uu - uw * uv) * scale;
        let square = ww * inverse - w * w - a * uw - b * vw;
        Self {
            u,
            v,
            w,
            uu,
            uv,
            vv,
            a,
            b,
            square,
            det,
        }
    }
}

impl Fit {
    /// Mean square of the residuals, 1/m².
    pub fn square(&self) -> f64 {
        self.square.max(0.0)
    }
}

/// Pixels span a plane where the determinant of their mean squares is above this, px⁴.
const DET_MIN: f64 = 1e-9;

/// The mean squares of the residuals of two sets of pixels about their own planes, 1/m²; none where
/// the pixels do not span a plane.
#[inline]
pub(super) fn squares(a: &Moments, b: &Moments) -> [Option<f64>; 2] {
    let both = |of: fn(&Moments) -> f64| f64x2::from([of(a), of(b)]);
    let fit = Fit::new([
        both(|m| m.n),
        both(|m| m.u),
        both(|m| m.v),
        both(|m| m.uu),
        both(|m| m.uv),
        both(|m| m.vv),
        both(|m| m.w),
        both(|m| m.uw),
        both(|m| m.vw),
        both(|m| m.ww),
    ]);
    let (squares, dets) = (fit.square.to_array(), fit.det.to_array());
    let one =
        |i: usize, m: &Moments| (m.n >= 3.0 && dets[i] > DET_MIN).then(|| squares[i].max(0.0));
    [one(0, a), one(1, b)]
}

impl Moments {
    /// Adds one pixel.
    #[cfg(test)]
    pub fn push(&mut self, u: f64, v: f64, w: f64) {
        self.n += 1.0;
        self.u += u;
        self.v += v;
        self.uu += u * u;
        self.uv += u * v;
        self.vv += v * v;
        self.w += w;
        self.uw += u * w;
        self.vw += v * w;
        self.ww += w * w;
    }

    /// Adds another set of pixels, each counted `weight` times.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.n += weight * other.n;
        self.u += weight * other.u;
        self.v += weight * other.v;
        self.uu += weight * other.uu;
        self.uv += weight * other.uv;
        self.vv += weight * other.vv;
        self.w += weight * other.w;
        self.uw += weight * other.uw;
        self.vw += weight * other.vw;
        self.ww += weight * other.ww;
    }

    /// The same pixels, each at (x, y) from where it was.
    pub fn moved(&self, x: f64, y: f64) -> Self {
        Self {
            u: self.u + self.n * x,
            v: self.v + self.n * y,
            uu: self.uu + x * (2.0 * self.u + self.n * x),
            uv: self.uv + x * self.v + y * self.u + self.n * x * y,
            vv: self.vv + y * (2.0 * self.v + self.n * y),
            uw: self.uw + x * self.w,
            vw: self.vw + y * self.w,
            ..*self
        }
    }

    /// Mean inverse depth, 1/m.
    pub fn mean(&self) -> f64 {
        self.w / self.n
    }

    /// The least-squares plane:  min Σ (a u + b v + c − w)².
    ///
    /// `None` when the pixels do not span a plane.
    pub fn plane(&self) -> Option<InversePlane> {
        self.fit().map(|fit| fit.plane())
    }

    /// The least-squares plane about the mean pixel; `None` when the pixels do not span a plane.
    #[inline]
    pub fn fit(&self) -> Option<Fit> {
        let sums = [
            self.n, self.u, self.v, self.uu, self.uv, self.vv, self.w, self.uw, self.vw, self.ww,
        ];
        let fit = Fit::new(sums);
        (self.n >= 3.0 && fit.det > DET_MIN).then_some(fit)
    }

    /// Mean square of a u + b v + c − w over the pixels, 1/m².
    pub fn mean_square(&self, plane: &InversePlane) -> f64 {
        let [a, b, c] = [plane.0.x, plane.0.y, plane.0.z];
        let model = a * a * self.uu
            + b * b * self.vv
            + c * c * self.n
            + 2.0 * (a * b * self.uv + a * c * self.u + b * c * self.v);
        let cross = a * self.uw + b * self.vw + c * self.w;
        ((model - 2.0 * cross + self.ww) / self.n).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_comes_back_from_its_moments_far_from_the_centre() {
        let plane = InversePlane(Vector3::new(1e-4, -3e-4, 0.5));
        let mut sums = [Moments::default(); 2];
        for v in 200..208 {
            for u in -312..-304 {
                let (u, v) = (f64::from(u), f64::from(v));
                sums[(u as usize + v as usize) % 2].push(u, v, plane.at(u, v));
            }
        }
        let [mut all, other] = sums;
        all.add(&other, 1.0);
        let fit = all.plane().unwrap();
        assert!((fit.0 - plane.0).norm() < 1e-10);
        assert!(all.mean_square(&fit) < 1e-14);
    }

    #[test]
    fn mean_square_is_that_of_the_residuals() {
        let plane = InversePlane(Vector3::new(0.0, 0.0, 0.5));
        let mut m = Moments::default();
        for i in 0..16 {
            let off = if i % 2 == 0 { 0.01 } else { -0.01 };
            m.push(f64::from(i % 4), f64::from(i / 4), 0.5 + off);
        }
        assert!((m.mean_square(&plane) - 1e-4).abs() < 1e-12);
    }

    #[test]
    fn two_fits_at_once_are_those_of_each() {
        let mut sets = [Moments::default(); 3];
        for (i, (u, v)) in (0..40).map(|i| (i, (f64::from(i % 8), f64::from(i / 8)))) {
            let rough = if i % 3 == 0 { 2e-3 } else { 0.0 };
            sets[0].push(u, v, 0.4 + 1e-3 * u + rough);
            sets[1].push(u - 300.0, v + 90.0, 0.9 - 2e-3 * v - 0.5 * rough);
            sets[2].push(u, 7.0, 0.5);
        }
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let of = |k: usize| sets[k].fit().map(|fit| fit.square());
            assert_eq!(squares(&sets[a], &sets[b]), [of(a), of(b)]);
        }
        assert!(sets[0].fit().is_some_and(|fit| fit.square() > 1e-7));
        assert!(sets[2].fit().is_none());
    }

    #[test]
    fn pixels_in_a_row_give_no_plane() {
        let mut m = Moments::default();
        for u in 0..20 {
            m.push(f64::from(u), 3.0, 0.5);
        }
        assert!(m.plane().is_none());
    }
}
