//! The tests of scenes from outside, in one binary.
#![allow(clippy::unwrap_used)] // A failure's place is all that a test need say.

mod contact_sets;
mod geometry;
#[path = "../../examples/make_robots/robot.rs"]
mod make_robots;
mod robots;
mod scans;
mod scene_files;
