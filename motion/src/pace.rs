//! A phase in time: as fast as the robot's limits allow along its path.
//!
//!   q = q(s(t)),  v = q' ṡ,  a = q' s̈ + q'' ṡ²
//!
//! What a body needs, what contacts bear and what joints exert are then constant, linear in s̈ and linear
//! in ṡ²; so is every limit.
#![allow(non_snake_case)]

use nalgebra::{DVector, Matrix3x6, Vector3, Vector6};
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

/// Largest number of places of a path at which its limits are computed: those of its samples, between
/// which they are smooth, where these are no more.
const PIECES_MAX: usize = 160;
/// Part of the distance that the robot is kept clear of things which a body moves between two samples at
/// most.
const STEP_PART: f64 = 0.9;
/// How often the forces are suited to the law that came of the last ones, the part of the time from which
/// on that is worth going on, and for how much more than that law needs.
const PASSES: usize = 6;
const WORTH: f64 = 0.98;
const FARTHER: f64 = 1.5;
/// Part of the weight below which what is needed has no direction.
const SLIGHT: f64 = 0.01;
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
/// How often a law is made slower until every sample is within its limits.
const STRETCHES: usize = 10;
/// How a patch slows down on its way to its landing, m/s².
const LANDING_M_S2: f64 = 5.0;

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
    /// Force and moment about the centre of mass that are needed, N and N·m.
    needs: Parts<Vector6<f64>>,
    /// How much each point takes of what is needed beyond rest.
    weights: Vec<f64>,
    /// Force at each point, N.
    forces_W: Parts<Vec<Vector3<f64>>>,
    /// Torque of each joint, N·m or N.
    tau: Parts<Vec<f64>>,
    /// How fast each body's centre of mass moves, over ṡ.
    speeds: Vec<f64>,
    /// How fast the patch in the air moves over ṡ, and how far it is from its landing.
    landing: Option<(f64, f64)>,
}

/// Forces of the points without a resultant, linear in what is needed beyond rest, so that contacts bear
/// it better than by their shares alone.
type Lean = Vec<Matrix3x6<f64>>;

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
        let pieces = (self.phase.samples.len() - 1).min(PIECES_MAX);
        // The fastest law, by forces that suit the one before it.
        let mut best: Option<(TimeLaw, f64, Vec<Lean>)> = None;
        let mut leans = Vec::new();
        for _ in 0..PASSES {
            let places = (0..=pieces).map(|i| self.place(i as f64 / pieces as f64, &leans));
            let places: Vec<Place> = places.collect();
            let grid: Vec<Vec<Row>> = places.iter().map(|place| self.rows(place)).collect();
            // At rest every row has room, so there is one.
            let Some((law, over)) = smooth(&grid, config) else {
                break;
            };
            let time = law.duration_s() * over.max(1.0);
            let before = best
                .as_ref()
                .map(|(law, over, _)| law.duration_s() * over.max(1.0));
            if before.is_some_and(|before| time >= before) {
                break;
            }
            let next = places.iter().enumerate().map(|(i, place)| {
                let [_, rate, bend] = law.at(law.time_s(i as f64 / pieces as f64));
                self.lean(place, rate, bend)
            });
            let next = next.collect();
            best = Some((law, over, std::mem::replace(&mut leans, next)));
            if before.is_some_and(|before| time > WORTH * before) {
                break;
            }
        }
        let Some((mut law, mut over, leans)) = best else {
            return Vec::new();
        };
        let mut samples = Vec::new();
        for _ in 0..STRETCHES {
            // Whole steps, and within the limits.
            let time = law.duration_s() * over.max(1.0);
            let steps = (time / config.dt_s - 1e-9).ceil().max(1.0);
            law = law.slower(steps * config.dt_s / law.duration_s());
            samples.clear();
            over = 0.0;
            for i in 0..=steps as usize {
                let [s, rate, bend] = law.at(i as f64 * config.dt_s);
                let place = self.place(s.clamp(0.0, 1.0), &leans);
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

    /// How the forces should lean at a place that is gone through like this.
    fn lean(&self, place: &Place, rate: f64, bend: f64) -> Lean {
        let [rest, a, b] = &place.needs;
        let w = a * bend + b * rate * rate;
        let still = &place.forces_W[0];
        let leaning = self.shares.leaning(still, &place.com_W, rest + w * FARTHER);
        let plain = self.shares.shared(&place.weights, &place.com_W, [w]);
        let [plain] = plain;
        let leaning = leaning
            .iter()
            .zip(still)
            .map(|(f, rest)| (f - rest) / FARTHER);
        let leaning: Vec<Vector3<f64>> = leaning.collect();
        // By what part of their limits they grow.
        let used = |forces: &Vec<Vector3<f64>>| {
            let mut rows = Vec::new();
            self.bearing(&[still.clone(), forces.clone(), forces.clone()], &mut rows);
            rows.iter().map(|row| row.a / row.c).fold(0.0, f64::max)
        };
        let weight = self.context.robot.mass_kg * GRAVITY_M_S2;
        // Nearly nothing has no direction.
        let square = w.norm_squared() + (SLIGHT * weight).powi(2);
        let better = used(&leaning) < used(&plain);
        let part = if better { 1.0 } else { 0.0 };
        let along = w.transpose() * (part / square);
        let off = leaning.iter().zip(&plain).map(|(f, g)| (f - g) * along);
        off.collect()
    }

    /// The dynamics at `s`, where forces lean as at the places of the grid, or not at all.
    fn place(&mut self, s: f64, leans: &[Lean]) -> Place {
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

    /// Every limit at one place; as many at every place of the path.
    fn rows(&self, place: &Place) -> Vec<Row> {
        let (robot, config) = (self.context.robot, self.context.config);
        let mut rows = Vec::with_capacity(300);
        let mut square = |speed: f64, limit: f64| {
            let b = if limit > 0.0 && limit.is_finite() {
                (speed / limit).powi(2)
            } else {
                0.0
            };
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
            rows.push(Row {
                a,
                b,
                c: room(most),
            });
            rows.push(Row {
                a: -a,
                b: -b,
                c: room(least),
            });
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
        self.bearing(&place.forces_W, &mut rows);
        rows
    }

    /// Forces push, inside eight sides of their contact's cone whose edges are on it; those of the postures'
    /// pyramid are four of these.
    fn bearing(&self, forces_W: &Parts<Vec<Vector3<f64>>>, rows: &mut Vec<Row>) {
        let posture = self.context.posture;
        let friction_use = self.context.config.friction_use.max(posture.friction_use);
        for (i, point) in self.shares.points.iter().enumerate() {
            let contact = &self.phase.closed[point.contact];
            let axes = axes(self.context, contact);
            let parts = [0, 1, 2].map(|k| axes.tr_mul(&forces_W[k][i]));
            let n = parts.map(|f| f.z);
            let mu = contact.friction * friction_use;
            let mut least = |along: [f64; 3], kept: f64| {
                let c = along[0] - kept;
                let row = Row {
                    a: -along[1],
                    b: -along[2],
                    c,
                };
                // A point that bears nothing takes nothing.
                let bears = n[0] > UNLOADED_N;
                rows.push(if bears {
                    Row {
                        c: c.max(ROOM * mu * n[0]),
                        ..row
                    }
                } else {
                    FREE
                });
            };
            least(n, LOAD_KEPT * n[0]);
            for [x, y] in CONE_SIDES {
                let across = |f: &Vector3<f64>| x * f.x + y * f.y;
                least(parts.map(|f| CONE_INSIDE * mu * f.z - across(&f)), 0.0);
            }
        }
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
const FREE: Row = Row {
    a: 0.0,
    b: 0.0,
    c: 1.0,
};
/// A point that bears less at rest takes nothing, N.
const UNLOADED_N: f64 = 1e-3;

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
const CONE_INSIDE: f64 = 0.923_879_532_511_286_7;

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
        let Some(law) = TimeLaw::fastest(&limits, config.smooth_s) else {
            break;
        };
        let used = interpolated(grid, &law, config.dt_s);
        let over = used.iter().fold(0.0, |a: f64, (_, over)| a.max(*over));
        let time = |law: &TimeLaw, over: f64| law.duration_s() * over.max(1.0);
        if best
            .as_ref()
            .is_none_or(|(b, o)| time(&law, over) < time(b, *o))
        {
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
    let pieces = grid.len() - 1;
    let steps = (law.duration_s() / dt_s).ceil() as usize;
    let over = (0..=steps).map(|i| {
        let t = i as f64 * dt_s;
        let [s, rate, bend] = law.at(t);
        let at = s.clamp(0.0, 1.0) * pieces as f64;
        let low = (at as usize).min(pieces - 1);
        let part = at - low as f64;
        let span = law.span(t).map(|s| s * pieces as f64);
        let span = [
            span[0].floor() as usize,
            (span[1].ceil() as usize).min(pieces),
        ];
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
