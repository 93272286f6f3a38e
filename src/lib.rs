//! Plans multi-contact climbs for legged robots from a single scan: the application.
//!
//! `pipeline` reads top-down as the way of one scan; `cli` and `command` are what a user meets;
//! the crate `verify` proves a plan by code that shares nothing with the solver.
#![forbid(unsafe_code)]

// The same plan on every platform.
use elementary as _;

pub mod against;
pub mod argument;
pub mod batch;
pub mod bench;
pub mod cli;
pub mod command;
pub mod config;
pub mod dataset;
pub mod environment;
pub mod environment_flags;
pub mod export;
pub mod extrinsics;
pub mod goal;
pub mod imu;
pub mod interrupt;
pub mod mistakes;
pub mod output;
pub mod pipeline;
pub mod plan_file;
pub mod posed;
pub mod posture_problem;
pub mod progress;
pub mod propose;
pub mod provenance;
pub mod report;
pub mod results;
pub mod robot_files;
pub mod roles;
pub mod scene;
pub mod schemas;
mod search_file;
pub mod serve;
pub mod signature;
pub mod simulate;
pub mod slope;
pub mod start;
pub mod start_flags;
pub mod status;
pub mod summary;
pub mod template;
pub mod threads;
pub mod told;
pub mod unseen;
pub mod unsolved;
pub mod view;

/// This program, as it signs its results.
pub fn program() -> plan::Program {
    plan::Program {
        name: env!("CARGO_PKG_NAME").to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}
