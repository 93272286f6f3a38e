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
