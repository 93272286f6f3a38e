//! Ways through a stance without a stop: the two phases beside it bend into one direction there.
//!
//!   q(x) = close(q_path(w p(x)) ⊕ h T),   p = 6 x³ − 8 x⁴ + 3 x⁵,   h = w (x − p),   0 ≤ x ≤ 1
//!
//! over the part w of each phase next to the stance, x = 0 at it. There p, p' and p'' are 0 and h' = 1, so
//! that the patch which lands or leaves is at rest while the body goes on along T; at x = 1 it is on the
//! path as before. T is the path's own direction in the phase in which all patches stay closed, so that
//! this one hardly changes. Both phases close the same contacts and so have the same second derivatives.

use nalgebra::{DVector, Point3, Vector3};
use posture::Rolling;
use rayon::prelude::*;
use robot_model::{Configuration, Kinematics, PatchId, Robot};

use crate::clearance::ClearanceMonitor;
use crate::equations::{Target, apart, is_point, place};
use crate::generate::STEP_PART;
use crate::interpolation::Curve;
use crate::load_shares::LoadShares;
use crate::pace::stands;
use crate::problem::MotionContext;
use crate::projection::{Ask, Bounds, Projection};
use crate::sampling::{Instance, SampledTrajectory, coarse, joints, tilt};
use crate::segment::PhaseTrajectory;

/// The part w of a phase that is bent.
const BENT: f64 = 0.25;
/// Phases that are gone through without a stop at most: the law of all of them is sought at once, and a stop
/// in half a minute costs little.
const PHASES_MAX: usize = 40;
/// The parts of the direction that are tried.
const LESS: [f64; 3] = [1.0, 0.6, 0.3];
/// Steps in which a way is looked at before all of its samples are.
const LOOKS: usize = 8;
/// Residual that closing leaves at most, m and rad.
const CLOSED: f64 = 1e-6;

/// The end of a phase at which a stance is gone through.
#[derive(Clone, Copy, PartialEq)]
enum End {
    First,
    Last,
}

/// The phases and their numbers from each stop to the next, bent into each other where they can be and
/// where they may go on after the first of them.
pub(crate) fn through(
    context: &MotionContext,
    phases: &[&PhaseTrajectory],
    may_go_on: impl Fn(&PhaseTrajectory) -> bool + Sync,
) -> Vec<Vec<(usize, PhaseTrajectory)>> {
    let curves: Vec<Curve> = phases.par_iter().map(|phase| phase.curve()).collect();
    let pairs = phases.par_windows(2).zip(curves.par_windows(2));
    let ways = pairs.map(|(pair, curves)| match may_go_on(pair[0]) {
        true => passage(context, [pair[0], pair[1]], [&curves[0], &curves[1]]),
        false => None,
    });
    let ways: Vec<_> = ways.collect();
    let mut runs: Vec<Vec<(usize, PhaseTrajectory)>> = Vec::new();
    for (k, phase) in phases.iter().enumerate() {
        let mut phase = (*phase).clone();
        let way = k.checked_sub(1).and_then(|k| ways[k].as_ref());
        let run = runs.last_mut().filter(|run| run.len() < PHASES_MAX);
        if let (Some([last, first]), Some((_, before))) = (way, run.and_then(|run| run.last_mut()))
        {
            let begin = before.samples.len() - last.len();
            before.samples[begin..].clone_from_slice(last);
            phase.samples[..first.len()].clone_from_slice(first);
            if let Some(run) = runs.last_mut() {
                run.push((k, phase));
            }
        } else {
            runs.push(vec![(k, phase)]);
        }
    }
    runs
}

/// The last samples of the one phase and the first of the next, bent into each other.
fn passage(
    context: &MotionContext,
    [before, after]: [&PhaseTrajectory; 2],
    [back, on]: [&Curve; 2],
) -> Option<[Vec<Instance>; 2]> {
    let robot = context.robot;
    let [one, other] = [
        touching(robot, before, End::Last),
        touching(robot, after, End::First),
    ];
    let closes_all = |phase: &PhaseTrajectory| phase.task.closed.len() == one.len();
    let T = if one != other {
        None
    } else if closes_all(after) {
        Some(on.at(0.0).v)
    } else if closes_all(before) {
        Some(back.at(1.0).v)
    } else {
        None
    }?;
    let mut ways = [
        Way::new(context, before, back, (End::Last, &one)),
        Way::new(context, after, on, (End::First, &one)),
    ];
    // Where the whole of it is beyond a limit, less of it may do: most of what is so is seen on a few samples.
    LESS.iter().find_map(|part| {
        let T = &T * *part;
        ways.iter_mut()
            .all(|way| way.seems_free(&T))
            .then_some(())?;
        let [last, first] = &mut ways;
        Some([last.bent(&T)?, first.bent(&T)?])
    })
}

/// A patch that touches, and how its ball rolls.
type Touching = (PatchId, Option<Rolling>);

/// The patches that touch at an end of a phase.
fn touching(robot: &Robot, phase: &PhaseTrajectory, end: End) -> Vec<Touching> {
    let swing = phase.task.swing.as_ref().and_then(|swing| {
        let (touches, [leaving, landing]) = match end {
            End::First => (swing.leaves.is_some(), swing.rolling),
            End::Last => (swing.lands.is_some(), swing.rolling),
        };
        let rolling = if end == End::First { leaving } else { landing };
        touches.then_some((swing.patch, rolling))
    });
    let closed = phase.task.closed.iter();
    let closed = closed.map(|c| (c.patch, c.rolling(robot)));
    let mut all: Vec<Touching> = closed.chain(swing).collect();
    all.sort_unstable_by_key(|(patch, _)| *patch);
    all
}

/// The part of a phase at one of its ends that is bent.
struct Way<'a> {
    context: &'a MotionContext<'a>,
    phase: &'a PhaseTrajectory,
    path: &'a Curve,
    end: End,
    touching: &'a [Touching],
    /// Number of its samples, without the first.
    count: usize,
    /// How readily each coordinate moves where contacts are closed.
    weight: Vec<f64>,
    shares: LoadShares,
    kinematics: Kinematics,
    gravity: DVector<f64>,
    projection: Projection,
}

impl<'a> Way<'a> {
    fn new(
        context: &'a MotionContext<'a>,
        phase: &'a PhaseTrajectory,
        path: &'a Curve,
        (end, touching): (End, &'a [Touching]),
    ) -> Self {
        let robot = context.robot;
        let carries = |k: usize, (p, _): &Touching| robot.supports(k - 5, robot.patches[*p].body);
        let moves = |k: usize| k < 6 || touching.iter().any(|p| carries(k, p));
        Self {
            count: (BENT * (phase.samples.len() - 1) as f64) as usize,
            weight: (0..robot.nv())
                .map(|k| f64::from(u8::from(moves(k))))
                .collect(),
            shares: LoadShares::new(context, &phase.task.closed),
            kinematics: Kinematics::new(robot, &path.configuration(0.0)),
            gravity: DVector::zeros(robot.nv()),
            projection: Projection::default(),
            context,
            phase,
            path,
            end,
            touching,
        }
    }

    /// The configuration at a sample bent along `T`, and where on the path that is; nothing where its contacts cannot
    /// be closed or it is beyond a limit.
    fn at(&mut self, i: usize, T: &DVector<f64>) -> Option<(f64, Configuration)> {
        let (context, robot) = (self.context, self.context.robot);
        let w = self.count as f64 / (self.phase.samples.len() - 1) as f64;
        let x = i as f64 / self.count as f64;
        let x = if self.end == End::First { x } else { 1.0 - x };
        let p = x * x * x * (6.0 + x * (3.0 * x - 8.0));
        let (u, along, h) = match self.end {
            End::First => (w * x, w * p, w * (x - p)),
            End::Last => (1.0 - w * x, 1.0 - w * p, -w * (x - p)),
        };
        let mut q = self.path.configuration(along);
        let kinematics = &mut self.kinematics;
        kinematics.update(robot, &q);
        let places = self.touching.iter().map(|(p, rolling)| {
            let X_WC = place(robot, kinematics, *p, rolling.as_ref());
            (*p, X_WC, *rolling)
        });
        let patches = places.collect();
        q.integrate_in_place((T * h).as_slice());
        kinematics.update(robot, &q);
        let target = Target {
            patches,
            turn_freedom: 0.0,
            com_W: kinematics.com_W,
        };
        let ask = Ask {
            robot,
            target: &target,
            bounds: &Bounds::NONE,
            weight: &self.weight,
        };
        self.projection.close(&ask, &mut q, kinematics);
        let off = target.patches.iter().map(|(p, wanted, rolling)| {
            let X_WC = place(robot, kinematics, *p, rolling.as_ref());
            apart(&X_WC, wanted, is_point(robot, *p))
        });
        if off.fold(0.0, f64::max) > CLOSED {
            return None;
        }
        let mut worst = None;
        joints(context, &self.phase.task, &q.joints, u, &mut worst);
        tilt(context, &self.phase.task, &q.R_WB, u, &mut worst);
        if let Some(failure) = worst {
            tracing::debug!("no way through: {}", failure.describe());
            return None;
        }
        Some((u, q))
    }

    /// The number of the first of the phase's samples that are bent.
    fn begin(&self) -> usize {
        match self.end {
            End::First => 0,
            End::Last => self.phase.samples.len() - 1 - self.count,
        }
    }

    /// Whether contacts and joints can hold the body where it was last looked at, by the forces of this sample.
    fn stands(&mut self, i: usize) -> bool {
        let (context, kinematics) = (self.context, &self.kinematics);
        kinematics.gravity_torques(context.robot, &mut self.gravity);
        let forces_W: &[Vec<Vector3<f64>>] = &self.phase.samples[self.begin() + i].forces_W;
        let (closed, gravity) = (&self.phase.task.closed, self.gravity.as_slice());
        stands(context, closed, &self.shares, kinematics, gravity, forces_W)
    }

    /// Whether a few samples keep to their limits.
    fn seems_free(&mut self, T: &DVector<f64>) -> bool {
        let step = (self.count / LOOKS).max(1);
        (0..=self.count)
            .step_by(step)
            .all(|i| self.at(i, T).is_some() && self.stands(i))
    }

    /// The samples; nothing where one of them is not as it should be.
    fn bent(&mut self, T: &DVector<f64>) -> Option<Vec<Instance>> {
        let (context, phase) = (self.context, self.phase);
        let begin = self.begin();
        let mut clearances = ClearanceMonitor::new(context, &phase.task);
        let mut worst = None;
        let mut places_W: Vec<Vec<Point3<f64>>> = Vec::new();
        let mut samples = Vec::with_capacity(self.count + 1);
        for i in 0..=self.count {
            let (u, q) = self.at(i, T)?;
            // What rests bear at the new places, the contacts can.
            if !self.stands(i) {
                return None;
            }
            clearances.look(&self.kinematics, u, &mut worst);
            if let Some(failure) = worst {
                tracing::debug!("no way through: {}", failure.describe());
                return None;
            }
            let bodies = context.robot.bodies.iter().zip(&self.kinematics.X_WB);
            let places = bodies.map(|(body, X_WB)| X_WB * Point3::from(body.com_B));
            places_W.push(places.collect());
            samples.push(Instance {
                q: q.to_q(),
                forces_W: phase.samples[begin + i].forces_W.clone(),
            });
        }
        let trajectory = SampledTrajectory {
            coarse: clearances.coarse.max(coarse(context, &samples)),
            samples,
            places_W,
        };
        let (step, _) = trajectory.longest_step();
        let near = step <= STEP_PART * context.posture.clearance_m && trajectory.coarse <= 1.0;
        tracing::debug!("through: near {near}");
        near.then_some(trajectory.samples)
    }
}
