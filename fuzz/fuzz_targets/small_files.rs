//! Any text as each of the application's smaller files: what it says, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scandent::{config, extrinsics, posture_problem, slope};

fuzz_target!(|text: &str| {
    let _ = posture_problem::parse(text.as_bytes());
    let _ = slope::calibration_file::parse(text.as_bytes());
    let _ = extrinsics::file::Extrinsics::parse(text);
    let _ = extrinsics::stances_file::parse(text, &["left", "right"]);
    if let (Ok(table), Ok(mut layers)) = (toml::from_str(text), config::Layers::new()) {
        let _ = layers.lay("fuzz", &table).and_then(|()| layers.resolve());
    }
});
