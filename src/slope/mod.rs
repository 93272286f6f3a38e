//! Slopes in a LiDAR's cloud: the calibration's file, and the file of what was found.

pub mod calibration_file;
pub mod record;
