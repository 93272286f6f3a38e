//! A spinning multi-beam range finder (VLP-16), simulated: ray casting, the errors of such a sensor,
//! and its files.
//!
//! ```text
//! bodies ──cast──▶ true range ──footprint, noise, ring bias──▶ measured range ──▶ PCD, packets
//! ```
//!
//! Frame V: x forward (azimuth 0), y left, z up along the axis of rotation, origin at the optical
//! centre. Azimuths are counter-clockwise about z, from −π to π.

mod device;
mod file;
mod noise;
mod sweep;

pub use device::Vlp16;
pub use file::{pcap, pcd};
pub use noise::RangeNoise;
pub use sweep::{Return, Sweep, sweep};
