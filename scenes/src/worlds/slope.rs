//! `slope-NN`: a ramp ahead of a quadruped, in a room with two walls and three poles.
//!
//! The seven ramps of \[meng\], Tables 1 and 2: their angles are those of its inclinometer, and each
//! begins where its table says (the mean of the two end points, their distance as the width, the
//! direction between them). They are 2.4 m long, so that a quadruped can stand on them. In
//! `slope-NN-at-30` such a ramp is wider, and turned by 30° from the robot's way.

use nalgebra::{Rotation3, Unit, Vector3};

use super::floor;
use crate::truth::{OrientedBox, Truth};

/// A ramp on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Angle to the floor, degrees.
    pub angle_deg: f64,
    /// Middle of the line where it begins, x and y in W, m.
    pub start_m: [f64; 2],
    /// Direction of ascent, degrees from x towards y.
    pub ascent_deg: f64,
    /// Length of the line where it begins, m.
    pub width_m: f64,
    /// Length along the slope, m.
    pub length_m: f64,
}

/// A row of \[meng\]'s tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Angle by the inclinometer, degrees.
    pub angle_deg: f64,
    /// Table 1: direction of the start line, as printed.
    pub line: [f64; 3],
    /// Table 1: end points of the start line, m.
    pub ends_m: [[f64; 3]; 2],
    /// Table 2: orientation, as printed.
    pub orientation: [f64; 3],
}

const fn row(
    angle_deg: f64,
    line: [f64; 2],
    near: [f64; 2],
    far: [f64; 2],
    z: f64,
    orientation: [f64; 3],
) -> Row {
    Row {
        angle_deg,
        line: [line[0], line[1], 0.0],
        ends_m: [[near[0], near[1], z], [far[0], far[1], z]],
        orientation,
    }
}

/// Tables 1 and 2 of \[meng\].
#[rustfmt::skip]
pub const PAPER: [Row; 7] = [
    row(10.5, [0.0042, 0.1887], [1.9330, -0.6047], [1.9584, 0.5429], -0.0009, [0.1853, -0.0041, 0.0356]),
    row(13.5, [0.0073, 0.2323], [1.9432, -0.6240], [1.9800, 0.5432], -0.0008, [0.2259, -0.0071, 0.0540]),
    row(15.3, [0.0072, 0.2591], [1.9425, -0.6193], [1.9744, 0.5361], -0.0008, [0.2502, -0.0069, 0.0672]),
    row(17.4, [0.0038, 0.2796], [1.9588, -0.6247], [1.9743, 0.5259], -0.0015, [0.2685, -0.0036, 0.0782]),
    row(19.7, [0.0038, 0.3237], [1.9840, -0.6181], [1.9974, 0.5178], -0.0026, [0.3063, -0.0036, 0.1048]),
    row(22.0, [0.0055, 0.3587], [1.9875, -0.6074], [2.0048, 0.5195], -0.0006, [0.3349, -0.0052, 0.1287]),
    row(23.8, [0.0069, 0.4014], [2.0000, -0.6150], [2.0195, 0.5277], -0.0013, [0.3676, -0.0063, 0.1612]),
];

/// Length of the ramps along the slope, m.
pub const LENGTH_M: f64 = 2.4;
/// Thickness of a ramp's board, m.
const BOARD_M: f64 = 0.04;
/// Middle of the poles, x and y in W, m.
pub const POLES_M: [[f64; 2]; 3] = [[2.6, 1.6], [3.4, -1.9], [1.5, 2.4]];
/// Edge of the square poles, m.
pub const POLE_M: f64 = 0.08;

/// Where the sensor of the scenes' robot stands at the start, x in W, m: W begins below the robot's
/// base, the paper's world below the sensor.
const SENSOR_X_M: f64 = 0.36;

/// The true world of the scene of row `ROW` of the tables.
pub fn truth<const ROW: usize>() -> Truth {
    let row = &PAPER[ROW];
    let mut ramp = row.ramp();
    ramp.start_m[0] += SENSOR_X_M;
    room(&format!("slope-{}", row.angle_deg), &[ramp])
}

/// How much the ramps of [`turned`] are turned from the robot's way, degrees.
pub const TURN_DEG: f64 = 30.0;
/// Their width, m: a robot that goes straight on drifts to their side.
const TURNED_WIDTH_M: f64 = 2.0;

/// The true world of a scene in which the ramp of row `ROW` is wider and turned from the robot's way,
/// so that it walks at that angle to the fall line.
pub fn turned<const ROW: usize>() -> Truth {
    let row = &PAPER[ROW];
    let straight = row.ramp();
    let ramp = Ramp {
        start_m: [straight.start_m[0] + SENSOR_X_M, 0.0],
        ascent_deg: TURN_DEG,
        width_m: TURNED_WIDTH_M,
        ..straight
    };
    room(&format!("slope-{}-at-{TURN_DEG}", row.angle_deg), &[ramp])
}

impl Row {
    /// The ramp that the row describes, its line on the floor.
    pub fn ramp(&self) -> Ramp {
        let [near, far] = self.ends_m;
        let (x, y) = (far[0] - near[0], far[1] - near[1]);
        Ramp {
            angle_deg: self.angle_deg,
            start_m: [(near[0] + far[0]) / 2.0, (near[1] + far[1]) / 2.0],
            // The ascent is a right angle clockwise from the line.
            ascent_deg: (-x).atan2(y).to_degrees(),
            width_m: x.hypot(y),
            length_m: LENGTH_M,
        }
    }
}

impl Ramp {
    /// The ends of the start line in W, m: the left one first, seen by who goes up.
    pub fn ends_m(&self) -> [[f64; 3]; 2] {
        let (s, c) = self.ascent_deg.to_radians().sin_cos();
        let half = self.width_m / 2.0;
        [1.0, -1.0].map(|side| {
            let [x, y] = self.start_m;
            [x - side * half * s, y + side * half * c, 0.0]
        })
    }

    /// The board's body.
    pub fn body(&self, name: &str) -> OrientedBox {
        let yaw = super::about_z(self.ascent_deg);
        let pitch = Rotation3::from_axis_angle(
            &Unit::new_unchecked(Vector3::y()),
            -self.angle_deg.to_radians(),
        );
        let rotation = yaw * pitch;
        let start = Vector3::new(self.start_m[0], self.start_m[1], 0.0);
        let centre = start + rotation * Vector3::new(self.length_m / 2.0, 0.0, -BOARD_M / 2.0);
        let size = [self.length_m, self.width_m, BOARD_M];
        OrientedBox::new(name, centre, size, rotation)
    }
}

/// Floor, ramps, walls and poles.
pub fn room(scene: &str, ramps: &[Ramp]) -> Truth {
    let mut boxes = vec![floor()];
    for (number, ramp) in ramps.iter().enumerate() {
        let name = match number {
            0 => "ramp".to_owned(),
            _ => format!("ramp {}", number + 1),
        };
        boxes.push(ramp.body(&name));
    }
    let upright = |name: &str, x: f64, y: f64, size: [f64; 3]| {
        let centre = Vector3::new(x, y, size[2] / 2.0);
        OrientedBox::new(name, centre, size, Rotation3::identity())
    };
    boxes.push(upright("wall ahead", 6.05, 0.0, [0.1, 12.0, 4.0]));
    boxes.push(upright("wall beside", 2.5, 4.55, [10.0, 0.1, 4.0]));
    for (number, [x, y]) in POLES_M.into_iter().enumerate() {
        let name = format!("pole {}", number + 1);
        boxes.push(upright(&name, x, y, [POLE_M, POLE_M, 2.0]));
    }
    Truth {
        scene: scene.into(),
        boxes,
    }
}
