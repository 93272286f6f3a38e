//! One scan: points in the sensor's frame, and the depth image behind them where there is one.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use crate::sensor::{Intrinsics, Noise};

/// Depth along the optical axis on a pixel grid; 0 where nothing was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major depth, m; 0 is invalid.
    pub z_m: Vec<f32>,
    /// Pinhole model of the grid.
    pub intrinsics: Intrinsics,
}

/// Points in the sensor's frame V.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    /// x, y, z in V, m. Organised clouds keep invalid points as NaN, others hold finite ones only.
    pub points: Vec<[f32; 3]>,
    /// Width and height of the grid, for clouds that have one (then `points` is row-major).
    pub organised: Option<(usize, usize)>,
    /// Invalid (NaN, infinite or empty) points that were dropped or stand as NaN.
    pub invalid: usize,
}

impl PointCloud {
    /// The finite points, in order.
    pub fn finite(&self) -> impl Iterator<Item = &[f32; 3]> {
        self.points
            .iter()
            .filter(|p| p.iter().fold(true, |all, c| all & c.is_finite()))
    }
}

/// What one scan file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// The points, in V.
    pub cloud: PointCloud,
    /// The image behind the points: from a depth PNG, or recovered from an organised cloud in
    /// its optical frame.
    pub depth: Option<DepthImage>,
    /// Pose of V in W that the file states (PCD's VIEWPOINT, a bag's tf); the identity where it states none.
    pub X_WV: Isometry3<f64>,
    /// Where the sensor stood, in V: the origin, unless the points were moved after the scan.
    pub eye_V: Vector3<f64>,
    /// Noise model of the sensor.
    pub noise: Noise,
    /// What the reader chose and assumed, for the user.
    pub notes: Vec<String>,
}

impl Scan {
    /// An image that a sensor took where it stood, without its points: nothing needs them that has the image.
    pub fn of_image(depth: DepthImage, noise: Noise) -> Self {
        Self {
            cloud: PointCloud::default(),
            depth: Some(depth),
            X_WV: Isometry3::identity(),
            eye_V: Vector3::zeros(),
            noise,
            notes: Vec::new(),
        }
    }
}

impl DepthImage {
    /// The point of the pixel in a column and a row, NaN where there is none.
    #[inline]
    pub(crate) fn point(&self, u: usize, v: usize) -> Point3<f64> {
        let (k, z) = (&self.intrinsics, f64::from(self.z_m[v * self.width + u]));
        let z = if z > 0.0 { z } else { f64::NAN };
        let (u, v) = (u as f64, v as f64);
        Point3::new((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z)
    }

    /// The points of the valid pixels on the image's grid, NaN where there is none.
    pub fn to_cloud(&self) -> PointCloud {
        let k = &self.intrinsics;
        let (ix, iy) = ((1.0 / k.fx) as f32, (1.0 / k.fy) as f32);
        let (cx, cy) = (k.cx as f32, k.cy as f32);
        let mut invalid = 0;
        let mut points = Vec::with_capacity(self.z_m.len());
        for (v, row) in self.z_m.chunks_exact(self.width.max(1)).enumerate() {
            let y = (v as f32 - cy) * iy;
            for (u, &z) in row.iter().enumerate() {
                if z > 0.0 && z.is_finite() {
                    points.push([(u as f32 - cx) * ix * z, y * z, z]);
                } else {
                    invalid += 1;
                    points.push([f32::NAN; 3]);
                }
            }
        }
        PointCloud {
            points,
            organised: Some((self.width, self.height)),
            invalid,
        }
    }

    /// The depth image behind an organised cloud, with the pinhole model fitted to its points.
    ///
    ///   min Σ (fx x/z + cx − u)²,  min Σ (fy y/z + cy − v)²
    ///
    /// `None` when the cloud has no grid, too few points, or its points are not where a pinhole
    /// in V puts them to half a pixel (a cloud that was moved after the scan, a LiDAR's).
    pub fn from_organised(cloud: &PointCloud) -> Option<Self> {
        let (width, height) = cloud.organised.filter(|&(w, h)| w >= 8 && h >= 8)?;
        let mut columns = LineFit::default();
        let mut rows = LineFit::default();
        let valid = |p: &[f32; 3]| p.iter().all(|c| c.is_finite()) && p[2] > 0.0;
        for (i, p) in cloud.points.iter().enumerate().filter(|(_, p)| valid(p)) {
            let [x, y, z] = p.map(f64::from);
            columns.add(x / z, (i % width) as f64);
            rows.add(y / z, (i / width) as f64);
        }
        let ((fx, cx, eu), (fy, cy, ev)) = (columns.solve()?, rows.solve()?);
        if !(eu < 0.5 && ev < 0.5 && fx > 0.0 && fy > 0.0) {
            return None;
        }
        let z_m = cloud
            .points
            .iter()
            .map(|p| if valid(p) { p[2] } else { 0.0 })
            .collect();
        Some(Self {
            width,
            height,
            z_m,
            intrinsics: Intrinsics { fx, fy, cx, cy },
        })
    }
}

/// Least-squares line t = slope · s + offset by moments.
#[derive(Default)]
struct LineFit {
    n: f64,
    s: f64,
    t: f64,
    ss: f64,
    st: f64,
    tt: f64,
}

impl LineFit {
    fn add(&mut self, s: f64, t: f64) {
        self.n += 1.0;
        self.s += s;
        self.t += t;
        self.ss += s * s;
        self.st += s * t;
        self.tt += t * t;
    }

    /// Slope, offset and root mean square residual; `None` if the points do not span a line.
    fn solve(&self) -> Option<(f64, f64, f64)> {
        if self.n < 16.0 {
            return None;
        }
        let (ms, mt) = (self.s / self.n, self.t / self.n);
        let var = self.ss / self.n - ms * ms;
        let cov = self.st / self.n - ms * mt;
        if !(var.is_finite() && var > 1e-9) {
            return None;
        }
        let slope = cov / var;
        let residual = (self.tt / self.n - mt * mt - slope * cov).max(0.0).sqrt();
        residual
            .is_finite()
            .then_some((slope, mt - slope * ms, residual))
    }
}

/// Orthonormal tangents of the plane with this unit normal, x_S first.
///
/// On a plane that is nearer to level than to upright x_S lies over `forward`, else x_S is level.
/// Columns: x_S, y_S, z_S.
pub(crate) fn tangent_frame(
    normal: &Vector3<f64>,
    forward: &Vector3<f64>,
    up: &Vector3<f64>,
) -> Matrix3<f64> {
    let level = normal.dot(up).abs() > std::f64::consts::FRAC_1_SQRT_2;
    let x = if level {
        forward - normal * normal.dot(forward)
    } else {
        up.cross(normal)
    };
    // `forward` may be along the normal of a steep plane at the 45° limit: take any tangent then.
    let x = x.try_normalize(1e-6).unwrap_or_else(|| {
        let axis = if normal.x.abs() < 0.6 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        (axis - normal * normal.dot(&axis)).normalize()
    });
    Matrix3::from_columns(&[x, normal.cross(&x), *normal])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted_plane() -> DepthImage {
        let intrinsics = Intrinsics {
            fx: 60.0,
            fy: 62.0,
            cx: 31.0,
            cy: 22.5,
        };
        let (width, height) = (64, 48);
        let z_m = (0..width * height)
            .map(|i| {
                if i % 7 == 0 {
                    0.0
                } else {
                    1.0 + 0.01 * (i % width) as f32
                }
            })
            .collect();
        DepthImage {
            width,
            height,
            z_m,
            intrinsics,
        }
    }

    #[test]
    fn an_organised_cloud_gives_back_its_image() {
        let depth = tilted_plane();
        let again = DepthImage::from_organised(&depth.to_cloud()).unwrap();
        assert_eq!(again.z_m, depth.z_m);
        assert!((again.intrinsics.fx - 60.0).abs() < 1e-3);
        assert!((again.intrinsics.cy - 22.5).abs() < 1e-3);
    }

    #[test]
    fn a_rotated_cloud_has_no_image() {
        let mut cloud = tilted_plane().to_cloud();
        for p in &mut cloud.points {
            *p = [p[2], p[0], p[1]];
        }
        assert!(DepthImage::from_organised(&cloud).is_none());
    }

    #[test]
    fn tangent_frames_are_right_handed_for_any_normal() {
        let (forward, up) = (Vector3::x(), Vector3::z());
        for normal in [
            Vector3::z(),
            -Vector3::z(),
            Vector3::x(),
            Vector3::new(1.0, 0.0, 1.0).normalize(),
            Vector3::new(0.3, -0.5, 0.2).normalize(),
        ] {
            let r = tangent_frame(&normal, &forward, &up);
            assert!((r.determinant() - 1.0).abs() < 1e-12);
            assert!((r * r.transpose() - Matrix3::identity()).norm() < 1e-12);
            assert!((r.column(2) - normal).norm() < 1e-12);
        }
    }
}
