//! Flat ground with low blocks between which, and onto which, a hexapod steps with its body level.
//!
//! Blocks are 50 to 100 mm high: the legs lift by 200 mm at the body's height of 0.68 m, and a
//! robot that is 20 mm wrong about a top stamps or stumbles. The depth camera sits where
//! \[chai2015\] Eq. 32 found it; the scene file takes its place from an identification.

use nalgebra::Isometry3;

use super::{Block, floor};
use crate::camera_set::published_extrinsics;
use crate::truth::Truth;

/// Height of the body at the start, m.
pub const BODY_HEIGHT_M: f64 = 0.68;

/// The blocks.
pub const BLOCKS: [Block; 5] = [
    Block::new("left slab", [1.55, 0.62], [0.60, 0.50], 0.08, 0.0),
    Block::new("right slab", [1.75, -0.66], [0.60, 0.50], 0.10, 6.0),
    Block::new("middle block", [1.50, 0.0], [0.22, 0.30], 0.10, 15.0),
    Block::new("far block", [2.35, 0.35], [0.45, 0.55], 0.05, -8.0),
    Block::new("far right block", [2.60, -0.55], [0.40, 0.50], 0.07, 0.0),
];

/// The bodies: floor and blocks.
pub fn truth() -> Truth {
    let mut boxes = vec![floor()];
    boxes.extend(BLOCKS.iter().map(Block::body));
    Truth {
        scene: "hexapod-obstacles".into(),
        boxes,
    }
}

/// The true pose of the camera's optical frame at the start.
pub fn X_WV() -> Isometry3<f64> {
    Isometry3::translation(0.0, 0.0, BODY_HEIGHT_M) * published_extrinsics()
}
