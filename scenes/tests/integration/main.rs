//! The tests of scenes from outside, in one binary.
#![allow(clippy::unwrap_used)] // A failure's place is all that a test need say.

mod contact_sets;
mod geometry;
#[path = "../../examples/make_robots/hexapod.rs"]
mod hexapod;
#[path = "../../examples/make_robots/hexapod_urp.rs"]
mod hexapod_urp;
#[path = "../../examples/make_robots/hrp2.rs"]
mod hrp2;
#[path = "../../examples/make_robots/hrp2_shapes.rs"]
mod hrp2_shapes;
#[path = "../../examples/make_robots/parts.rs"]
mod parts;
#[path = "../../examples/make_robots/quadruped.rs"]
mod quadruped;
mod robots;
mod scans;
mod scene_files;
#[path = "../../examples/make_robots/writer.rs"]
mod writer;
