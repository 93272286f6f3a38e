//! What a robot is: a tree of bodies under a floating base, read from URDF + SRDF + contacts.
//!
//! | question | answered by |
//! |---|---|
//! | which bodies, joints, limits, frames | [`Robot`], [`Body`], [`Frame`] |
//! | where may it touch the world | [`ContactPatch`] |
//! | where is it: q = \[p_WB, quat_xyzw, joints…\] | [`Configuration`] |
//! | poses, centre of mass, Jacobians, gravity torques | [`Kinematics`] |
//! | distances to itself and to the world | [`collision`] |
//! | where might it touch, which pairs need no watching | [`propose`] |
//! | how is it read from files | [`load()`], [`load_from_strings`], [`mesh_file`] |
//!
//! ```
//! use robot_model::{Kinematics, RobotFiles, load};
//!
//! let robot = load(&RobotFiles::new("tests/golden/test_tree.urdf"))?;
//! let mut configuration = robot.neutral();
//! configuration.joints[robot.joint_index("hip")?] = 0.5;
//! let kinematics = Kinematics::new(&robot, &configuration);
//! println!("centre of mass {}, sole {}", kinematics.com_W, kinematics.X_WL(&robot, "sole")?);
//! assert!(robot.colliding_pairs(&configuration).is_empty());
//! # Ok::<(), robot_model::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod body;
pub mod collision;
pub mod config;
pub mod configuration;
pub mod contact;
pub mod error;
pub mod kinematics;
pub mod load;
pub mod mesh_file;
pub mod propose;
pub mod robot;
pub mod toml_file;
mod xml;

pub use body::{Body, Frame, JointKind};
pub use config::Config;
pub use configuration::Configuration;
pub use contact::{ContactPatch, PatchId, PatchKind, pyramid_axes_W};
pub use error::Error;
pub use kinematics::Kinematics;
pub use load::{RobotFiles, load, load_from_strings, load_with};
pub use robot::{NamedPosture, Robot};
pub use xml::is_mjcf;

/// No coordinate of a robot's part or of a body that it meets is greater, m: what is, is a mistake.
pub const GREATEST_M: f64 = 1e4;

/// Gravity, along −z of W; m/s². Stated here and nowhere else.
pub const GRAVITY_M_S2: f64 = 9.81;
