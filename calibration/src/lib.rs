//! Where a sensor sits on a robot, from what both know of the ground.
//!
//! The robot stands in several postures on flat ground. Its feet say where the ground is in the
//! robot's frame R, the sensor sees the same ground in its own frame V:
//!
//! ```text
//! scan ──────────────── [ground] ──▶ plane in V ─┐
//!                                                ├─ [camera] ──▶ X_RV, covariance, next pose
//! feet in R ─ [stance] ─▶ X_GR ───▶ plane in R ──┘
//! ```
//!
//! A plane n·p + d = 0 of one posture is the same in both frames where the mount X_RV is right:
//!
//!   n_R = R_RV n_V,        d_V = n_R · p_RV + d_R
//!
//! * [`ground`]: the ground's plane in one scan, by iterated trimming, with its covariance.
//! * [`stance`]: the robot's pose over the ground, from the places of its feet.
//! * [`lidar`]: a spinning LiDAR over the ground, its heading by poles, its rings' range errors.
//! * [`camera`]: the mount from the planes of all postures, how well they determine it, and which
//!   posture would add most.
//!
//! Frames: R the robot's (x forward, y left, z up), V the sensor's optical frame (x right, y down,
//! z forward), G the ground's (z up, its plane z = 0). Units: m, rad. Robots are not known here:
//! feet come in as points.
//!
//! ```
//! # #![allow(non_snake_case)]
//! use calibration::GroundPlane;
//! use calibration::camera::{CameraConfig, PlanePair, identify};
//! use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
//!
//! // A sensor 0.3 m over the body that looks down, and a body that leans four ways.
//! let mount = Isometry3::new(Vector3::new(0.1, 0.0, 0.3), Vector3::new(-2.2, 0.0, 0.0));
//! let pairs = [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.1), (0.0, -0.1)].map(|(roll, pitch)| {
//!     let lean = UnitQuaternion::from_euler_angles(roll, pitch, 0.0);
//!     let X_GR = Isometry3::from_parts(Vector3::new(0.0, 0.0, 0.8 + roll).into(), lean);
//!     let ground = GroundPlane::ground(&X_GR, 1e-6 * Matrix3::identity());
//!     PlanePair::new(ground, ground.seen_from(&mount))
//! });
//! let found = identify(&pairs, &CameraConfig::default())?;
//! let off_m = (found.X_RV.translation.vector - mount.translation.vector).norm();
//! assert!(off_m < 1e-6);
//! # Ok::<(), calibration::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod camera;
mod config;
mod error;
pub mod ground;
pub mod lidar;
mod plane;
mod registration;
pub mod stance;

pub use config::Config;
pub use error::Error;
pub use plane::GroundPlane;
pub use registration::{nearest_rotation, register};
