//! The native half of the Python package `scandent`; `python/scandent/` holds what users meet.
//!
//! | module | what it gives |
//! |---|---|
//! | `robot` | a robot, read |
//! | `terrain` | what may be touched, and the bytes that it is planned from |
//! | `planned` | plans, made and read: as the command line makes and reads them |
//! | `batch` | items of a batch |
//! | `simulated` | plans in MuJoCo |
//! | `solved` | postures: one, or a file of problems |
//! | `work` | long work: without the interpreter's lock, ended by Ctrl-C, panics told as exceptions |
//!
//! It holds no algorithm and no default: arguments become the command line's flags, so that results are
//! the same bytes.

mod batch;
mod error;
mod planned;
mod robot;
mod simulated;
mod solved;
mod terrain;
mod work;

use pyo3::prelude::*;
use scandent::command::simulate;
use scandent::robot_files::LOADS_MUJOCO;

/// Has Python load MuJoCo's library.
fn load_mujoco() -> anyhow::Result<()> {
    let load = |py: Python<'_>| {
        let module = py.import("scandent._simulation")?;
        module.call_method0("load_mujoco").map(drop)
    };
    Python::attach(load).map_err(|error: PyErr| anyhow::anyhow!("{error}"))
}

#[pymodule]
fn _scandent(m: &Bound<'_, PyModule>) -> PyResult<()> {
    let _ = LOADS_MUJOCO.set(load_mujoco);
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("MUJOCO_VERSION", simulate::MUJOCO_VERSION)?;
    m.add_class::<robot::Robot>()?;
    m.add_class::<terrain::Terrain>()?;
    m.add_class::<planned::Plan>()?;
    m.add_class::<solved::Postures>()?;
    m.add_function(wrap_pyfunction!(terrain::perceive, m)?)?;
    m.add_function(wrap_pyfunction!(planned::from_flags, m)?)?;
    m.add_function(wrap_pyfunction!(planned::of_scene, m)?)?;
    m.add_function(wrap_pyfunction!(planned::check, m)?)?;
    m.add_function(wrap_pyfunction!(solved::solve, m)?)?;
    m.add_function(wrap_pyfunction!(solved::solve_all, m)?)?;
    m.add_class::<batch::Worker>()?;
    m.add_function(wrap_pyfunction!(simulated::simulate, m)?)?;
    m.add_function(wrap_pyfunction!(simulated::mjcf, m)?)?;
    m.add_function(wrap_pyfunction!(batch::batch_index, m)?)?;
    m.add_function(wrap_pyfunction!(solved::draw, m)?)
}
