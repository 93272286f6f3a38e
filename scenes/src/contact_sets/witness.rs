//! What makes a configuration the proof that its problem has a solution.
//!
//! It keeps more than the margins of the posture generator that the problems are for, so that a solver
//! which keeps those can find this very posture.

use nalgebra::Vector2;
use robot_model::collision::{BodyShape, World};
use robot_model::{Configuration, Kinematics};

use super::Maker;
use super::forces::{self, Support};
use super::place::Touch;

/// Margins of the posture generator that problems are drawn for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Part of the friction coefficient that forces may use.
    pub friction_use: f64,
    /// Part of the torque limits that holding the posture may use.
    pub torque_use: f64,
    /// Distance of joints from their limits, rad or m.
    pub joint_margin_rad: f64,
    /// Distance between parts of the robot, m.
    pub self_clearance_m: f64,
    /// Distance to bodies that are not touched, m.
    pub clearance_m: f64,
    /// By how much patches are shrunk where forces act, m.
    pub com_margin_m: f64,
}

impl Margins {
    /// What a witness keeps of them: a little more of each.
    pub(super) fn of_a_witness(self) -> Self {
        Self {
            friction_use: 0.94 * self.friction_use,
            torque_use: 0.94 * self.torque_use,
            joint_margin_rad: self.joint_margin_rad + 0.02,
            self_clearance_m: self.self_clearance_m + 0.003,
            clearance_m: self.clearance_m + 0.005,
            com_margin_m: self.com_margin_m + 0.003,
        }
    }
}

impl Maker<'_> {
    /// Whether the robot is clear of itself and holds itself with forces at these places.
    pub fn holds(&self, q: &Configuration, touches: &[Touch], mu: f64) -> bool {
        if !self.is_clear_of_itself(q, self.margins.self_clearance_m) {
            return false;
        }
        let mut supports = self.supports(touches, self.margins.com_margin_m);
        self.load_balls(&mut supports);
        let mu = self.margins.friction_use * mu;
        // The cheap question first: can these contacts carry a weight at all?
        forces::carry_somewhere(&supports, mu, forces::Pyramid::Inscribed) == Some(true)
            && forces::hold(self.robot, q, &supports, mu, self.margins.torque_use)
    }

    /// Has balls that alone carry the robot, on faces of less than 45°, each bear a part ε of the weight:
    /// a point cannot be shrunk, and the centre of mass may move by the margin m where
    ///
    ///   ε = m / min over the hull's edges of Σ (distance of the points from the edge)
    fn load_balls(&self, supports: &mut [Support]) {
        let alone = |s: &Support| s.points_W.len() == 1 && s.axes[(2, 2)] >= 0.7;
        if !supports.iter().all(alone) {
            return;
        }
        let places: Vec<Vector2<f64>> = supports.iter().map(|s| s.points_W[0].xy()).collect();
        let pairs = places
            .iter()
            .flat_map(|a| places.iter().map(move |b| (a, b)));
        let width_m = pairs.filter_map(|(a, b)| {
            let along = (b - a).try_normalize(1e-9)?;
            let beside: Vec<f64> = places.iter().map(|p| along.perp(&(p - a))).collect();
            // An edge has every point on its left.
            let is_edge = beside.iter().all(|d| *d >= -1e-9);
            is_edge.then(|| beside.iter().sum::<f64>())
        });
        let width_m = width_m.fold(f64::INFINITY, f64::min);
        for support in supports {
            support.least_load = self.margins.com_margin_m / width_m.max(1e-9);
        }
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
        let (collision, keeps) = (&self.robot.collision, self.margins.clearance_m);
        let mut near = Vec::new();
        collision.world_proximities(&kinematics, world, keeps, &touched, &mut near);
        near.iter().all(|pair| pair.distance >= keeps)
    }
}
