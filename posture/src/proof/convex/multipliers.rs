//! The multipliers of the convex problem, as proofs are written down.

use nalgebra::UnitQuaternion;
use plan::Multipliers;
use robot_model::JointKind;

use super::Chain;
use crate::outcome::Constraint;

impl Chain<'_> {
    /// What multiplies the conditions that no posture fulfils at once.
    pub(super) fn multipliers(&self, z: &[f64]) -> Multipliers {
        let bodies = &self.ctx.robot().bodies;
        let of = |what: Constraint| self.cones.multipliers(z, |other| *other == what);
        let form = |b: usize| {
            // A body that slides has the rotation of what it slides on.
            let (mut parent, mut R) = (bodies[b].parent, UnitQuaternion::identity());
            while let Some(p) = parent.filter(|&p| bodies[p].kind == JointKind::Prismatic) {
                R = bodies[p].X_PJ.rotation * R;
                parent = bodies[p].parent;
            }
            let free = parent.filter(|&p| self.put[p].is_none());
            let form = free.map(|p| self.cones.turn(z, &self.hinges[b], self.column[p]));
            let form = form.unwrap_or_default() * R.to_rotation_matrix();
            [0, 1, 2].map(|r| [0, 1, 2].map(|c| form[(r, c)]))
        };
        let joints = 1..bodies.len();
        Multipliers {
            places: (0..self.ctx.contacts.len())
                .map(|i| of(Constraint::Closure(i)))
                .collect(),
            force: of(Constraint::Equilibrium),
            moment: of(Constraint::Balance),
            about: self.middle.into(),
            torques: joints
                .clone()
                .map(|b| self.torques[b].map_or(0.0, |row| z[row] - z[row + 1]))
                .collect(),
            turns: joints.map(form).collect(),
        }
    }
}
