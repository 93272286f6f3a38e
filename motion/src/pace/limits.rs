//! Every limit of a phase at one place of its path.

use nalgebra::Vector3;
use posture::Contact;
use robot_model::pyramid_axes_W;

use super::smoothing::binding;
use super::standing::uses;
use super::{CONE_INSIDE, Pace, Parts, Place, UNLOADED_N};
use crate::problem::MotionContext;
use crate::time_law::Row;

/// Part of the distance that the robot is kept clear of things which a body moves between two samples at
/// most.
const STEP_PART: f64 = 0.9;
/// Distance of a patch from its landing at which it moves no faster than it may touch, m: what a scan is
/// off.
const LANDING_M: f64 = 0.015;
/// Part of what a point bears at rest that it bears in motion at least.
const LOAD_KEPT: f64 = 0.1;
/// Part of the friction that motions use, as much as a controller counts on, and what they may use over what it
/// takes to rest where that is more.
const USUAL: f64 = 0.7;
const TO_MOVE: f64 = 1.25;
/// Smallest room that a limit has, part of it: postures may be on their limits.
const ROOM: f64 = 1e-3;
/// How a patch slows down on its way to its landing, m/s².
const LANDING_M_S2: f64 = 5.0;

/// Normals of the eight sides of a friction cone, and the part of its width that is inside of them.
const CONE_SIDES: [[f64; 2]; 8] = {
    let (c, s) = (CONE_INSIDE, 0.382_683_432_365_089_8);
    [
        [c, s],
        [s, c],
        [-s, c],
        [-c, s],
        [-c, -s],
        [-s, -c],
        [s, -c],
        [c, -s],
    ]
};

impl Pace<'_> {
    /// The limits that bind at a place; `memory` is for all of them.
    pub(super) fn limits(&self, place: &Place, memory: &mut Vec<Row>) -> Vec<Row> {
        memory.clear();
        self.rows(place, memory);
        binding(memory)
    }

    /// Appends every limit at one place.
    pub(super) fn rows(&self, place: &Place, rows: &mut Vec<Row>) {
        let (robot, config) = (self.context.robot, self.context.config);
        // Speeds, of which the one nearest to its limit binds: of joints, of bodies between two samples, of the
        // patch in the air.
        let mut used = 0.0_f64;
        let mut speed = |speed: f64, limit: f64| {
            if limit > 0.0 && limit.is_finite() {
                used = used.max((speed / limit).abs());
            }
        };
        let (v, a) = (&place.path.v.as_slice()[6..], &place.path.a.as_slice()[6..]);
        for (v, body) in v.iter().zip(robot.joint_bodies()) {
            speed(*v, body.velocity * config.joint_speed_use);
        }
        let step_m = STEP_PART * self.context.posture.clearance_m;
        speed(place.speed, step_m / config.dt_s);
        if let Some((moves, away)) = place.landing {
            let slows = 2.0 * LANDING_M_S2 * (away - LANDING_M).max(0.0);
            let limit = (config.landing_speed_m_s.powi(2) + slows).sqrt();
            speed(moves, limit.min(config.swing_speed_m_s));
        }
        let b = used * used;
        rows.push(Row { a: 0.0, b, c: 1.0 });
        let mut both = |[rest, a, b]: Parts<f64>, limit: f64| {
            let room = |c: f64| c.max(ROOM * limit);
            let (most, least) = (room(limit - rest), room(limit + rest));
            rows.push(Row { a, b, c: most });
            let (a, b) = (-a, -b);
            rows.push(Row { a, b, c: least });
        };
        // Accelerations and torques of joints.
        for (v, a) in v.iter().zip(a) {
            both([0.0, *v, *a], config.joint_acceleration_rad_s2);
        }
        let (_, torque_use) = uses(self.context);
        for (tau, body) in place.tau.iter().zip(robot.joint_bodies()) {
            let limit = body.effort * torque_use;
            if limit > 0.0 && limit.is_finite() {
                both(*tau, limit);
            }
        }
        self.bearing(place.forces_W.iter().copied(), |row| rows.push(row));
    }

    /// Forces push, inside eight sides of their contact's cone whose edges are on it.
    pub(super) fn bearing(
        &self,
        forces_W: impl Iterator<Item = Parts<Vector3<f64>>>,
        mut limit: impl FnMut(Row),
    ) {
        let (friction_use, _) = uses(self.context);
        for (forces_W, point) in forces_W.zip(&self.shares.points) {
            let contact = &self.phase.task.closed[point.contact];
            let axes = &self.cone_axes[point.contact];
            let parts = forces_W.map(|f| axes.tr_mul(&f));
            let n = parts.map(|f| f.z);
            // A point that bears nothing takes nothing.
            if n[0] <= UNLOADED_N {
                continue;
            }
            // No more than floors keep that are wet or dusty, unless rest takes nearly as much.
            let rest = parts[0].xy().norm() / (contact.friction * n[0]);
            let most = (rest * TO_MOVE).clamp(USUAL.min(friction_use), friction_use);
            let mu = contact.friction * most;
            let mut least = |[rest, a, b]: Parts<f64>, kept: f64| {
                let c = (rest - kept).max(ROOM * mu * n[0]);
                let (a, b) = (-a, -b);
                limit(Row { a, b, c });
            };
            least(n, LOAD_KEPT * n[0]);
            for [x, y] in CONE_SIDES {
                let across = |f: &Vector3<f64>| x * f.x + y * f.y;
                least(parts.map(|f| CONE_INSIDE * mu * f.z - across(&f)), 0.0);
            }
        }
    }
}

/// The axes along which the sides of a contact's cone stand, in W. Eight sides of nine tenths of the
/// friction hold all of the postures' cone of eight tenths, however these stand.
pub(super) fn cone_axes(context: &MotionContext, contact: &Contact) -> nalgebra::Matrix3<f64> {
    let axes = contact.X_WC.rotation.to_rotation_matrix().into_inner();
    match context.robot.patches[contact.patch].point_radius_m() {
        Some(_) => pyramid_axes_W(&axes, &-Vector3::z()),
        None => axes,
    }
}
