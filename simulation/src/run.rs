//! A robot in its world, step by step under the eyes of its monitor.

use nalgebra::DVector;
use robot_model::{Configuration, Robot};

use crate::monitor::{Monitor, Seen};
use crate::plant::{Plant, Touch};
use crate::reference::ReferenceState;

/// A run of the simulation.
pub(crate) struct Run<'a> {
    pub plant: Plant,
    pub monitor: Monitor<'a>,
    /// Configuration and velocity after the last step.
    pub state: Configuration,
    pub v: DVector<f64>,
    touches: Vec<Touch>,
}

impl<'a> Run<'a> {
    /// The robot at rest where it is wanted at first.
    pub fn new(
        robot: &Robot,
        mut plant: Plant,
        monitor: Monitor<'a>,
        wanted: &ReferenceState,
    ) -> Self {
        plant.reset(&wanted.configuration);
        Self {
            plant,
            monitor,
            state: wanted.configuration.clone(),
            v: DVector::zeros(robot.nv()),
            touches: Vec::new(),
        }
    }

    /// One time step, which the monitor sees at `t_s`; `false` where the simulation became unstable.
    pub fn step(&mut self, t_s: f64, wanted: &ReferenceState) -> bool {
        let stable = self.plant.step();
        self.plant.state(&mut self.state, &mut self.v);
        self.plant.touches(&mut self.touches);
        self.monitor.see(&Seen {
            t_s,
            configuration: &self.state,
            wanted,
            touches: &self.touches,
            torques: self.plant.torques(),
        });
        stable
    }
}
