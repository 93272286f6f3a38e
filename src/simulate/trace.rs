//! The trace of a run as a table of comma-separated values.

use std::fmt::Write;

use robot_model::Robot;
use simulation::execution::{Observer, TraceRow};
use simulation::plant::Plant;

/// Keeps a row of the trace every so often.
pub struct Trace {
    text: String,
    every_s: f64,
    next_s: f64,
}

impl Trace {
    /// A trace of a robot with a row every `every_s`.
    pub fn new(robot: &Robot, every_s: f64) -> Self {
        let mut text = String::from("t_s,x_m,y_m,z_m,qx,qy,qz,qw");
        for joint in robot.joint_names() {
            let _ = write!(text, ",{joint}");
        }
        for patch in &robot.patches {
            let _ = write!(text, ",{}_n", patch.name);
        }
        text.push_str(",com_error_m,tilt_rad,torque_use\n");
        Self {
            text,
            every_s,
            next_s: 0.0,
        }
    }

    /// The table.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl Observer for Trace {
    fn see(&mut self, _: &mut Plant, row: &TraceRow) -> Result<(), simulation::Error> {
        if row.t_s + 1e-9 < self.next_s {
            return Ok(());
        }
        self.next_s += self.every_s;
        let _ = write!(self.text, "{:.3}", row.t_s);
        for value in &row.q {
            let _ = write!(self.text, ",{value:.6}");
        }
        for force in &row.normal_n {
            let _ = write!(self.text, ",{force:.2}");
        }
        let (com, tilt, torque) = (row.com_error_m, row.tilt_rad, row.torque_use);
        let _ = writeln!(self.text, ",{com:.6},{tilt:.6},{torque:.4}");
        Ok(())
    }
}
