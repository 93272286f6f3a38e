//! The dynamics of a phase at one place of its path.

use nalgebra::{Vector3, Vector6};
use robot_model::GRAVITY_M_S2;

use super::{Lean, Pace, Parts, Place};
use crate::inverse_dynamics::{BodyForces, joint_torques};
use crate::sampling::Instance;

impl Pace<'_> {
    /// The dynamics at `s`, where forces lean as at the places of the grid, or not at all.
    pub(super) fn place(&mut self, s: f64, leans: &[Lean]) -> Place {
        let robot = self.context.robot;
        let path = self.curve.at(s);
        let at_rest = self.shares.at_rest(&self.blended(s));
        let kinematics = &mut self.kinematics;
        kinematics.update(robot, &path.q);
        let (v, a) = (path.v.as_slice(), path.a.as_slice());
        let zero = vec![0.0; v.len()];
        // What every body needs: under gravity at rest, per s̈, per ṡ².
        let mut needs: Parts<BodyForces> = Default::default();
        let states = [
            (&zero[..], &zero[..], GRAVITY_M_S2),
            (v, a, 0.0),
            (&zero[..], v, 0.0),
        ];
        // In this order, so that the accelerations left are the velocities over ṡ.
        for (k, (v, a, g)) in [0, 2, 1].into_iter().zip(states) {
            let out = &mut needs[k];
            self.accelerations.forces(robot, kinematics, (v, a), g, out);
        }
        let accelerations = &self.accelerations;
        let coms = robot.bodies.iter().zip(&kinematics.X_WB).enumerate();
        let speed = |body, r: &Vector3<f64>| accelerations.point(body, r).norm();
        let speeds = coms.map(|(i, (body, X_WB))| speed(i, &(X_WB.rotation * body.com_B)));
        let speeds = speeds.collect();
        let landing = self.phase.task.swing.as_ref().map(|swing| {
            let patch = &robot.patches[swing.patch];
            let p = kinematics.X_WC(patch).translation.vector;
            let moves = speed(patch.body, &(p - kinematics.origin_W[patch.body]));
            let lands = self.phase.landed.as_ref();
            let away = lands.map(|c| (p - c.X_WC.translation.vector).norm());
            (moves, away.unwrap_or(f64::INFINITY))
        });
        // What the contacts bear: at rest as the postures have it, and their shares of the rest.
        let com_W = kinematics.com_W;
        let resultants = [0, 1, 2].map(|k| {
            let each = needs[k].iter().zip(&kinematics.origin_W);
            each.fold(Vector6::zeros(), |sum: Vector6<f64>, ((f, m), o)| {
                let moment = m + (o - com_W).cross(f);
                sum + Vector6::new(f.x, f.y, f.z, moment.x, moment.y, moment.z)
            })
        });
        let [rest, a, b] = resultants;
        let weights = self.shares.weights(&at_rest);
        // What leans has no resultant, and the shares make up for what it has.
        let lean = between(leans, s);
        let leaning = [a, b].map(|w| lean.iter().map(|part| part * w).collect::<Vec<_>>());
        let left = [0, 1].map(|k| self.shares.resultant(&com_W, &leaning[k]));
        let unborne = rest - self.shares.resultant(&com_W, &at_rest);
        let shared = [unborne, a - left[0], b - left[1]];
        let mut forces_W = self.shares.shared(&weights, &com_W, shared);
        for (forces, off) in forces_W
            .iter_mut()
            .zip([&at_rest, &leaning[0], &leaning[1]])
        {
            forces.iter_mut().zip(off).for_each(|(f, off)| *f += off);
        }
        // What the joints exert for it.
        let tau = [0, 1, 2].map(|k| {
            let needs = &mut needs[k];
            for (p, f) in self.shares.points.iter().zip(&forces_W[k]) {
                let body = robot.patches[self.phase.task.closed[p.contact].patch].body;
                needs[body].0 -= f;
                needs[body].1 -= (p.p_W - kinematics.origin_W[body]).cross(f);
            }
            let mut tau = vec![0.0; robot.nj()];
            joint_torques(robot, kinematics, needs, &mut tau);
            tau
        });
        Place {
            path,
            com_W,
            needs: resultants,
            weights,
            forces_W,
            tau,
            speeds,
            landing,
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
fn between(grid: &[Lean], s: f64) -> Lean {
    let at = s * (grid.len().max(2) - 1) as f64;
    let low = (at as usize).min(grid.len().saturating_sub(2));
    let part = at - low as f64;
    match grid.get(low..low + 2) {
        Some([a, b]) => a.iter().zip(b).map(|(a, b)| a + (b - a) * part).collect(),
        _ => Lean::new(),
    }
}
