//! What the crate promises, seen from outside: a module for each promise.
#![allow(clippy::unwrap_used)]

mod almost_right;
mod any_cloud;
mod any_image;
mod bag_files;
mod bags;
mod lidar_clouds;
mod mutated_files;
mod obstructed_ramps;
mod outline_edges;
mod paper_tables;
mod perceive;
mod ramps;
mod readers;
mod real_scans;
mod scan_files;
mod several_scans;
mod shapes;
mod simulated;
mod strange_scans;
mod support;
mod surroundings;
mod voxels;

/// What takes more than a few seconds.
mod slow {
    mod insets;
    mod registered_worlds;
}
