//! The dynamics of a phase at one place of its path.

use nalgebra::{DVector, Vector3, Vector6};
use robot_model::JointKind;

use super::{Lean, Pace, Place, places_before};
use crate::interpolation::Instant;
use crate::sampling::Instance;

impl Pace<'_> {
    /// The dynamics at `s`, where forces lean like this.
    pub(super) fn place(&mut self, s: f64, lean: &Lean) -> Place {
        let mut place = self.going(s);
        self.bear(&mut place, lean);
        place
    }

    /// The dynamics at `s`, borne by nothing yet.
    pub(super) fn going(&mut self, s: f64) -> Place {
        let robot = self.context.robot;
        let mut place = self.resting(s);
        let Instant { v, a, .. } = &place.path;
        let (kinematics, dynamics) = (&self.kinematics, &mut self.dynamics);
        dynamics.update(robot, kinematics, [v.as_slice(), a.as_slice()]);
        place.speed = dynamics.speed;
        place.landing = self.phase.task.swing.as_ref().map(|swing| {
            let patch = &robot.patches[swing.patch];
            let p = kinematics.X_WC(patch).translation.vector;
            let moves = dynamics.point_speed(patch.body, &(p - kinematics.origin_W[patch.body]));
            let lands = self.phase.landed.as_ref();
            let away = lands.map(|c| (p - c.X_WC.translation.vector).norm());
            (moves, away.unwrap_or(f64::INFINITY))
        });
        let needs = dynamics.joint_torques(robot, kinematics, &mut place.bare);
        for (part, (f, m)) in place.needs[1..].iter_mut().zip(needs) {
            let m = m + (kinematics.origin_W[0] - place.com_W).cross(&f);
            *part = Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z);
        }
        place
    }

    /// What is the same at `s` whether it is gone through or not, borne by nothing yet.
    pub(super) fn resting(&mut self, s: f64) -> Place {
        let robot = self.context.robot;
        let path = self.curve.at(s);
        let at_rest = self.shares.at_rest(&self.blended(s));
        let kinematics = &mut self.kinematics;
        kinematics.update(robot, &path.q);
        let mut gravity = DVector::zeros(robot.nv());
        kinematics.gravity_torques(robot, &mut gravity);
        let bare = gravity.iter().skip(6).map(|tau| [*tau, 0.0, 0.0]);
        let joints_W =
            (1..robot.bodies.len()).map(|b| [kinematics.axis_W[b], kinematics.origin_W[b]]);
        Place {
            path,
            com_W: kinematics.com_W,
            needs: [
                Vector6::z() * gravity[2],
                Vector6::zeros(),
                Vector6::zeros(),
            ],
            loads: self.shares.loads(at_rest.iter().copied()),
            at_rest,
            bare: bare.collect(),
            joints_W: joints_W.collect(),
            forces_W: Vec::new(),
            tau: Vec::new(),
            speed: 0.0,
            landing: None,
        }
    }

    /// Lets the forces at a place lean like this.
    pub(super) fn bear(&self, place: &mut Place, lean: &Lean) {
        let (robot, shares, com_W) = (self.context.robot, &self.shares, &place.com_W);
        let [rest, a, b] = place.needs;
        // What leans has no resultant, and the shares make up for what it has.
        let parts = place.at_rest.iter().zip(&place.loads).enumerate();
        place.forces_W.clear();
        place
            .forces_W
            .extend(parts.map(|(i, (f, load))| match lean.get(i) {
                Some(part) => [*f, part * a * *load, part * b * *load],
                None => [*f, Vector3::zeros(), Vector3::zeros()],
            }));
        let has = shares.resultants(com_W, &place.forces_W);
        let needed = [rest - has[0], a - has[1], b - has[2]];
        let weights = shares.weights(&place.loads);
        let shared = shares.shared(&weights, com_W, needed);
        for (forces, shared) in place.forces_W.iter_mut().zip(shared) {
            forces
                .iter_mut()
                .zip(shared)
                .for_each(|(f, share)| *f += share);
        }
        // What the joints exert for it.
        place.tau.clone_from(&place.bare);
        for (number, closed) in self.phase.task.closed.iter().enumerate() {
            let mut wrenches = [(Vector3::zeros(), Vector3::zeros()); 3];
            let own = place.forces_W.iter().zip(&shares.points);
            for (forces, p) in own.filter(|(_, p)| p.contact == number) {
                for ((force, moment), f) in wrenches.iter_mut().zip(forces) {
                    *force += f;
                    *moment += p.p_W.cross(f);
                }
            }
            let mut body = robot.patches[closed.patch].body;
            while let Some(parent) = robot.bodies[body].parent {
                let [axis, origin] = &place.joints_W[body - 1];
                for (tau, (force, moment)) in place.tau[body - 1].iter_mut().zip(&wrenches) {
                    *tau -= match robot.bodies[body].kind {
                        JointKind::Prismatic => axis.dot(force),
                        _ => axis.dot(&(moment - origin.cross(force))),
                    };
                }
                body = parent;
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
    let at = places_before(s, grid.len().max(2) - 1);
    let low = (at as usize).min(grid.len().saturating_sub(2));
    let part = at - low as f64;
    match grid.get(low..low + 2) {
        Some([a, b]) => a.iter().zip(b).map(|(a, b)| a + (b - a) * part).collect(),
        _ => Lean::new(),
    }
}
