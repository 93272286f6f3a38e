//! Any text as a URDF, an SRDF and a contacts file, separated by NUL: a robot, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robot_model::{Config, load, load_from_strings};

fuzz_target!(|text: &str| {
    let mut parts = text.split('\0');
    let urdf = parts.next().unwrap_or_default();
    let (srdf, contacts) = (parts.next(), parts.next());
    let config = Config::default();
    if let Ok(robot) = load_from_strings(urdf, srdf, contacts, "fuzz", &load::no_meshes, &config) {
        assert_eq!(robot.nv(), 6 + robot.nj());
    }
});
