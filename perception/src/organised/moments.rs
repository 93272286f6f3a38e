//! Additive moments of inverse depth, and the plane they give.

use nalgebra::Vector3;

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

/// Pixels about their mean, and their least-squares plane there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Mean pixel and inverse depth.
    pub u: f64,
    pub v: f64,
    pub w: f64,
    /// Mean squares and product of the pixels about their mean.
    pub uu: f64,
    pub uv: f64,
    pub vv: f64,
    /// Slopes of the plane.
    pub a: f64,
    pub b: f64,
    /// Mean square of the residuals, 1/m².
    pub square: f64,
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
        let fit = self.fit()?;
        let c = fit.w - fit.a * fit.u - fit.b * fit.v;
        Some(InversePlane(Vector3::new(fit.a, fit.b, c)))
    }

    /// The least-squares plane about the mean pixel; `None` when the pixels do not span a plane.
    #[inline]
    pub fn fit(&self) -> Option<Fit> {
        if self.n < 3.0 {
            return None;
        }
        // Centred, so that the 2×2 system keeps its digits far from the image's centre.
        let inverse = 1.0 / self.n;
        let [u, v, w] = [self.u, self.v, self.w].map(|sum| sum * inverse);
        let uu = self.uu * inverse - u * u;
        let uv = self.uv * inverse - u * v;
        let vv = self.vv * inverse - v * v;
        let (uw, vw) = (self.uw * inverse - u * w, self.vw * inverse - v * w);
        let det = uu * vv - uv * uv;
        if det.is_nan() || det <= 1e-9 {
            return None;
        }
        let scale = 1.0 / det;
        let a = (uw * vv - vw * uv) * scale;
        let b = (vw * uu - uw * uv) * scale;
        let square = self.ww * inverse - w * w - a * uw - b * vw;
        Some(Fit {
            u,
            v,
            w,
            uu,
            uv,
            vv,
            a,
            b,
            square: square.max(0.0),
        })
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
    fn pixels_in_a_row_give_no_plane() {
        let mut m = Moments::default();
        for u in 0..20 {
            m.push(f64::from(u), 3.0, 0.5);
        }
        assert!(m.plane().is_none());
    }
}
