//! Which stance to add: those that the legs reach and from which the sensor sees ground.

use calibration::camera::{Candidate, Identification, NextPose, PlanePair, next_pose};
use calibration::ground::{GroundConfig, ground};
use calibration::{Config, GroundPlane};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use perception::{DepthImage, Intrinsics, Noise, Scan};
use robot_model::Robot;
use robot_model::kinematics::{PointTarget, reach};

use super::feet::Feet;
use super::identify::{Footholds, Measured, View};

/// How many times smaller than the sensor's the image is in which views are foreseen.
const SMALLER: usize = 8;
/// Largest tilt of a stance that is proposed, and the step of the tilts that are tried, rad.
const TILT_MAX_RAD: f64 = 20.0_f64.to_radians();
const TILT_STEP_RAD: f64 = 5.0_f64.to_radians();
/// Least share of the image that must see ground within range.
const GROUND_SHARE_MIN: f64 = 0.2;
/// How near the feet must come to where they stand, m.
const REACHED_M: f64 = 1e-5;

/// The stance to add and its pose over the ground; `None` where no candidate is in reach.
pub fn next(
    robot: &Robot,
    feet: &Feet,
    footholds: Option<&Footholds>,
    view: Option<&View>,
    measured: &[Measured],
    found: &Identification,
    config: &Config,
) -> Option<(Isometry3<f64>, NextPose)> {
    let pairs: Vec<PlanePair> = measured.iter().map(|one| one.pair.clone()).collect();
    let candidates: Vec<Candidate> = poses(measured)
        .into_iter()
        .filter(|X_GR| footholds.is_none_or(|holds| in_reach(robot, feet, holds, X_GR)))
        .filter_map(|X_GR| candidate(X_GR, view, measured, found, config))
        .collect();
    let best = next_pose(&pairs, &found.X_RV, &candidates)?;
    Some((candidates[best.candidate].X_GR, best))
}

/// Tilts on a grid at the least, the middle and the greatest height that were taken.
fn poses(measured: &[Measured]) -> Vec<Isometry3<f64>> {
    let heights = || measured.iter().map(|one| one.X_GR.translation.z);
    let (low, high) = heights().fold((f64::INFINITY, 0.0_f64), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    let steps = (TILT_MAX_RAD / TILT_STEP_RAD).floor() as i32;
    let mut poses = Vec::new();
    for height in [low, 0.5 * (low + high), high] {
        for roll in -steps..=steps {
            for pitch in -steps..=steps {
                let [roll, pitch] = [roll, pitch].map(|k| f64::from(k) * TILT_STEP_RAD);
                poses.push(Isometry3::from_parts(
                    Vector3::new(0.0, 0.0, height).into(),
                    UnitQuaternion::from_euler_angles(roll, pitch, 0.0),
                ));
            }
        }
    }
    poses
}

/// Whether the legs reach the footholds from `X_GR`. A link that joints move against the base says
/// nothing about the legs: such stances are left to the user.
fn in_reach(robot: &Robot, feet: &Feet, holds: &Footholds, X_GR: &Isometry3<f64>) -> bool {
    let Ok(link) = robot.frame(&feet.link) else {
        return false;
    };
    if link.body != 0 {
        return true;
    }
    let base = X_GR * link.X_BL.inverse();
    let points = feet.points(robot).into_iter().zip(&holds.feet_G);
    let target = |((body, p_B), p_W): (_, &Point3<f64>)| PointTarget {
        body,
        p_B,
        p_W: p_W.coords,
    };
    let targets: Vec<PointTarget> = points.map(target).collect();
    let near = holds.near.clone().with_base(&base);
    reach(robot, &near, &targets, REACHED_M).is_some()
}

fn candidate(
    X_GR: Isometry3<f64>,
    view: Option<&View>,
    measured: &[Measured],
    found: &Identification,
    config: &Config,
) -> Option<Candidate> {
    let robot = config.camera.robot_plane(&X_GR);
    let seen = robot.seen_from(&found.X_RV);
    let sensor = match view {
        Some(view) => {
            let (plane, share) = foresee(view, &seen, &config.ground)?;
            if share < GROUND_SHARE_MIN {
                return None;
            }
            plane
        }
        // A cloud's sensor: as well as on average.
        None => {
            let n = measured.len().max(1) as f64;
            let sum = measured.iter().map(|one| one.pair.sensor.covariance);
            GroundPlane {
                covariance: sum.sum::<nalgebra::Matrix3<f64>>() / n,
                ..seen
            }
        }
    };
    Some(Candidate {
        X_GR,
        robot,
        sensor,
    })
}

/// The ground as the sensor will see it where it is the plane `truth` in V, and the share of
/// the image that sees it within range; `None` where that is too little.
fn foresee(view: &View, truth: &GroundPlane, config: &GroundConfig) -> Option<(GroundPlane, f64)> {
    let scale = 1.0 / SMALLER as f64;
    let (width, height) = (view.size_px.0 / SMALLER, view.size_px.1 / SMALLER);
    let k = Intrinsics {
        fx: view.intrinsics.fx * scale,
        fy: view.intrinsics.fy * scale,
        cx: (view.intrinsics.cx + 0.5) * scale - 0.5,
        cy: (view.intrinsics.cy + 0.5) * scale - 0.5,
    };
    let depth = |i: usize| {
        let (u, v) = ((i % width) as f64, (i / width) as f64);
        let ray = Vector3::new((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
        // n·(z r) + d = 0.
        let toward = -truth.normal.dot(&ray);
        let z_m = truth.distance_m / toward;
        if toward > 1e-6 { z_m as f32 } else { 0.0 }
    };
    let image = DepthImage {
        width,
        height,
        z_m: (0..width * height).map(depth).collect(),
        intrinsics: k,
    };
    let noise = Noise {
        correlation_px: view.noise.correlation_px * scale,
        systematic_scale_px: view.noise.systematic_scale_px * scale,
        ..view.noise
    };
    let scan = Scan::of_image(image, noise);
    // The image has no noise: any three of its pixels give the plane.
    let config = GroundConfig {
        draws: 5,
        inliers_min: config.inliers_min.div_ceil(SMALLER * SMALLER).max(3),
        ..config.clone()
    };
    let seen = ground(&scan, &config).ok()?;
    let share = seen.samples as f64 / (width * height).max(1) as f64;
    let plane = GroundPlane {
        covariance: seen.plane.covariance,
        ..*truth
    };
    Some((plane, share))
}
