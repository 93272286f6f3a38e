//! Plays stances and motions in MuJoCo and judges them.
//!
//! | question | module |
//! |---|---|
//! | what is simulated: the parsed robot and convex bodies as model text | [`mjcf`], [`world`], [`physics`] |
//! | what is wanted at which time | [`mod@reference`], [`schedule`] |
//! | M v̇ + h = (0, τ) + Σ Jᵀ f | [`dynamics`] |
//! | torques from one quadratic program | [`whole_body`] |
//! | what robust runs change | [`perturbation`]; the faces that it moves: [`used_faces`] |
//! | a robot's MJCF as the URDF that stands for it | `from_mjcf` (feature `mujoco`) |
//! | what the controller is told of the robot | `sensing` |
//! | what was measured against what is allowed | [`criteria`] |
//! | does a stance hold, is a motion executed | `hold`, `execution` (feature `mujoco`) |
//! | pictures | `picture` (feature `render`) |
//!
//! The controllers know the robot as it was planned with; the simulated one may differ in mass,
//! friction and surroundings. Only `plant.rs`, `picture.rs` and `from_mjcf.rs` know MuJoCo.
//!
//! ```
//! use simulation::mjcf::model;
//! use simulation::physics::{Physics, Scales, Servo};
//!
//! let robot = scenes::builtin_robot("hexapod")
//!     .expect("it ships")
//!     .load(&robot_model::Config::default())?;
//! let physics = Physics::from(&simulation::Config::default());
//! let text = model(&robot, &[], &physics, Servo::STIFF, &Scales::default())?;
//! assert_eq!(text.matches("<body ").count(), robot.bodies.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod config;
mod corners;
pub mod criteria;
pub mod dynamics;
mod error;
pub mod mjcf;
pub mod outcome;
pub mod perturbation;
pub mod physics;
pub mod playback;
mod qp;
pub mod reference;
pub mod schedule;
pub mod used_faces;
pub mod whole_body;
pub mod world;

#[cfg(feature = "mujoco")]
mod clock;
#[cfg(feature = "mujoco")]
mod control;
#[cfg(feature = "mujoco")]
pub mod execution;
#[cfg(feature = "mujoco")]
pub mod from_mjcf;
#[cfg(feature = "mujoco")]
pub mod hold;
#[cfg(feature = "mujoco")]
mod monitor;
#[cfg(feature = "mujoco")]
mod observed;
#[cfg(feature = "render")]
pub mod picture;
#[cfg(feature = "mujoco")]
pub mod plant;
#[cfg(feature = "mujoco")]
mod run;
#[cfg(feature = "mujoco")]
mod sensing;
#[cfg(feature = "mujoco")]
mod touching;
#[cfg(feature = "mujoco")]
mod verdict;

/// Version of the MuJoCo library that the bindings are made for.
pub const MUJOCO_VERSION: &str = "3.17.0";

pub use config::Config;
pub use error::Error;
