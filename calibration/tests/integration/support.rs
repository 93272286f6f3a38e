//! A simulated robot with a depth camera that takes the 52 poses of [chai2015] Table A1.

use calibration::Config;
use calibration::camera::{
    CameraConfig, Identification, PaperParameters, PlanePair, closed_form, identify,
};
use calibration::ground::ground;
use nalgebra::{Isometry3, Matrix6, Vector6};
use perception::{DepthImage, Intrinsics, Noise, Scan, Sensor};
use scenes::camera_set::{PoseNoise, published_extrinsics};
use scenes::simulator::{DepthNoise, Field, KINECT, Pinhole, World, distortion, scan_distorted};
use scenes::stances;

/// A sensor in the simulator and as the estimator knows it.
#[derive(Clone)]
pub struct Device {
    pub camera: Pinhole,
    pub noise: DepthNoise,
    pub known: Noise,
}

impl Device {
    /// A Kinect with the image `n` times smaller both ways, and everything that is measured in
    /// pixels with it: noise is correlated over the same angle, so that as many independent
    /// samples see the ground, in n² fewer pixels.
    pub fn kinect(n: usize, noise: &DepthNoise) -> Self {
        let mut known = Sensor::named("kinect_v1").expect("it is known").noise;
        let scale = 1.0 / n as f64;
        known.correlation_px *= scale;
        known.systematic_scale_px *= scale;
        known.systematic_ratio = noise.distortion;
        Self {
            camera: KINECT.smaller(n),
            noise: DepthNoise {
                correlation_px: noise.correlation_px * scale,
                distortion_px: noise.distortion_px * scale,
                disparity_step_px: noise.disparity_step_px * scale,
                jitter_px: noise.jitter_px * scale,
                ..noise.clone()
            },
            known,
        }
    }

    pub fn distortion(&self, seed: u64) -> Field {
        distortion(&self.camera, &self.noise, seed)
    }

    /// The frame as the estimator reads it.
    pub fn shoot(
        &self,
        world: &World,
        X_GR: &Isometry3<f64>,
        X_RV: &Isometry3<f64>,
        distortion: &Field,
        seed: u64,
    ) -> Scan {
        let (camera, noise) = (&self.camera, &self.noise);
        let shot = scan_distorted(world, camera, &(X_GR * X_RV), noise, distortion, seed);
        let metres = shot.depth_mm.iter().map(|mm| 0.001 * f32::from(*mm));
        let &Pinhole { fx, fy, cx, cy, .. } = camera;
        let depth = DepthImage {
            width: camera.width,
            height: camera.height,
            z_m: metres.collect(),
            intrinsics: Intrinsics { fx, fy, cx, cy },
        };
        Scan::of_image(depth, self.known)
    }
}

/// What varies between the runs of a series.
#[derive(Clone)]
pub struct Series {
    pub device: Device,
    pub world: World,
    /// Errors of the robot's poses that are the same in every run.
    pub pose_noise: PoseNoise,
    pub pose_seed: Option<u64>,
    /// What of them changes from run to run.
    pub repeatability: PoseNoise,
    /// The seed of the device's distortion where it is the same in all runs.
    pub device_seed: Option<u64>,
    /// Whether the distortion is drawn anew in each frame.
    pub distorted_anew: bool,
    pub config: Config,
}

impl Series {
    pub fn new(device: Device) -> Self {
        Self {
            device,
            world: scenes::worlds::ground::truth(None, 0).world(),
            pose_noise: PoseNoise::published(),
            pose_seed: None,
            repeatability: PoseNoise::default(),
            device_seed: None,
            distorted_anew: false,
            config: Config::default(),
        }
    }

    /// The planes of the 52 poses in one run.
    pub fn measure(&self, run: u64) -> Vec<PlanePair> {
        let X_RV = published_extrinsics();
        let fixed = self.device_seed.unwrap_or(7000 + run);
        let fixed = self.device.distortion(fixed);
        let pose_seed = self.pose_seed.unwrap_or(run);
        let pair = |(i, stance): (u64, &[f64; 3])| {
            let said = stances::X_GR(*stance);
            let real = self.pose_noise.disturb(&said, pose_seed, i);
            let real = self.repeatability.disturb(&real, 5000 + run, i);
            let seed = 1000 * (run + 1) + i;
            let anew = self.distorted_anew.then(|| self.device.distortion(seed));
            let field = anew.as_ref().unwrap_or(&fixed);
            let scan = self.device.shoot(&self.world, &real, &X_RV, field, seed);
            let seen = ground(&scan, &self.config.ground).expect("there is ground");
            PlanePair {
                robot: self.config.camera.robot_plane(&said),
                sensor: seen.plane,
                common: seen.common,
            }
        };
        (0..).zip(&stances::TABLE_A1).map(pair).collect()
    }
}

/// One run against the truth.
pub struct Outcome {
    pub found: Identification,
    /// α, β, γ in degrees and p in mm less the true ones: of the joint estimate, and of the closed
    /// form.
    pub error: [f64; 6],
    pub closed_error: [f64; 6],
    pub values: [f64; 6],
    /// Predicted standard deviations, in the same units.
    pub sigma: [f64; 6],
    /// eᵀ Σ⁻¹ e / 6.
    pub nees: f64,
}

pub fn outcome(pairs: &[PlanePair], config: &CameraConfig) -> Outcome {
    let truth = published_extrinsics();
    let found = identify(pairs, config).expect("the poses determine the mount");
    let closed = closed_form(pairs).expect("the poses determine the mount");
    let delta = step(&truth, &found.X_RV);
    let inverse = found.covariance.try_inverse();
    let inverse = inverse.unwrap_or_else(Matrix6::identity);
    let sigma = PaperParameters::of_mount(&found.X_RV).deviations(&found.covariance);
    Outcome {
        error: difference(&values(&found.X_RV), &values(&truth)),
        closed_error: difference(&values(&closed), &values(&truth)),
        values: values(&found.X_RV),
        sigma: degrees_and_mm(sigma.expect("β is not ±90°")),
        nees: delta.dot(&(inverse * delta)) / 6.0,
        found,
    }
}

/// (δθ, δp) from `from` to `to`.
fn step(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Vector6<f64> {
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    let shift = to.translation.vector - from.translation.vector;
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}

/// α, β, γ in degrees, p in mm.
pub fn values(X_RV: &Isometry3<f64>) -> [f64; 6] {
    let p = PaperParameters::of_mount(X_RV);
    let ([a, b, c], [x, y, z]) = (p.angles_rad, p.position_m);
    degrees_and_mm([a, b, c, x, y, z])
}

/// Three angles, rad, and three lengths, m, in degrees and mm.
pub fn degrees_and_mm([a, b, c, x, y, z]: [f64; 6]) -> [f64; 6] {
    let [a, b, c] = [a, b, c].map(f64::to_degrees);
    let [x, y, z] = [x, y, z].map(|length| 1e3 * length);
    [a, b, c, x, y, z]
}

fn difference(a: &[f64; 6], b: &[f64; 6]) -> [f64; 6] {
    [0, 1, 2, 3, 4, 5].map(|k| a[k] - b[k])
}

pub fn rms(rows: &[[f64; 6]]) -> [f64; 6] {
    let n = rows.len() as f64;
    [0, 1, 2, 3, 4, 5].map(|k| (rows.iter().map(|r| r[k] * r[k]).sum::<f64>() / n).sqrt())
}

/// Mean and standard deviation of every column.
pub fn spread(rows: &[[f64; 6]]) -> ([f64; 6], [f64; 6]) {
    let n = rows.len() as f64;
    let mean = [0, 1, 2, 3, 4, 5].map(|k| rows.iter().map(|r| r[k]).sum::<f64>() / n);
    let square = |k: usize| rows.iter().map(|r| (r[k] - mean[k]).powi(2)).sum::<f64>();
    let sigma = [0, 1, 2, 3, 4, 5].map(|k| (square(k) / (n - 1.0)).sqrt());
    (mean, sigma)
}

pub fn row(name: &str, values: &[f64; 6]) {
    let cells: Vec<String> = values.iter().map(|v| format!("{v:>9.4}")).collect();
    println!("{name:<44}{}", cells.join(""));
}

pub fn heading() {
    let heads = ["α °", "β °", "γ °", "p_x mm", "p_y mm", "p_z mm"];
    println!("{:<44}{}", "", heads.map(|h| format!("{h:>9}")).join(""));
}
