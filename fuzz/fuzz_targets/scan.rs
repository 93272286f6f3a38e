//! Any bytes as a scan of any format: one with a finite point, or an error that names the file.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use perception::{SensorOptions, parse_scan};

fuzz_target!(|bytes: &[u8]| {
    for name in ["fuzz.png", "fuzz.pcd", "fuzz.ply"] {
        match parse_scan(Path::new(name), bytes, &SensorOptions::default()) {
            Ok(scan) => assert!(scan.cloud.finite().next().is_some()),
            Err(error) => assert!(error.to_string().starts_with(name)),
        }
    }
});
