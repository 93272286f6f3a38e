//! Plans in MuJoCo. Its library is that of the wheel `mujoco`, which Python loads before it calls these.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use pyo3::prelude::*;
use scandent::command::simulate::{self as command, Simulated};
use scandent::robot_files::Robots;
use scandent::told::Told;

use crate::{error, work};

/// Simulates as `scandent simulate FLAGS` does: the results as JSON, the trace, what fails.
#[pyfunction]
pub fn simulate(
    py: Python<'_>,
    flags: Vec<String>,
) -> PyResult<(String, Option<String>, Vec<String>)> {
    let cancel = AtomicBool::new(false);
    let done = work::long(py, &cancel, None, |_| {
        let (args, global) = command::asked_by(&flags)?;
        let mut nobody = std::io::sink();
        let told = &mut Told::words(&mut nobody);
        command::simulate(&args, &global, &cancel, &Robots::default(), told)
    })?;
    let Simulated {
        json,
        trace,
        failures,
        ..
    } = done.map_err(|e| error::input(e, Some("plan")))?;
    let json = String::from_utf8(json).map_err(error::of)?;
    Ok((json, trace, failures))
}

/// The robot of a plan in its world, as the text of a model of MuJoCo's.
#[pyfunction]
pub fn mjcf(py: Python<'_>, plan: PathBuf) -> PyResult<String> {
    let text = work::briefly(py, || command::model(&plan))?;
    text.map_err(|e| error::input(e, Some("plan")))
}
