//! `slope-and-hand`: a slippery inclined board beside a cabinet, a step at its end, then a table.
//!
//! | body    | top, m      | x, m        | y, m          |                                      |
//! |---------|-------------|-------------|---------------|--------------------------------------|
//! | floor   | 0           |             |               |                                      |
//! | board   | 0 … 0.30    | 0.30 … 1.10 | −0.35 … 0.48  | 15°, rises ahead and to the right    |
//! | step    | 0.34        | 1.13 … 1.47 | −0.40 … 0.50  | at the board's end                   |
//! | table   | 0.53        | 1.50 … 2.50 | −0.65 … 0.55  | yaw 1°                               |
//! | cabinet | 0.95        | 0.42 … 1.15 | 0.55 … 1.00   | its side faces the way               |
//! | shelf   | 1.15        | 1.52 … 1.90 | 0.64 … 0.98   | beside the table                     |
//! | crate   | 0.69        | 1.90 … 2.20 | 0.30 … 0.52   | on the table, yaw 10°                |
//!
//! Twelve faces show at least 2000 pixels: five tops, two sides each of the cabinet and the shelf,
//! and the fronts of the step, the crate and the table's slab (which is 3 cm high).
//!
//! # Why the hand matters
//!
//! From the floor to the step every foothold is on the board: the step's nearest place for a sole is
//! more than a metre ahead of the feet at the start, and the floor ends at the board. The sole's
//! friction is 0.31, of which a plan may use 0.8: forces inside that cone lean by at most
//! atan 0.248 = 13.9° from the board's normal, and the weight leans by 15°. With both feet on the
//! board, or one foot there and the other in the air, no forces of the feet carry the robot, whatever
//! its posture: sin 15° − 0.248·cos 15° = 0.019 of the weight is missing.
//!
//! The board falls to the left, towards the cabinet: a hand that pushes against the cabinet's side
//! gets the missing force uphill, and one place of the hand, 0.7 to 0.9 m ahead and 0.8 to 0.9 m
//! high, serves both footholds on the board. An independent nonlinear program over all its postures
//! at once (torques and friction pyramid at 80 %, CoM margin 30 mm, joints 0.03 rad inside, bodies
//! may meet) finds foot → board, hand → cabinet, other foot → board, foot → step, hand off, other
//! foot → table, foot → table with either foot first and 12 to 70 N at the hand: 13 contact sets
//! (brossette2013, Plan 2, has 19). The board's whole friction, atan 0.31 = 17.2°, holds the robot
//! without the hand: the hand buys the margin, so that an execution which loses it does not slide
//! at once.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Block, Table, floor};
use crate::truth::{OrientedBox, Truth};

/// A rectangular board that leans on its supports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Angle to the horizontal, degrees.
    pub slope_deg: f64,
    /// Direction of steepest ascent, degrees from x towards y.
    pub ascent_deg: f64,
    /// Ranges of x and y of its plan, m; exact on the lines through its middle.
    pub plan_m: [[f64; 2]; 2],
    /// Height of the plane of its top over the plan's lowest corner, m.
    pub lowest_m: f64,
    /// Thickness, m.
    pub thickness_m: f64,
}

impl Board {
    /// Height of the plane of its top, m.
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        let gradient = self.gradient();
        let lowest = |range: [f64; 2], g: f64| if g > 0.0 { range[0] } else { range[1] };
        let [x0, y0] = [0, 1].map(|i| lowest(self.plan_m[i], gradient[i]));
        self.lowest_m + gradient[0] * (x - x0) + gradient[1] * (y - y0)
    }

    /// Rise per metre along x and y.
    fn gradient(&self) -> [f64; 2] {
        let direction = self.ascent_deg.to_radians();
        let tangent = self.slope_deg.to_radians().tan();
        [tangent * direction.cos(), tangent * direction.sin()]
    }

    /// The box, its x edge over the world's x axis.
    pub fn body(&self, name: &str) -> OrientedBox {
        let [gx, gy] = self.gradient();
        let along = Vector3::new(1.0, 0.0, gx).normalize();
        let up = Vector3::new(-gx, -gy, 1.0).normalize();
        let across = up.cross(&along);
        let rotation =
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[along, across, up]));
        let [[x0, x1], [y0, y1]] = self.plan_m;
        let [x, y] = [(x0 + x1) / 2.0, (y0 + y1) / 2.0];
        let centre = Vector3::new(x, y, self.height_m(x, y)) - up * (self.thickness_m / 2.0);
        let size = [(x1 - x0) / along.x, (y1 - y0) / across.y, self.thickness_m];
        OrientedBox::new(name, centre, size, rotation)
    }
}

/// The board.
pub const BOARD: Board = Board {
    slope_deg: 15.0,
    ascent_deg: -60.0,
    plan_m: [[0.30, 1.10], [-0.35, 0.48]],
    lowest_m: 0.0,
    thickness_m: 0.03,
};

/// The step, the cabinet and the shelf.
pub const BLOCKS: [Block; 3] = [
    Block::new("step", [1.30, 0.05], [0.34, 0.90], 0.34, 0.0),
    Block::new("cabinet", [0.785, 0.775], [0.73, 0.45], 0.95, 0.0),
    Block::new("shelf", [1.71, 0.81], [0.38, 0.34], 1.15, 0.0),
];

/// The table.
pub const TABLE: Table = Table {
    block: Block::new("table", [2.0, -0.05], [1.0, 1.2], 0.53, 1.0),
    slab_m: 0.03,
    leg_m: 0.05,
    leg_inset_m: 0.10,
};

/// Centre, size and yaw in degrees of the crate on the table.
pub const CRATE: ([f64; 3], [f64; 3], f64) = ([2.05, 0.41, 0.61], [0.30, 0.22, 0.16], 10.0);

/// The bodies: floor, board, step, table, and what stands beside.
pub fn truth() -> Truth {
    let mut boxes = vec![floor(), BOARD.body("board")];
    boxes.extend(BLOCKS.iter().map(Block::body));
    boxes.extend(TABLE.bodies());
    let (centre, size, yaw_deg) = CRATE;
    boxes.push(OrientedBox::new(
        "crate",
        Vector3::from(centre),
        size,
        super::about_z(yaw_deg),
    ));
    Truth {
        scene: "slope-and-hand".into(),
        boxes,
    }
}
