//! What moves the joints: the whole-body controller beside a soft servo, or a stiff servo alone.

use robot_model::Robot;

use crate::Error;
use crate::clock::Capture;
use crate::config::Controller;
use crate::physics::{Physics, Servo};
use crate::reference::ReferenceState;
use crate::run::Run;
use crate::sensing::Sensing;
use crate::touching::Touching;
use crate::whole_body::{PERIOD_S, WholeBodyController};

/// A controller with its memory.
pub(crate) struct Control<'a> {
    robot: &'a Robot,
    kind: Controller,
    controller: WholeBodyController<'a>,
    touching: Touching,
    sensing: Sensing,
    /// How far each joint was off the plan when a patch that it moves last stood.
    off: Vec<f64>,
    dt_s: f64,
    /// Steps of the physics between two commands.
    pub period: usize,
}

/// The joint servo beside a controller.
pub(crate) fn servo(kind: Controller) -> Servo {
    match kind {
        Controller::Servo => Servo::STIFF,
        Controller::WholeBody => Servo::SOFT,
    }
}

impl<'a> Control<'a> {
    /// A controller of a robot that is where it is wanted; `sensing` is the seed of what it is told wrongly.
    ///
    /// # Errors
    /// As [`WholeBodyController::new`].
    pub fn new(
        robot: &'a Robot,
        physics: &Physics,
        kind: Controller,
        wanted: &ReferenceState,
        sensing: Option<u64>,
    ) -> Result<Self, Error> {
        Ok(Self {
            robot,
            kind,
            controller: WholeBodyController::new(robot, physics)?,
            touching: Touching::new(robot, wanted),
            sensing: Sensing::new(sensing, &wanted.configuration, robot.patches.len()),
            off: vec![0.0; robot.nj()],
            dt_s: physics.dt_s,
            period: ((PERIOD_S / physics.dt_s).round() as usize).max(1),
        })
    }

    /// Where the capture point is, as far as the controller knows.
    pub fn capture(&self, wanted: &ReferenceState) -> Capture {
        self.controller.capture(wanted)
    }

    /// Commands the joints from the state of the run.
    ///
    /// # Errors
    /// As [`WholeBodyController::torques`].
    pub fn command(&mut self, run: &mut Run, wanted: &ReferenceState) -> Result<(), Error> {
        let touching = &self.touching;
        if self.kind == Controller::Servo {
            let (q, v) = (&wanted.configuration, &wanted.v);
            let torques = self.controller.torques(q, v, wanted, touching.all())?;
            let rates = &v.as_slice()[6..];
            run.plant.command(q.joints.as_slice(), rates, torques);
            return Ok(());
        }
        let dt_s = self.period as f64 * self.dt_s;
        let now = touching.now();
        self.sensing.see(&run.state, &run.v, dt_s);
        let (state, v) = (&self.sensing.state, &self.sensing.v);
        let torques = self.controller.torques(state, v, wanted, now)?.to_vec();
        // The servo holds limbs in the air where they are wanted, and damps those that touch or should: a spring to
        // the plan's joints would press a foot that stands 10 mm off its place with 60 to 100 N of which the program
        // knows nothing. One that leaves is drawn to them as the program draws its patch: a ball that has rolled by
        // 20 mm would spring there in 40 ms.
        let touches =
            |patch: &usize| now[*patch] || wanted.contacts.iter().any(|c| c.patch == *patch);
        let mut joints = wanted.configuration.joints.clone();
        let mut rates = wanted.v.as_slice()[6..].to_vec();
        let (robot, nj) = (self.robot, joints.len());
        let limb = |patch: usize| {
            let body = robot.patches[patch].body;
            (0..nj).filter(move |j| robot.supports(j + 1, body))
        };
        let (closed, open): (Vec<usize>, Vec<usize>) = (0..now.len()).partition(touches);
        let mut kept = vec![0.0_f64; nj];
        for patch in open {
            let part = self.controller.kept_of(patch);
            limb(patch).for_each(|j| kept[j] = kept[j].max(part));
        }
        for (j, kept) in kept.iter().enumerate() {
            joints[j] += self.off[j] * kept;
        }
        for patch in closed {
            for j in limb(patch) {
                joints[j] = state.joints[j];
                self.off[j] = joints[j] - wanted.configuration.joints[j];
                // A leg that seeks what it should stand on is not damped either: it came down at .06 m/s for .15.
                if !now[patch] {
                    rates[j] = v[6 + j];
                }
            }
        }
        run.plant.command(joints.as_slice(), &rates, &torques);
        Ok(())
    }

    /// Takes in what the feet and hands feel after a step.
    pub fn feel(&mut self, run: &Run, wanted: &ReferenceState) {
        let monitor = &run.monitor;
        let lands = monitor.nears_landing(wanted);
        self.sensing.feel(&monitor.normal_n, self.dt_s);
        self.touching
            .update(&self.sensing.normal_n, wanted, lands, self.dt_s);
    }
}
