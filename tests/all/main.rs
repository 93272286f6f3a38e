//! The whole program: its command line, its files, and its plans of scenes, from scan to execution.
//!
//! Scenario tests state their pass criteria at the top of their file. `slow` holds those that take
//! more than seconds; `scripts/test quick` leaves them out.
#![allow(clippy::unwrap_used)]

mod support;

mod architecture;
mod batch;
mod bench;
mod calibrate_camera;
mod cli;
mod documents;
mod export_formats;
mod first_robot;
mod home_page;
mod interruption;
mod mjcf_robot;
mod mutual_imports;
mod outputs;
mod posture_problems;
mod schemas;
mod serve;
mod slope_command;
mod starts;
mod verify_broken;
mod verify_malformed;
mod viewer;
mod way_of_a_scan;

mod slow {
    mod broken_pages;
    mod drawn_worlds;
    mod executed_scenes;
    mod hexapod_blocks;
    mod hexapod_obstacles;
    mod hexapod_walk;
    mod other_worlds;
    mod quadruped_slopes;
    mod random_postures;
    mod rough_ground;
    mod settings_at_their_limits;
    mod ten_mounts;
    mod verify_dips;
    mod verify_falsified;
    mod verify_leaves;
    mod verify_motion;
    mod verify_scenes;
    mod web_page;
}
