//! The commands, one file each: what it reads, what it does, what it prints and writes.

pub mod batch;
pub mod bench;
pub mod calibrate;
pub mod completions;
pub mod config;
pub mod export;
pub mod man;
pub mod plan;
pub mod posture;
pub mod posture_sets;
pub mod robot;
pub mod run;
pub mod scenes;
pub mod schemas;
pub mod serve;
pub mod simulate;
pub mod slope;
pub mod surfaces;
pub mod verify;
pub mod view;
