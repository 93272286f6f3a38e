//! The tests of calibration from outside, in one binary.

mod bound;
mod ground;
mod lidar_mounts;
mod published_figures;
mod robustness;
mod sensor_models;
mod support;
mod table_a1;
