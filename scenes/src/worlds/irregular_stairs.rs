//! `irregular-stairs`: four pieces of furniture, left and right of the way, lead onto a table.
//!
//! | surface | top, m | x, m        | y, m          | yaw | rise from the foot before | sole centre |
//! |---------|--------|-------------|---------------|-----|---------------------------|-------------|
//! | floor   | 0      |             |               |     |                           | 0.02        |
//! | step 1  | 0.14   | 0.31 … 0.65 | 0.02 … 0.36   | −4° | 0.14 (may be skipped)     |             |
//! | step 2  | 0.26   | 0.31 … 0.67 | −0.34 … 0.00  | 5°  | 0.26 from the floor       | 0.45        |
//! | step 3  | 0.41   | 0.70 … 1.06 | −0.03 … 0.33  | −6° | 0.15                      | 0.87        |
//! | step 4  | 0.56   | 1.09 … 1.43 | −0.33 … 0.05  | 4°  | 0.15                      | 1.26        |
//! | table   | 0.71   | 1.48 … 2.48 | −0.75 … 0.75  | 1°  | 0.15                      | 1.63, 1.96  |
//!
//! (Ranges of the unturned rectangles, m.) A sole of 0.23 × 0.131 m has 40 mm or more to every edge
//! of a tread. With the right foot on step 2, the left on 3, the right on 4 and both on the table,
//! at the sole centres of the last column, there are five placements: a path of 11 contact sets,
//! never both feet on one step, as in brossette2013, Plan 1. An independent least-squares posture
//! search finds every transition of it statically feasible with 80 % of torque and friction and the
//! CoM 30 mm inside the sole; the first is the hardest (knee at 80 %).

use super::{Block, Table, floor};
use crate::truth::Truth;

/// The four steps.
pub const STEPS: [Block; 4] = [
    Block::new("step 1", [0.48, 0.19], [0.34, 0.34], 0.14, -4.0),
    Block::new("step 2", [0.49, -0.17], [0.36, 0.34], 0.26, 5.0),
    Block::new("step 3", [0.88, 0.15], [0.36, 0.36], 0.41, -6.0),
    Block::new("step 4", [1.26, -0.14], [0.34, 0.38], 0.56, 4.0),
];

/// The table.
pub const TABLE: Table = Table {
    block: Block::new("table", [1.98, 0.0], [1.0, 1.5], 0.71, 1.0),
    slab_m: 0.03,
    leg_m: 0.05,
    leg_inset_m: 0.10,
};

/// The bodies: floor, steps, table.
pub fn truth() -> Truth {
    let mut boxes = vec![floor()];
    boxes.extend(STEPS.iter().map(Block::body));
    boxes.extend(TABLE.bodies());
    Truth {
        scene: "irregular-stairs".into(),
        boxes,
    }
}
