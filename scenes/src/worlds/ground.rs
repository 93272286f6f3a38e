//! Ground to find a sensor's mount on: flat, or with bumps.

use nalgebra::{Rotation3, Vector3};

use super::floor;
use crate::simulator::rng::Stream;
use crate::truth::{OrientedBox, Truth};

/// Bumps strewn over the ground ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bumps {
    /// Their number.
    pub count: usize,
    /// Height of the highest, m.
    pub height_m: f64,
}

/// Little bumps: up to 10 mm on a third of the ground.
pub const LITTLE: Bumps = Bumps {
    count: 34,
    height_m: 0.01,
};
/// Big bumps: up to 30 mm, where \[chai2015\]'s robot lifts its feet by 50 mm at least.
pub const BIG: Bumps = Bumps {
    count: 34,
    height_m: 0.03,
};

/// The area ahead of the robot that bumps lie on, x and y, m.
const AREA_M: [[f64; 2]; 2] = [[0.9, 3.9], [-1.5, 1.5]];

/// The ground at z = 0 with these bumps: slabs of 0.1 to 0.45 m, tilted by a few degrees.
pub fn truth(bumps: Option<Bumps>, seed: u64) -> Truth {
    let mut boxes = vec![floor()];
    if let Some(Bumps { count, height_m }) = bumps {
        let draw = Stream::new(seed, 0);
        boxes.extend((0..count).map(|i| {
            let uniform = |k: usize| draw.uniform((8 * i + k) as u64);
            let [x, y] = [0, 1].map(|k| AREA_M[k][0] + uniform(k) * (AREA_M[k][1] - AREA_M[k][0]));
            let size = [2, 3].map(|k| 0.1 + 0.35 * uniform(k));
            let height = height_m * uniform(4);
            // No steeper than from its own height on one side to none on the other.
            let tilt = |k: usize, edge: f64| (uniform(k) - 0.5) * 2.0 * (height / edge);
            let rotation = Rotation3::from_euler_angles(
                tilt(5, size[1]),
                tilt(6, size[0]),
                std::f64::consts::PI * uniform(7),
            );
            let thickness = 0.1;
            let centre = Vector3::new(x, y, height - 0.5 * thickness);
            OrientedBox::new(
                &format!("bump {}", i + 1),
                centre,
                [size[0], size[1], thickness],
                rotation,
            )
        }));
    }
    Truth {
        scene: "ground".into(),
        boxes,
    }
}
