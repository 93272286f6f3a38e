//! The tests of robot_model from outside, in one binary.
#![allow(clippy::unwrap_used)] // A failure's place is all that a test need say.

mod bad_files;
mod derivatives;
mod distances;
mod kinematics_golden;
mod mutations;
mod propose;
mod robots;
mod support;
mod tree;
