//! What makes a configuration the proof that its problem has a solution.
//!
//! Every margin is wider than the planner's default, so that a solver which keeps those defaults
//! can find this very posture.

use robot_model::collision::{BodyShape, World};
use robot_model::{Configuration, Kinematics};

use super::Maker;
use super::forces;
use super::place::Touch;

/// Part of the friction coefficient that the forces may use; the planner's is 0.8.
pub(super) const FRICTION_USE: f64 = 0.75;
/// Part of the torque limits; the planner's is 0.8.
const TORQUE_USE: f64 = 0.75;
/// Distance between parts of the robot, m; the planner's is 0.005.
const SELF_CLEARANCE_M: f64 = 0.008;
/// Distance to bodies that are not touched, m; the planner's is 0.010.
const CLEARANCE_M: f64 = 0.015;
/// By how much patches are shrunk where forces act, m, and at most which part of their half
/// width; the planner's are 0.030 and 0.6.
pub(super) const INSET: (f64, f64) = (0.033, 0.65);

impl Maker<'_> {
    /// Whether the robot is clear of itself and holds itself with forces at these places.
    pub fn holds(&self, q: &Configuration, touches: &[Touch], mu: f64) -> bool {
        if !self.is_clear_of_itself(q, SELF_CLEARANCE_M) {
            return false;
        }
        let supports = self.supports(touches, INSET.0, INSET.1);
        let mu = FRICTION_USE * mu;
        // The cheap question first: can these contacts carry a weight at all?
        forces::carry_somewhere(&supports, mu, forces::Pyramid::Inscribed) == Some(true)
            && forces::hold(self.robot, q, &supports, mu, TORQUE_USE)
    }

    /// Whether no two watched parts are nearer than `clearance_m`.
    pub fn is_clear_of_itself(&self, q: &Configuration, clearance_m: f64) -> bool {
        let kinematics = Kinematics::new(self.robot, q);
        let mut near = Vec::new();
        let collision = &self.robot.collision;
        collision.self_proximities(&kinematics, clearance_m, &mut near);
        near.iter().all(|pair| pair.distance >= clearance_m)
    }

    /// Whether the robot is clear of every body, each touching body's own support excepted: body
    /// k of the world is that of touch k.
    pub fn is_clear_of(&self, world: &World, q: &Configuration, touches: &[Touch]) -> bool {
        let kinematics = Kinematics::new(self.robot, q);
        let body = |touch: &Touch| self.robot.patches[touch.limb.patch].body;
        let touched = |shape: BodyShape, obstacle: usize| {
            let touch = touches.get(obstacle);
            touch.is_some_and(|touch| body(touch) == shape.body)
        };
        let mut near = Vec::new();
        let collision = &self.robot.collision;
        collision.world_proximities(&kinematics, world, CLEARANCE_M, &touched, &mut near);
        near.iter().all(|pair| pair.distance >= CLEARANCE_M)
    }
}
