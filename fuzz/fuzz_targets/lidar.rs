//! Any bytes as a LiDAR's .pcap or .pcd file: finite points, or an error that names the file.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use perception::parse_lidar;

fuzz_target!(|bytes: &[u8]| {
    match parse_lidar(Path::new("fuzz.pcap"), bytes, None) {
        Ok(read) => assert!(read.cloud.points_V.iter().flatten().all(|c| c.is_finite())),
        Err(error) => assert!(error.to_string().starts_with("fuzz.pcap")),
    }
});
