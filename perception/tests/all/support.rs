//! A depth camera over a world of boxes, with the errors of a structured-light sensor.
// Benches share this with the tests, and use only some of it.
#![allow(dead_code, clippy::unwrap_used)]

use std::path::PathBuf;

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use perception::{Config, DepthImage, Intrinsics, Method, PointCloud, Scan, Sensor, extract};
use surfaces::outline::Outline;

/// A box with a pose: `half` are its half sizes along its own axes.
#[derive(Clone)]
pub struct Block {
    pub name: &'static str,
    pub pose: Isometry3<f64>,
    pub half: Vector3<f64>,
}

impl Block {
    /// Whether a point of W is inside, but for one axis of the block's.
    fn holds(&self, p: &Point3<f64>, but: Option<usize>) -> bool {
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

/// The defaults, but for the method.
pub fn by(method: Method) -> Config {
    Config {
        method,
        ..Config::default()
    }
}

/// What comes of work on that many threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

/// The faces of a scan, which are valid, named in order and look at the sensor.
pub fn faces_of(scan: &Scan, method: Method) -> Vec<surfaces::Face> {
    let found = extract(scan, &scan.X_WV, &by(method)).unwrap().faces;
    let eye = scan.X_WV * Point3::from(scan.eye_V);
    for (i, face) in found.iter().enumerate() {
        face.validate().unwrap();
        assert_eq!(face.id, format!("f{i}").into());
        assert!(face.height_of(&eye) > 0.0, "{} looks away", face.id);
    }
    found
}

/// The file below `shared/scans` (`SCANDENT_SHARED`, or `shared` beside the workspace), or `None`, loudly.
pub fn shared(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let root = std::env::var_os("SCANDENT_SHARED").map_or_else(beside, PathBuf::from);
    let path = root.join("scans").join(name);
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there", path.display());
        return None;
    }
    Some(path)
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
        depth: Some(depth),
        X_WV: *X_WV,
        eye_V: Vector3::zeros(),
        noise: sensor.noise,
        notes: Vec::new(),
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

/// A face of one or more blocks: those of them that are coplanar make up one face.
pub struct Face<'a> {
    pub blocks: Vec<&'a Block>,
    /// Axis of the blocks along which the face looks, and its sign.
    pub axis: usize,
    pub sign: f64,
}

/// The upward face of the named blocks.
pub fn top<'a>(blocks: &'a [Block], names: &[&str]) -> Face<'a> {
    let blocks: Vec<&Block> = blocks.iter().filter(|b| names.contains(&b.name)).collect();
    assert_eq!(blocks.len(), names.len());
    Face {
        blocks,
        axis: 2,
        sign: 1.0,
    }
}

impl Face<'_> {
    pub fn normal_W(&self) -> Vector3<f64> {
        let mut axis = Vector3::zeros();
        axis[self.axis] = self.sign;
        self.blocks[0].pose.rotation * axis
    }

    /// Signed distance of a point from the face's plane.
    pub fn height(&self, p: &Point3<f64>) -> f64 {
        let local = self.blocks[0].pose.inverse_transform_point(p);
        self.sign * local[self.axis] - self.blocks[0].half[self.axis]
    }

    /// Whether the foot of the point on the face's plane lies on the face: on one of its blocks,
    /// and not inside another block that stands on it.
    pub fn holds(&self, p: &Point3<f64>, world: &[Block]) -> bool {
        let foot = p - self.normal_W() * self.height(p);
        let inside = |block: &&Block| block.holds(&foot, Some(self.axis));
        self.blocks.iter().any(inside) && !self.is_covered(p, world)
    }

    /// Whether something stands on the face's plane there.
    pub fn is_covered(&self, p: &Point3<f64>, world: &[Block]) -> bool {
        let above = p + self.normal_W() * (0.005 - self.height(p));
        world.iter().any(|block| block.holds(&above, None))
    }
}

/// The whole region of a face, in F.
pub fn whole(face: &surfaces::Face) -> Outline {
    Outline::from(&face.region)
}

/// The part of a face that may be touched: inside of two standard deviations of its edges, in F.
pub fn touchable(face: &surfaces::Face) -> Outline {
    face.inset_region(2.0, 0.0)
}

/// Lattice points in W of a part of a face with the given pitch.
pub fn lattice(face: &surfaces::Face, part: &Outline, pitch: f64) -> Vec<Point3<f64>> {
    let Some((low, high)) = part.bounds() else {
        return Vec::new();
    };
    let steps = |low: f64, high: f64| (low / pitch).ceil() as i64..=(high / pitch).floor() as i64;
    let mut points = Vec::new();
    for i in steps(low.x, high.x) {
        for j in steps(low.y, high.y) {
            let p = Point2::new(i as f64 * pitch, j as f64 * pitch);
            if part.contains(&p) {
                points.push(face.point_W(&p));
            }
        }
    }
    points
}

/// Whether a face lies on a true one: within 5° and, at its centroid, 3 cm of its plane, and with most of
/// its area on it.
pub fn lies_on(found: &surfaces::Face, face: &Face, world: &[Block]) -> bool {
    let points = || lattice(found, &whole(found), 0.03);
    let near = |points: Vec<Point3<f64>>| {
        let on = points.iter().filter(|p| face.holds(p, world)).count();
        2 * on > points.len()
    };
    found.normal_W().dot(&face.normal_W()) > 5.0_f64.to_radians().cos()
        && face.height(&found.point_W(&found.region.centroid())).abs() < 0.03
        && near(points())
}

/// The faces that lie on the true one, the largest first.
pub fn on_face<'a>(
    found: &'a [surfaces::Face],
    face: &Face,
    world: &[Block],
) -> Vec<&'a surfaces::Face> {
    let mut on: Vec<_> = found.iter().filter(|f| lies_on(f, face, world)).collect();
    on.sort_by(|a, b| b.region.area().total_cmp(&a.region.area()));
    on
}

/// Ratio of the area of parts of faces that is off the true one, root mean square distance of the parts
/// from its plane, and area of the union.
pub fn against(
    found: &[&surfaces::Face],
    part: fn(&surfaces::Face) -> Outline,
    face: &Face,
    world: &[Block],
) -> (f64, f64, f64) {
    let pitch = 0.01;
    let (mut off, mut square, mut count) = (0, 0.0, 0);
    let mut cells = std::collections::BTreeSet::new();
    for of in found {
        for p in lattice(of, &part(of), pitch) {
            off += usize::from(!face.holds(&p, world));
            square += face.height(&p).powi(2);
            count += 1;
            let local = face.blocks[0].pose.inverse_transform_point(&p);
            cells.insert([local.x, local.y].map(|c| (c / pitch).round() as i64));
        }
    }
    let n = count.max(1) as f64;
    (
        off as f64 / n,
        (square / n).sqrt(),
        cells.len() as f64 * pitch * pitch,
    )
}

/// How far a face is taken back before its coverage is measured, px: the drop-outs take 2 px off
/// an edge in the air, and where an edge is can be told to 1 px.
pub const EDGE_PX: usize = 3;

/// Points of the face, one a pixel that sees it and nothing else within [`EDGE_PX`], and the area
/// that each stands for but for a factor.
pub fn eroded(exact: &Scan, face: &Face, world: &[Block]) -> Vec<(Point3<f64>, f64)> {
    let depth = exact.depth.as_ref().unwrap();
    let (width, height) = (depth.width, depth.height);
    let point = |i: usize| {
        let p = exact.cloud.points[i].map(f64::from);
        exact.X_WV * Point3::from(p)
    };
    let on: Vec<bool> = (0..width * height)
        .map(|i| {
            let p = point(i);
            depth.z_m[i] > 0.0 && face.height(&p).abs() < 2e-3 && face.holds(&p, world)
        })
        .collect();
    let near = |k: usize, end: usize| k.saturating_sub(EDGE_PX)..(k + EDGE_PX + 1).min(end);
    (0..width * height)
        .filter(|i| {
            let (u, v) = (i % width, i / width);
            near(v, height).all(|v| near(u, width).all(|u| on[v * width + u]))
        })
        .map(|i| (point(i), f64::from(depth.z_m[i]).powi(3)))
        .collect()
}

/// The floor of every world.
pub fn floor() -> Block {
    block("floor", [4.0, 0.0, -0.05], [12.0, 12.0, 0.1], 0.0, 0.0)
}

/// Steps, a table and a ramp on a floor before a wall.
pub fn stairs() -> Vec<Block> {
    vec![
        floor(),
        block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        block("step1", [1.15, 0.05, 0.075], [0.34, 0.62, 0.15], 0.1, 0.0),
        block("step2", [1.50, -0.02, 0.15], [0.36, 0.70, 0.30], -0.07, 0.0),
        block("step3", [1.88, 0.06, 0.22], [0.38, 0.55, 0.44], 0.05, 0.0),
        block(
            "step4",
            [2.26, -0.03, 0.285],
            [0.36, 0.60, 0.57],
            -0.12,
            0.0,
        ),
        block("table", [2.90, 0.0, 0.695], [0.80, 1.60, 0.03], 0.02, 0.0),
        block("ramp", [1.9, -1.15, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
    ]
}

/// Faces in the shapes of an L and a U, and a table with a box on it.
pub fn concave() -> Vec<Block> {
    vec![
        floor(),
        block("l_long", [1.55, 0.55, 0.10], [0.9, 0.35, 0.20], 0.0, 0.0),
        block("l_short", [1.825, 0.175, 0.10], [0.35, 0.4, 0.20], 0.0, 0.0),
        block("u_right", [1.6, -0.95, 0.15], [0.9, 0.25, 0.30], 0.0, 0.0),
        block("u_far", [1.925, -0.625, 0.15], [0.25, 0.4, 0.30], 0.0, 0.0),
        block("u_left", [1.6, -0.30, 0.15], [0.9, 0.25, 0.30], 0.0, 0.0),
        block("table", [2.9, 0.2, 0.60], [0.9, 1.6, 0.04], 0.0, 0.0),
        block("box", [2.85, 0.15, 0.72], [0.3, 0.3, 0.20], 0.35, 0.0),
    ]
}

/// Squared error of a face's (rotation about x_F, about y_F, offset along z_F), in units of its
/// covariance.
pub fn nees(found: &surfaces::Face, face: &Face) -> f64 {
    let n = found.X_WF.rotation.inverse() * face.normal_W();
    let height = face.height(&Point3::from(found.X_WF.translation.vector));
    let error = Vector3::new(-n.y / n.z, n.x / n.z, -height / n.z);
    let rows = found.plane_covariance.unwrap();
    let covariance = nalgebra::Matrix3::from_fn(|i, j| rows[i][j]);
    error.dot(&(covariance.try_inverse().unwrap() * error))
}
