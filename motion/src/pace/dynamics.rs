//! The dynamics of a phase at one place of its path.

use nalgebra::{DVector, Vector3, Vector6};
use robot_model::JointKind;

use super::{Lean, Pace, Place};
use crate::inverse_dynamics::{BodyForces, joint_torques};
use crate::sampling::Instance;

impl Pace<'_> {
    /// The dynamics at `s`, where forces lean like this.
    pub(super) fn place(&mut self, s: f64, lean: &Lean) -> Place {
        let robot = self.context.robot;
        let path = self.curve.at(s);
        let at_rest = self.shares.at_rest(&self.blended(s));
        let kinematics = &mut self.kinematics;
        kinematics.update(robot, &path.q);
        let (v, a) = (path.v.as_slice(), path.a.as_slice());
        let zero = vec![0.0; v.len()];
        // What every body needs per s̈ and per ṡ², in this order, so that the accelerations left are the
        // velocities over ṡ.
        let accelerations = &mut self.accelerations;
        accelerations.update(robot, kinematics);
        let mut needs: [BodyForces; 2] = Default::default();
        for (k, (v, a)) in [(1, (v, a)), (0, (&zero[..], v))] {
            accelerations.forces(robot, kinematics, (v, a), &mut needs[k]);
        }
        let speed = |body, r: &Vector3<f64>| accelerations.point(body, r).norm();
        let speeds = accelerations.of_masses().map(|v| v.norm()).collect();
        let landing = self.phase.task.swing.as_ref().map(|swing| {
            let patch = &robot.patches[swing.patch];
            let p = kinematics.X_WC(patch).translation.vector;
            let moves = speed(patch.body, &(p - kinematics.origin_W[patch.body]));
            let lands = self.phase.landed.as_ref();
            let away = lands.map(|c| (p - c.X_WC.translation.vector).norm());
            (moves, away.unwrap_or(f64::INFINITY))
        });
        // What the joints would exert if nothing were touched, and what is needed altogether.
        let com_W = kinematics.com_W;
        let mut gravity = DVector::zeros(robot.nv());
        kinematics.gravity_torques(robot, &mut gravity);
        let [a, b] = needs.each_mut().map(|needs| {
            let mut tau = vec![0.0; robot.nj()];
            joint_torques(robot, kinematics, needs, &mut tau);
            let (f, m) = needs[0];
            let m = m + (kinematics.origin_W[0] - com_W).cross(&f);
            (tau, Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z))
        });
        let bare = [gravity.as_slice()[6..].to_vec(), a.0, b.0];
        let weight = Vector6::z() * gravity[2];
        let joints_W =
            (1..robot.bodies.len()).map(|b| [kinematics.axis_W[b], kinematics.origin_W[b]]);
        let mut place = Place {
            path,
            com_W,
            needs: [weight, a.1, b.1],
            loads: self.shares.loads(&at_rest),
            at_rest,
            joints_W: joints_W.collect(),
            forces_W: Default::default(),
            tau: bare.clone(),
            bare,
            speeds,
            landing,
        };
        self.bear(&mut place, lean);
        place
    }

    /// Lets the forces at a place lean like this.
    pub(super) fn bear(&self, place: &mut Place, lean: &Lean) {
        let (robot, shares, com_W) = (self.context.robot, &self.shares, &place.com_W);
        let [rest, a, b] = place.needs;
        // What leans has no resultant, and the shares make up for what it has.
        let leaning = [a, b].map(|w| {
            let parts = lean.iter().zip(&place.loads);
            parts
                .map(|(part, load)| part * w * *load)
                .collect::<Vec<_>>()
        });
        let left = [0, 1].map(|k| shares.resultant(com_W, &leaning[k]));
        let unborne = rest - shares.resultant(com_W, &place.at_rest);
        let needed = [unborne, a - left[0], b - left[1]];
        let weights = shares.weights(&place.loads);
        place.forces_W = shares.shared(&weights, com_W, needed);
        let off = [&place.at_rest, &leaning[0], &leaning[1]];
        for (forces, off) in place.forces_W.iter_mut().zip(off) {
            forces.iter_mut().zip(off).for_each(|(f, off)| *f += off);
        }
        // What the joints exert for it.
        for (k, tau) in place.tau.iter_mut().enumerate() {
            tau.copy_from_slice(&place.bare[k]);
            for (number, closed) in self.phase.task.closed.iter().enumerate() {
                let forces = place.forces_W[k].iter().zip(&shares.points);
                let own = forces.filter(|(_, p)| p.contact == number);
                let (force, moment) = own
                    .fold((Vector3::zeros(), Vector3::zeros()), |sum, (f, p)| {
                        (sum.0 + f, sum.1 + p.p_W.cross(f))
                    });
                let mut body = robot.patches[closed.patch].body;
                while let Some(parent) = robot.bodies[body].parent {
                    let [axis, origin] = &place.joints_W[body - 1];
                    tau[body - 1] -= match robot.bodies[body].kind {
                        JointKind::Prismatic => axis.dot(&force),
                        _ => axis.dot(&(moment - origin.cross(&force))),
                    };
                    body = parent;
                }
            }
        }
    }

    /// The forces of the path at `s`, between those of its samples.
    fn blended(&self, s: f64) -> Vec<Vec<Vector3<f64>>> {
        let samples = &self.phase.samples;
        let at = s * (samples.len() - 1) as f64;
        let i = (at as usize).min(samples.len() - 2);
        let part = at - i as f64;
        let Instance { forces_W: low, .. } = &samples[i];
        let contacts = low.iter().zip(&samples[i + 1].forces_W);
        let mix = |(a, b): (&Vec<Vector3<f64>>, &Vec<Vector3<f64>>)| {
            a.iter().zip(b).map(|(a, b)| a.lerp(b, part)).collect()
        };
        contacts.map(mix).collect()
    }
}

/// That at `s`, between those of the grid; none where there is no grid.
pub(super) fn between(grid: &[Lean], s: f64) -> Lean {
    let at = s * (grid.len().max(2) - 1) as f64;
    let low = (at as usize).min(grid.len().saturating_sub(2));
    let part = at - low as f64;
    match grid.get(low..low + 2) {
        Some([a, b]) => a.iter().zip(b).map(|(a, b)| a + (b - a) * part).collect(),
        _ => Lean::new(),
    }
}
