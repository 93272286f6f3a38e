//! What tests share: worlds of boxes, a camera over them, and the truth.
// Benches share this with the tests, and use only some of it.
#![allow(dead_code, unused_imports, clippy::unwrap_used)]

#[path = "support/camera.rs"]
mod camera;
#[path = "support/truth.rs"]
mod truth;

use std::path::PathBuf;

use nalgebra::Point3;
use perception::{Config, Method, Scan, extract};

pub use camera::*;
pub use truth::*;

/// The defaults, but for the method.
pub fn by(method: Method) -> Config {
    Config {
        method,
        ..Config::default()
    }
}

/// What comes of work on that many threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

/// The faces of a scan, which are valid, named in order and look at the sensor.
pub fn faces_of(scan: &Scan, method: Method) -> Vec<surfaces::Face> {
    let found = extract(scan, &scan.X_WV, &by(method)).unwrap().faces;
    let eye = scan.X_WV * Point3::from(scan.eye_V);
    for (i, face) in found.iter().enumerate() {
        face.validate().unwrap();
        assert_eq!(face.id, format!("f{i}").into());
        assert!(face.height_of(&eye) > 0.0, "{} looks away", face.id);
    }
    found
}

/// The file below `shared/scans` (`SCANDENT_SHARED`, or `shared` beside the workspace), or `None`, loudly.
pub fn shared(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let root = std::env::var_os("SCANDENT_SHARED").map_or_else(beside, PathBuf::from);
    let path = root.join("scans").join(name);
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there", path.display());
        return None;
    }
    Some(path)
}

/// The floor of every world.
pub fn floor() -> Block {
    block("floor", [4.0, 0.0, -0.05], [12.0, 12.0, 0.1], 0.0, 0.0)
}

/// Steps, a table and a ramp on a floor before a wall.
pub fn stairs() -> Vec<Block> {
    vec![
        floor(),
        block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        block("step1", [1.15, 0.05, 0.075], [0.34, 0.62, 0.15], 0.1, 0.0),
        block("step2", [1.50, -0.02, 0.15], [0.36, 0.70, 0.30], -0.07, 0.0),
        block("step3", [1.88, 0.06, 0.22], [0.38, 0.55, 0.44], 0.05, 0.0),
        block(
            "step4",
            [2.26, -0.03, 0.285],
            [0.36, 0.60, 0.57],
            -0.12,
            0.0,
        ),
        block("table", [2.90, 0.0, 0.695], [0.80, 1.60, 0.03], 0.02, 0.0),
        block("ramp", [1.9, -1.15, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
    ]
}

/// Faces in the shapes of an L and a U, and a table with a box on it.
pub fn concave() -> Vec<Block> {
    vec![
        floor(),
        block("l_long", [1.55, 0.55, 0.10], [0.9, 0.35, 0.20], 0.0, 0.0),
        block("l_short", [1.825, 0.175, 0.10], [0.35, 0.4, 0.20], 0.0, 0.0),
        block("u_right", [1.6, -0.95, 0.15], [0.9, 0.25, 0.30], 0.0, 0.0),
        block("u_far", [1.925, -0.625, 0.15], [0.25, 0.4, 0.30], 0.0, 0.0),
        block("u_left", [1.6, -0.30, 0.15], [0.9, 0.25, 0.30], 0.0, 0.0),
        block("table", [2.9, 0.2, 0.60], [0.9, 1.6, 0.04], 0.0, 0.0),
        block("box", [2.85, 0.15, 0.72], [0.3, 0.3, 0.20], 0.35, 0.0),
    ]
}
