//! The dynamics of a phase at one place of its path.

use nalgebra::{Vector3, Vector6};

use super::standing::{relieve, share};
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
    fn resting(&mut self, s: f64) -> Place {
        let robot = self.context.robot;
        let path = self.curve.at(s);
        self.blend(s);
        let at_rest = self.shares.at_rest(&self.still_W);
        let (kinematics, gravity) = (&mut self.kinematics, &mut self.gravity);
        kinematics.update(robot, &path.q);
        kinematics.gravity_torques(robot, gravity);
        let bare = gravity.iter().skip(6).map(|tau| [*tau, 0.0, 0.0]);
        let joints_W =
            (1..robot.bodies.len()).map(|b| [kinematics.axis_W[b], kinematics.origin_W[b]]);
        Place {
            path,
            com_W: kinematics.com_W,
            points_W: self.shares.points_W(kinematics),
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
        let shares = &self.shares;
        let [_, a, b] = place.needs;
        // What leans has no resultant, and the shares make up for what it has.
        let parts = place.at_rest.iter().zip(&place.loads).enumerate();
        let parts = parts.map(|(i, (f, load))| match lean.get(i) {
            Some(part) => [*f, part * a * *load, part * b * *load],
            None => [*f, Vector3::zeros(), Vector3::zeros()],
        });
        place.forces_W.clear();
        place.forces_W.extend(parts);
        let forces_W = &mut place.forces_W;
        let at = (&place.points_W[..], &place.com_W);
        share(shares, &place.loads, at, place.needs, forces_W);
        // What the joints exert for it.
        place.tau.clone_from(&place.bare);
        let (robot, closed) = (self.context.robot, &self.phase.task.closed);
        let joint_W = |body: usize| place.joints_W[body - 1];
        let shares_at = (shares, &place.points_W[..]);
        relieve(robot, closed, shares_at, joint_W, forces_W, &mut place.tau);
    }

    /// Writes the forces of the path at `s`, between those of its samples.
    fn blend(&mut self, s: f64) {
        let samples = &self.phase.samples;
        let at = s * (samples.len() - 1) as f64;
        let i = (at as usize).min(samples.len() - 2);
        let part = at - i as f64;
        let Instance { forces_W: low, .. } = &samples[i];
        let contacts = low.iter().zip(&samples[i + 1].forces_W);
        self.still_W.resize(low.len(), Vec::new());
        for (out, (a, b)) in self.still_W.iter_mut().zip(contacts) {
            out.clear();
            out.extend(a.iter().zip(b).map(|(a, b)| a.lerp(b, part)));
        }
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
