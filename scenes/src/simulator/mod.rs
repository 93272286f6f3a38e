//! A structured-light depth camera, simulated: ray casting plus the errors that such a sensor makes;
//! and, in [`lidar`], a spinning range finder.
//!
//! ```text
//! bodies ──cast──▶ true depth ──noise──▶ measured depth ──dropouts──▶ image in mm
//!                     └─▶ the face that every pixel sees
//! ```
//!
//! The same world, pose, noise and seed give the same image byte for byte: all random numbers come
//! from a counter ([`rng`]), and nothing on the way depends on a platform's transcendental functions.

mod body;
mod camera;
mod dropout;
mod field;
pub mod lidar;
mod noise;
pub mod rng;
mod scan;

pub use body::{ConvexBody, HalfSpace, Hit, World};
pub use camera::{KINECT, Pinhole, XTION};
pub use field::Field;
pub use noise::DepthNoise;
pub use scan::{Scan, distortion, scan, scan_distorted};
