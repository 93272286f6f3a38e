//! A depth camera over a world of boxes, with the errors of a structured-light sensor.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use perception::{DepthImage, Intrinsics, PointCloud, Scan, Sensor};

/// A box with a pose: `half` are its half sizes along its own axes.
#[derive(Clone)]
pub struct Block {
    pub name: &'static str,
    pub pose: Isometry3<f64>,
    pub half: Vector3<f64>,
}

impl Block {
    /// Whether a point of W is inside, but for one axis of the block's.
    pub fn holds(&self, p: &Point3<f64>, but: Option<usize>) -> bool {
        let local = self.pose.inverse_transform_point(p);
        (0..3).all(|i| Some(i) == but || local[i].abs() <= self.half[i])
    }
}

/// A box by centre and size (m), turned about z by `yaw` and then about its y by `pitch` (rad).
pub fn block(name: &'static str, c: [f64; 3], size: [f64; 3], yaw: f64, pitch: f64) -> Block {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), pitch);
    let pose = Isometry3::from_parts(
        Translation3::from(Point3::from(c)),
        UnitQuaternion::from_rotation_matrix(&turn),
    );
    Block {
        name,
        pose,
        half: Vector3::from(size) / 2.0,
    }
}

/// The pose of a camera at (0, 0, `height`) that looks along +x, `pitch` rad down.
pub fn camera(height: f64, pitch: f64) -> Isometry3<f64> {
    // Level: z_V along +x_W, x_V along −y_W, y_V along −z_W.
    let level = nalgebra::Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let R_WV = Rotation3::from_matrix_unchecked(level)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), -pitch);
    Isometry3::from_parts(
        Translation3::new(0.0, 0.0, height),
        UnitQuaternion::from_rotation_matrix(&R_WV),
    )
}

/// Where the camera of most tests is.
pub fn pose() -> Isometry3<f64> {
    camera(1.45, 0.61)
}

/// A stream of uniform and normal numbers.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

pub const WIDTH: usize = 640;
pub const HEIGHT: usize = 480;

/// A scan of the blocks by an Xtion at `X_WV`.
///
/// With errors: σ_z noise correlated over 1.8 px, a slowly varying error of 0.4 % of z, disparity
/// in eighths of a pixel, and 3 of 4 pixels lost within 2 px of a depth edge; depths in mm.
pub fn scan(blocks: &[Block], X_WV: &Isometry3<f64>, errors: bool, seed: u64) -> Scan {
    let sensor = Sensor::named("xtion").unwrap();
    let k = sensor.intrinsics.unwrap();
    let mut z = depths(blocks, X_WV, &k);
    if errors {
        let mut random = Random(seed);
        let noise = correlated(&mut random, sensor.noise.correlation_px);
        let slow = waves(&mut random, sensor.noise.systematic_scale_px);
        let near_edge = edges(&z);
        for (i, z) in z.iter_mut().enumerate() {
            let sigma = sensor.noise.sigma_z_m(*z);
            let measured = *z * (1.0 + sensor.noise.systematic_ratio * slow[i]) + sigma * noise[i];
            let disparity = (k.fx * 0.075 / measured * 8.0).round() / 8.0;
            let lost = near_edge[i] && random.uniform() < 0.75;
            *z = if lost || disparity <= 0.0 {
                0.0
            } else {
                k.fx * 0.075 / disparity
            };
        }
    }
    let z_m = z.iter().map(|z| ((z * 1000.0).round() / 1000.0) as f32);
    let z_m = z_m.map(|z| {
        if z.is_finite() && (0.4..8.0).contains(&z) {
            z
        } else {
            0.0
        }
    });
    let depth = DepthImage {
        width: WIDTH,
        height: HEIGHT,
        z_m: z_m.collect(),
        intrinsics: k,
    };
    Scan {
        cloud: depth.to_cloud(),
        X_WV: *X_WV,
        ..Scan::of_image(depth, sensor.noise)
    }
}

/// True depth of every pixel; infinite where the ray meets nothing.
fn depths(blocks: &[Block], X_WV: &Isometry3<f64>, k: &Intrinsics) -> Vec<f64> {
    let mut z = vec![f64::INFINITY; WIDTH * HEIGHT];
    for block in blocks {
        let X_BV = block.pose.inverse() * X_WV;
        let origin = X_BV.translation.vector;
        for (i, z) in z.iter_mut().enumerate() {
            let (u, v) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
            let ray = X_BV.rotation * Vector3::new((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
            let (mut near, mut far) = (0.0_f64, f64::INFINITY);
            for axis in 0..3 {
                let a = (-block.half[axis] - origin[axis]) / ray[axis];
                let b = (block.half[axis] - origin[axis]) / ray[axis];
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
            if near <= far && near > 0.0 {
                *z = z.min(near);
            }
        }
    }
    z
}

/// White noise through a Gaussian of `scale` pixels, of unit variance.
fn correlated(random: &mut Random, scale: f64) -> Vec<f64> {
    let white: Vec<f64> = (0..WIDTH * HEIGHT).map(|_| random.normal()).collect();
    let reach = (3.0 * scale).ceil() as i64;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|d| (-0.5 * (d as f64 / scale).powi(2)).exp())
        .collect();
    let norm: f64 = kernel.iter().map(|k| k * k).sum();
    let blur = |from: &[f64], step: i64, place: &dyn Fn(i64) -> (i64, i64)| -> Vec<f64> {
        (0..from.len() as i64)
            .map(|i| {
                let (at, length) = place(i);
                let taps = kernel.iter().zip(-reach..=reach);
                taps.map(|(k, d)| {
                    k * from[(i + (at + d).rem_euclid(length) * step - at * step) as usize]
                })
                .sum()
            })
            .collect()
    };
    let (w, h) = (WIDTH as i64, HEIGHT as i64);
    let rows = blur(&white, 1, &|i| (i % w, w));
    blur(&rows, w, &|i| (i / w, h))
        .into_iter()
        .map(|x| x / norm)
        .collect()
}

/// A smooth field of unit variance, like white noise through a Gaussian of `scale` pixels.
fn waves(random: &mut Random, scale: f64) -> Vec<f64> {
    const COUNT: usize = 32;
    let std = 1.0 / (std::f64::consts::SQRT_2 * scale);
    let waves: Vec<(f64, f64, f64)> = (0..COUNT)
        .map(|_| {
            let phase = std::f64::consts::TAU * random.uniform();
            (std * random.normal(), std * random.normal(), phase)
        })
        .collect();
    let amplitude = (2.0 / COUNT as f64).sqrt();
    (0..WIDTH * HEIGHT)
        .map(|i| {
            let (u, v) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
            amplitude
                * waves
                    .iter()
                    .map(|(a, b, c)| (a * u + b * v + c).cos())
                    .sum::<f64>()
        })
        .collect()
}

/// Pixels within two of a jump in depth of more than 3 %.
fn edges(z: &[f64]) -> Vec<bool> {
    let jump = |a: f64, b: f64| (a - b).abs() > 0.03 * a.min(b) || a.is_finite() != b.is_finite();
    let mut near = vec![false; z.len()];
    for v in 0..HEIGHT {
        for u in 0..WIDTH {
            let here = z[v * WIDTH + u];
            let right = u + 1 < WIDTH && jump(here, z[v * WIDTH + u + 1]);
            let below = v + 1 < HEIGHT && jump(here, z[(v + 1) * WIDTH + u]);
            if right || below {
                for y in v.saturating_sub(2)..(v + 3).min(HEIGHT) {
                    near[y * WIDTH + u.saturating_sub(2)..y * WIDTH + (u + 3).min(WIDTH)]
                        .fill(true);
                }
            }
        }
    }
    near
}

/// The same scan as a cloud without a grid.
pub fn unorganised(scan: &Scan) -> Scan {
    every(1, scan)
}

/// Every `step`th point of a scan as a cloud without a grid.
pub fn every(step: usize, scan: &Scan) -> Scan {
    let points = scan.cloud.finite().copied().step_by(step).collect();
    Scan {
        cloud: PointCloud {
            points,
            ..PointCloud::default()
        },
        depth: None,
        ..scan.clone()
    }
}
