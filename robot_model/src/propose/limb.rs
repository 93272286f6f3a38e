//! A limb: a chain of bodies from the trunk outward.

use crate::load::sampled;
use crate::{Configuration, Robot};

/// What a limb is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimbKind {
    /// It carries the robot.
    Leg,
    /// It does not reach the ground that the legs stand on.
    Arm,
}

/// A chain of bodies that branches off the trunk.
#[derive(Clone, Debug, PartialEq)]
pub struct Limb {
    /// Leg or arm.
    pub kind: LimbKind,
    /// Its bodies from the trunk outward, each the child of the one before; fingers are left out.
    pub bodies: Vec<usize>,
    /// The limb on the other side.
    pub mirror: Option<usize>,
    /// Side by side and one behind the other: the place in words, `left`, `front_right`.
    pub place: String,
    /// Distance along the chain from its first joint to its end, m.
    pub length_m: f64,
}

impl Limb {
    /// The last body.
    pub fn end(&self) -> usize {
        *self.bodies.last().unwrap_or(&0)
    }

    /// The indices of its joints.
    pub fn joints(&self) -> impl Iterator<Item = usize> + '_ {
        self.bodies.iter().map(|body| body - 1)
    }

    /// `q`, and `q` with the limb's joints drawn.
    pub fn starts(
        &self,
        robot: &Robot,
        q: &Configuration,
        count: u64,
    ) -> impl Iterator<Item = Configuration> {
        (0..count).map(|number| {
            let mut start = q.clone();
            if number > 0 {
                let drawn = sampled(robot, number);
                self.joints()
                    .for_each(|j| start.joints[j] = drawn.joints[j]);
            }
            start
        })
    }
}
