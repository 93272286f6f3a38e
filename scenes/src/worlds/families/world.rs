//! A world while it is drawn: numbers from its seed, and boxes.

use nalgebra::{Rotation3, Vector3};

use super::{Build, Drawn};
use crate::simulator::rng::Stream;
use crate::truth::OrientedBox;

/// How deep bodies are under their tops, m.
pub(super) const DEEP_M: f64 = 0.3;

/// A world that is being drawn.
pub(super) struct World {
    /// The robot that it is for.
    pub build: Build,
    draw: Stream,
    drawn: u64,
    boxes: Vec<OrientedBox>,
}

impl World {
    /// Nothing yet.
    pub fn new(build: &Build, seed: u64) -> Self {
        Self {
            build: *build,
            draw: Stream::new(seed, 0),
            drawn: 0,
            boxes: Vec::new(),
        }
    }

    /// A number between two.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.drawn += 1;
        low + (high - low) * self.draw.uniform(self.drawn)
    }

    /// A whole number from `low` to `high`.
    pub fn count(&mut self, low: usize, high: usize) -> usize {
        low + self.between(0.0, (high + 1 - low) as f64) as usize
    }

    /// −1 or 1.
    pub fn side(&mut self) -> f64 {
        if self.between(0.0, 1.0) < 0.5 {
            -1.0
        } else {
            1.0
        }
    }

    /// How far the ground goes on around the start and the goal.
    pub fn around_m(&self) -> f64 {
        0.5 * self.build.stance_m[1] + 0.5
    }

    /// Half the width of a way with room to spare.
    pub fn half_way_m(&self) -> f64 {
        0.5 * self.build.stance_m[0] + 0.5
    }

    /// A box over a rectangle of x and y, from `low_m` to `top_m`.
    pub fn put(&mut self, x: [f64; 2], y: [f64; 2], low_m: f64, top_m: f64) {
        let centre = Vector3::new(x[0] + x[1], y[0] + y[1], low_m + top_m) / 2.0;
        let size = [x[1] - x[0], y[1] - y[0], top_m - low_m];
        self.put_turned(centre, size, Rotation3::identity());
    }

    /// A box at a centre, turned.
    pub fn put_turned(&mut self, centre: Vector3<f64>, size: [f64; 3], rotation: Rotation3<f64>) {
        let name = format!("box {}", self.boxes.len());
        self.boxes
            .push(OrientedBox::new(&name, centre, size, rotation));
    }

    /// Boxes that were drawn before.
    pub fn take(&mut self, boxes: Vec<OrientedBox>) {
        self.boxes = boxes;
    }

    /// A floor at z = 0 from behind the start to beyond `to_x`.
    pub fn floor(&mut self, to_x: f64, half_y: f64) {
        let around = self.around_m();
        self.put([-around, to_x + around], [-half_y, half_y], -DEEP_M, 0.0);
    }

    /// The world, and what is asked in it.
    pub fn done(&mut self, goal_m: [f64; 2], yaw_rad: Option<f64>) -> Drawn {
        Drawn {
            boxes: std::mem::take(&mut self.boxes),
            goal_m,
            yaw_rad,
            friction: None,
        }
    }
}
