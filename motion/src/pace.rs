//! A phase in time: as fast as the robot's limits allow along its path.
//!
//!   q = q(s(t)),  v = q' ṡ,  a = q' s̈ + q'' ṡ²
//!
//! What a body needs, what contacts bear and what joints exert are then constant, linear in s̈ and linear
//! in ṡ²; so is every limit.
#![allow(non_snake_case)]

use nalgebra::{DVector, Vector3, Vector6};
use posture::Contact;
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, pyramid_axes_W};

use crate::config::Config;
use crate::interpolation::{Curve, Instant};
use crate::inverse_dynamics::{Accelerations, BodyForces, joint_torques};
use crate::load_shares::LoadShares;
use crate::problem::MotionContext;
use crate::sampling::Instance;
use crate::segment::PhaseTrajectory;
use crate::spline::Ends;
use crate::time_law::{Row, TimeLaw};

/// Pieces of a path at whose ends its limits are computed.
const PIECES: usize = 64;
/// Part of the distance that the robot is kept clear of things which a body moves between two samples at
/// most.
const STEP_PART: f64 = 0.6;
/// Distance of a patch from its landing at which it moves no faster than it may touch, m: what a scan is
/// off.
const LANDING_M: f64 = 0.015;
/// Part of what a point bears at rest that it bears in motion at least.
const LOAD_KEPT: f64 = 0.1;
/// Smallest room that a limit has, part of it: postures may be on their limits.
const ROOM: f64 = 1e-3;
/// A law that exceeds its limits by no more than this part is kept.
const OVER: f64 = 2e-3;
/// How often a law is sought at most.
const SMOOTHINGS: usize = 8;
/// How a patch slows down on its way to its landing, m/s².
const LANDING_M_S2: f64 = 3.0;

/// The whole body at one sample of a motion.
pub(crate) struct Paced {
    pub q: Configuration,
    pub v: DVector<f64>,
    pub a: DVector<f64>,
    pub tau: Vec<f64>,
    pub com_W: Vector3<f64>,
    /// Force at each force point of each closed contact, N.
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// Whatever is constant, linear in s̈ and linear in ṡ² at one place of a path.
type Parts<T> = [T; 3];

/// The dynamics of a phase at one place of its path.
struct Place {
    path: Instant,
    com_W: Vector3<f64>,
    /// Force at each point, N.
    forces_W: Parts<Vec<Vector3<f64>>>,
    /// Torque of each joint, N·m or N.
    tau: Parts<Vec<f64>>,
    /// How fast each body's centre of mass moves, over ṡ.
    speeds: Vec<f64>,
    /// How fast the patch in the air moves over ṡ, and how far it is from its landing.
    landing: Option<(f64, f64)>,
}

/// A phase whose time is sought.
pub(crate) struct Pace<'a> {
    context: &'a MotionContext<'a>,
    phase: &'a PhaseTrajectory,
    curve: Curve,
    pub shares: LoadShares,
    kinematics: Kinematics,
    accelerations: Accelerations,
}

impl<'a> Pace<'a> {
    pub fn new(context: &'a MotionContext<'a>, phase: &'a PhaseTrajectory) -> Self {
        let samples = phase.samples.iter().map(|sample| &sample.q[..]);
        let step = 1.0 / (phase.samples.len() - 1) as f64;
        let curve = Curve::new(samples, step, Ends::Free);
        Self {
            kinematics: Kinematics::new(context.robot, &curve.at(0.0).q),
            accelerations: Accelerations::new(context.robot),
            shares: LoadShares::new(context, &phase.closed),
            curve,
            context,
            phase,
        }
    }

    /// The samples of the phase, `dt_s` apart, both ends included.
    pub fn samples(&mut self) -> Vec<Paced> {
        let config = self.context.config;
        let grid = (0..=PIECES).map(|i| {
            let place = self.place(i as f64 / PIECES as f64);
            self.rows(&place)
        });
        let grid: Vec<Vec<Row>> = grid.collect();
        // At rest every row has room, so there is one.
        let Some((mut law, mut over)) = smooth(&grid, config) else { return Vec::new() };
        if std::env::var("PACE").is_ok() {
            self.debug(&grid, &law, over);
        }
        let mut samples = Vec::new();
        for _ in 0..4 {
            // Whole steps, and within the limits.
            let time = law.duration_s() * over.max(1.0);
            let steps = (time / config.dt_s - 1e-9).ceil().max(1.0);
            law = law.slower(steps * config.dt_s / law.duration_s());
            samples.clear();
            over = 0.0;
            for i in 0..=steps as usize {
                let [s, rate, bend] = law.at(i as f64 * config.dt_s);
                let place = self.place(s.clamp(0.0, 1.0));
                let rows = self.rows(&place);
                over = over.max(excess(rows.iter().copied(), rate, bend));
                samples.push(self.paced(&place, rate, bend));
            }
            if over <= 1.0 + OVER {
                break;
            }
        }
        samples
    }

    fn debug(&self, grid: &[Vec<Row>], law: &TimeLaw, over: f64) {
        let robot = self.context.robot;
        let nj = robot.nj();
        let mut names: Vec<String> = Vec::new();
        for b in robot.joint_bodies() { names.push(format!("speed {}", b.joint)); }
        for b in &robot.bodies { names.push(format!("step {}", b.name)); }
        if self.phase.swing.is_some() { names.push("swing".to_owned()); }
        for b in robot.joint_bodies() { for _ in 0..2 { names.push(format!("acc {}", b.joint)); } }
        for b in robot.joint_bodies() { if b.effort > 0.0 && b.effort.is_finite() { for _ in 0..2 { names.push(format!("tau {}", b.joint)); } } }
        for (i, p) in self.shares.points.iter().enumerate() {
            let c = &robot.patches[self.phase.closed[p.contact].patch].name;
            names.push(format!("push {c} {i}"));
            for _ in 0..4 { names.push(format!("fric {c} {i}")); }
        }
        assert_eq!(names.len(), grid[0].len(), "{nj}");
        let mut dwell: std::collections::BTreeMap<String, f64> = Default::default();
        let t = law.duration_s();
        let n = 2000;
        for i in 0..n {
            let [s, rate, bend] = law.at(i as f64 * t / n as f64);
            let at = ((s * PIECES as f64).round() as usize).min(PIECES);
            let used: Vec<f64> = grid[at].iter().map(|r| (r.a * bend + r.b * rate * rate) / r.c).collect();
            let k = (0..used.len()).max_by(|a, b| used[*a].total_cmp(&used[*b])).unwrap();
            *dwell.entry(names[k].clone()).or_default() += t / n as f64;
        }
        let mut all: Vec<_> = dwell.into_iter().collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.truncate(7);
        let text: Vec<String> = all.iter().map(|(n, t)| format!("{n} {t:.2}")).collect();
        let swing = self.phase.swing.map(|p| robot.patches[p].name.clone());
        eprintln!("{swing:?} {t:.2} s, over {over:.3}: {}", text.join(", "));
    }

    /// The dynamics at `s`.
    fn place(&mut self, s: f64) -> Place {
        let robot = self.context.robot;
        let path = self.curve.at(s);
        let at_rest = self.shares.at_rest(&self.blended(s));
        let kinematics = &mut self.kinematics;
        kinematics.update(robot, &path.q);
        let (v, a) = (path.v.as_slice(), path.a.as_slice());
        let zero = vec![0.0; v.len()];
        // What every body needs: under gravity at rest, per s̈, per ṡ².
        let mut needs: Parts<BodyForces> = Default::default();
        let states = [(&zero[..], &zero[..], GRAVITY_M_S2), (v, a, 0.0), (&zero[..], v, 0.0)];
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
        let landing = self.phase.swing.map(|patch| {
            let patch = &robot.patches[patch];
            let p = kinematics.X_WC(patch).translation.vector;
            let moves = speed(patch.body, &(p - kinematics.origin_W[patch.body]));
            let lands = self.phase.landed.as_ref();
            let away = lands.map(|c| (p - c.X_WC.translation.vector).norm());
            (moves, away.unwrap_or(f64::INFINITY))
        });
        // What the contacts bear: at rest as the postures have it, and their shares of the rest.
        let com_W = kinematics.com_W;
        let mut resultants = [0, 1, 2].map(|k| {
            let each = needs[k].iter().zip(&kinematics.origin_W);
            each.fold(Vector6::zeros(), |sum: Vector6<f64>, ((f, m), o)| {
                let moment = m + (o - com_W).cross(f);
                sum + Vector6::new(f.x, f.y, f.z, moment.x, moment.y, moment.z)
            })
        });
        for (p, f) in self.shares.points.iter().zip(&at_rest) {
            let moment = (p.p_W - com_W).cross(f);
            resultants[0] -= Vector6::new(f.x, f.y, f.z, moment.x, moment.y, moment.z);
        }
        let mut forces_W = self.shares.shared(&at_rest, &com_W, resultants);
        for (sum, rest) in forces_W[0].iter_mut().zip(at_rest) {
            *sum += rest;
        }
        // What the joints exert for it.
        let tau = [0, 1, 2].map(|k| {
            let needs = &mut needs[k];
            for (p, f) in self.shares.points.iter().zip(&forces_W[k]) {
                let body = robot.patches[self.phase.closed[p.contact].patch].body;
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

    /// Every limit at one place; as many at every place of the path.
    fn rows(&self, place: &Place) -> Vec<Row> {
        let (robot, config) = (self.context.robot, self.context.config);
        let mut rows = Vec::with_capacity(300);
        let mut square = |speed: f64, limit: f64| {
            let b = if limit > 0.0 && limit.is_finite() { (speed / limit).powi(2) } else { 0.0 };
            rows.push(Row { a: 0.0, b, c: 1.0 });
        };
        // Speeds: of joints, of bodies between two samples, of the patch in the air.
        let (v, a) = (&place.path.v.as_slice()[6..], &place.path.a.as_slice()[6..]);
        for (v, body) in v.iter().zip(robot.joint_bodies()) {
            square(*v, body.velocity * config.joint_speed_use);
        }
        let step_m = STEP_PART * self.context.posture.clearance_m;
        for speed in &place.speeds {
            square(*speed, step_m / config.dt_s);
        }
        if let Some((speed, away)) = place.landing {
            let slows = 2.0 * LANDING_M_S2 * (away - LANDING_M).max(0.0);
            let limit = (config.landing_speed_m_s.powi(2) + slows).sqrt();
            square(speed, limit.min(config.swing_speed_m_s));
        }
        let mut both = |parts: [f64; 3], limit: f64| {
            let (most, least) = (limit - parts[0], limit + parts[0]);
            let room = |c: f64| c.max(ROOM * limit);
            let [_, a, b] = parts;
            rows.push(Row { a, b, c: room(most) });
            rows.push(Row { a: -a, b: -b, c: room(least) });
        };
        // Accelerations and torques of joints.
        for (v, a) in v.iter().zip(a) {
            both([0.0, *v, *a], config.joint_acceleration_rad_s2);
        }
        let torque_use = config.torque_use.max(self.context.posture.torque_use);
        for (j, body) in robot.joint_bodies().iter().enumerate() {
            let limit = body.effort * torque_use;
            if limit > 0.0 && limit.is_finite() {
                both([0, 1, 2].map(|k| place.tau[k][j]), limit);
            }
        }
        // Forces push, inside the pyramid of their contact.
        let friction_use = config.friction_use.max(self.context.posture.friction_use);
        for (i, point) in self.shares.points.iter().enumerate() {
            let contact = &self.phase.closed[point.contact];
            let axes = axes(self.context, contact);
            let parts = [0, 1, 2].map(|k| axes.tr_mul(&place.forces_W[k][i]));
            let n = parts.map(|f| f.z);
            let mu = contact.friction * friction_use * std::f64::consts::FRAC_1_SQRT_2;
            let mut least = |along: [f64; 3], kept: f64| {
                let c = along[0] - kept;
                let row = Row { a: -along[1], b: -along[2], c };
                // A point that bears nothing takes nothing.
                let bears = n[0] > UNLOADED_N;
                rows.push(if bears { Row { c: c.max(ROOM * mu * n[0]), ..row } } else { FREE });
            };
            least(n, LOAD_KEPT * n[0]);
            for side in [0, 1] {
                for sign in [1.0, -1.0] {
                    least([0, 1, 2].map(|k| mu * n[k] + sign * parts[k][side]), 0.0);
                }
            }
        }
        rows
    }

    fn paced(&self, place: &Place, rate: f64, bend: f64) -> Paced {
        let square = rate * rate;
        let path = &place.path;
        let mut forces_W = vec![Vec::new(); self.phase.closed.len()];
        for (i, point) in self.shares.points.iter().enumerate() {
            let [rest, a, b] = [0, 1, 2].map(|k| place.forces_W[k][i]);
            forces_W[point.contact].push(rest + a * bend + b * square);
        }
        let tau = (0..place.tau[0].len()).map(|j| {
            let [rest, a, b] = [0, 1, 2].map(|k| place.tau[k][j]);
            rest + a * bend + b * square
        });
        Paced {
            q: path.q.clone(),
            v: &path.v * rate,
            a: &path.v * bend + &path.a * square,
            tau: tau.collect(),
            com_W: place.com_W,
            forces_W,
        }
    }
}

/// A limit that binds nothing.
const FREE: Row = Row { a: 0.0, b: 0.0, c: 1.0 };
/// A point that bears less at rest takes nothing, N.
const UNLOADED_N: f64 = 1e-3;

/// The axes of a contact's friction pyramid, in W, as the postures have them.
fn axes(context: &MotionContext, contact: &Contact) -> nalgebra::Matrix3<f64> {
    let axes = contact.X_WC.rotation.to_rotation_matrix().into_inner();
    match context.robot.patches[contact.patch].point_radius_m() {
        Some(_) => pyramid_axes_W(&axes),
        None => axes,
    }
}

/// How much slower a law has to be for its limits: an acceleration falls with the square of that.
fn excess(rows: impl Iterator<Item = Row>, rate: f64, bend: f64) -> f64 {
    let used = rows.map(|r| (r.a * bend + r.b * rate * rate) / r.c);
    used.fold(0.0, f64::max).sqrt()
}

/// The fastest smooth law, and how much slower it has still to be: where the mean over time exceeds a
/// limit, the limits from which it came are drawn in, and the law is sought again.
fn smooth(grid: &[Vec<Row>], config: &Config) -> Option<(TimeLaw, f64)> {
    let mut limits = grid.to_vec();
    let mut best: Option<(TimeLaw, f64)> = None;
    for _ in 0..SMOOTHINGS {
        let law = TimeLaw::fastest(&limits, config.smooth_s)?;
        let used = interpolated(grid, &law, config.dt_s);
        let over = used.iter().fold(0.0, |a: f64, (_, over)| a.max(*over));
        let time = |law: &TimeLaw, over: f64| law.duration_s() * over.max(1.0);
        if best.as_ref().is_none_or(|(b, o)| time(&law, over) < time(b, *o)) {
            best = Some((law, over));
        }
        if over <= 1.0 + OVER {
            break;
        }
        let mut drawn = vec![1.0_f64; grid.len()];
        for ([from, to], over) in used {
            for k in drawn[from..=to].iter_mut() {
                *k = k.max(over * over);
            }
        }
        for (rows, k) in limits.iter_mut().zip(drawn) {
            rows.iter_mut().for_each(|row| row.c /= k);
        }
    }
    best
}

/// The excess at every sample of a law, by limits between those of the grid, and the first and last
/// places of the grid from which the mean comes.
fn interpolated(grid: &[Vec<Row>], law: &TimeLaw, dt_s: f64) -> Vec<([usize; 2], f64)> {
    let steps = (law.duration_s() / dt_s).ceil() as usize;
    let over = (0..=steps).map(|i| {
        let t = i as f64 * dt_s;
        let [s, rate, bend] = law.at(t);
        let at = s.clamp(0.0, 1.0) * PIECES as f64;
        let low = (at as usize).min(PIECES - 1);
        let part = at - low as f64;
        let span = law.span(t).map(|s| s * PIECES as f64);
        let span = [span[0].floor() as usize, (span[1].ceil() as usize).min(PIECES)];
        let mix = |a: f64, b: f64| a + part * (b - a);
        let rows = grid[low].iter().zip(&grid[low + 1]).map(|(r, n)| Row {
            a: mix(r.a, n.a),
            b: mix(r.b, n.b),
            c: mix(r.c, n.c),
        });
        (span, excess(rows, rate, bend))
    });
    over.collect()
}
