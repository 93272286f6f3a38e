//! The robots and scenes that ship, as data, and the sensor simulator that made their scans.
//!
//! * [`builtin`] and [`names`]: the scenes, each with its scene file, its scan and the true world.
//! * [`builtin_robot`]: the robots, each with its URDF, SRDF and contact patches.
//! * [`SceneFile`]: the scene file's fields, for the scenes that ship and for a user's own.
//! * [`truth`] and [`worlds`]: what really stands there, to judge the surfaces by and to simulate.
//! * [`simulator`]: the depth camera.
//! * [`stances`], [`camera_set`]: poses of a body over flat ground, with the joint readings and
//!   frames of a robot that takes them, to find a sensor's mount from.
//! * [`contact_sets`]: posture problems drawn from a seed, and the format of their files.
//!
//! Scans are made again with `cargo run -p scandent-scenes --example make_scans`, robots with
//! `cargo run -p scandent-scenes --example make_robots`.
//!
//! ```
//! let robot = scenes::robot("hrp2").ok_or("it ships")?;
//! let scene = scenes::builtin("irregular-stairs").ok_or("it ships")?;
//! let file = scenes::SceneFile::parse(scene.toml)?;
//! let truth = (scene.truth)();
//! println!("{} climbs {} boxes to {:?}", robot.name, truth.boxes.len(), file.goal);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod builtin;
pub mod camera_set;
pub mod contact_sets;
mod error;
mod robots;
pub mod scene_file;
pub mod simulator;
pub mod stances;
pub mod truth;
pub mod worlds;

pub use builtin::{Builtin, builtin, names};
pub use error::Error;
pub use robots::{BuiltinRobot, builtin_robot, robot, robot_names};
pub use scene_file::SceneFile;
pub use truth::{Face, OrientedBox, Truth};
