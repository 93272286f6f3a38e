//! The tests of calibration from outside, in one binary.

mod bound;
mod ground;
mod lidar_mounts;
mod published_figures;
mod support;
mod table_a1;

/// What takes more than a few seconds.
mod slow {
    mod robustness;
    mod sensor_models;
}
