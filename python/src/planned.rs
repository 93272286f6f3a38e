//! Plans, made and read, as the command line makes and reads them.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use plan::Motion;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use robot_model::Robot as Model;
use scandent::cli::Global;
use scandent::command::verify::certificate;
use scandent::config::Config;
use scandent::export::{self, Format};
use scandent::output::{self, Folder};
use scandent::pipeline::{self, PlanOutcome, RunOptions};
use scandent::plan_file::{self, PlanRobotFlags};
use scandent::provenance::{Inputs, reading_results};
use scandent::robot_files::Robots;
use scandent::scene::Scene;
use scandent::view::{self, ViewInput};
use scandent::{command, results};
use verify::Certificate;

use crate::terrain::Terrain;
use crate::{error, work};

/// A plan with its motion and its robot.
#[pyclass(frozen)]
pub struct Plan(From);

enum From {
    /// As the pipeline made it.
    Pipeline(Box<PlanOutcome>),
    /// As files hold it.
    File(Box<(plan::Plan, Option<Motion>, Model)>),
}

impl Plan {
    fn parts(&self) -> (&plan::Plan, Option<&Motion>, &Model) {
        match &self.0 {
            From::Pipeline(made) => (&made.plan, made.motion.as_ref(), &made.robot),
            From::File(read) => (&read.0, read.1.as_ref(), &read.2),
        }
    }
}

#[pymethods]
impl Plan {
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = || {
            let plan = plan_file::open(&path)?;
            let motion = plan_file::open_motion(&path, &plan)?;
            if let Some(motion) = &motion {
                motion.validate()?;
            }
            let robot = PlanRobotFlags::default().load(&plan)?;
            anyhow::Ok((plan, motion, robot))
        };
        let read = work::briefly(py, || reading_results(read))?;
        let read = read.map_err(|e| error::input(e, Some("file")))?;
        Ok(Self(From::File(Box::new(read))))
    }

    /// The bytes of `plan.json`.
    fn json(&self) -> PyResult<String> {
        let bytes = output::json(self.parts().0).map_err(error::of)?;
        String::from_utf8(bytes).map_err(error::of)
    }

    /// Whether it has a motion.
    fn moves(&self) -> bool {
        self.parts().1.is_some()
    }

    /// How the search ended, why, and what to try; nothing of a verified plan.
    fn unsolved(&self) -> Option<(String, String, Vec<String>, Vec<String>)> {
        let unsolved = self.parts().0.search.unsolved.clone()?;
        let (status, words) = (unsolved.status, unsolved.sentence);
        Some((status, words, unsolved.reasons, unsolved.to_try))
    }

    /// The verifier's verdict, as JSON; nothing of a plan that was read.
    fn certificate(&self) -> PyResult<Option<String>> {
        match &self.0 {
            From::Pipeline(made) => made.certificate.to_json().map(Some).map_err(error::of),
            From::File(_) => Ok(None),
        }
    }

    /// Times and sizes, as JSON.
    fn report(&self) -> PyResult<Option<String>> {
        match &self.0 {
            From::Pipeline(made) => {
                let json = serde_json::to_string(&made.report);
                json.map(Some).map_err(error::of)
            }
            From::File(_) => Ok(None),
        }
    }

    fn notes(&self) -> Vec<String> {
        match &self.0 {
            From::Pipeline(made) => made.notes.clone(),
            From::File(_) => Vec::new(),
        }
    }

    /// Writes the folder of results that the command line writes.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let From::Pipeline(made) = &self.0 else {
            let words = "a plan that was read is in its files already";
            return Err(error::of(anyhow::anyhow!(words)));
        };
        let write = || results::write(Folder::new(&folder, results::NAMES)?, made);
        work::briefly(py, write)?.map_err(|e| error::input(e, Some("folder")))
    }

    /// The page.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let (plan, motion, robot) = self.parts();
        let (certificate, trace, cloud_W) = match &self.0 {
            From::Pipeline(made) => (
                Some(&made.certificate),
                Some(&made.trace),
                &made.cloud_W[..],
            ),
            From::File(_) => (None, None, &[][..]),
        };
        let input = ViewInput {
            plan,
            robot,
            motion,
            trace,
            certificate,
            cloud_W,
        };
        work::briefly(py, || view::page(&input))?.map_err(error::of)
    }

    /// The plan in the format of another program.
    fn export<'py>(&self, py: Python<'py>, format: &str) -> PyResult<Bound<'py, PyBytes>> {
        let known = format.parse::<Format>().map_err(|_| {
            let words = anyhow::anyhow!(
                "no format {format:?}: mcc-yaml, json, csv, motion-csv, npz or mcap"
            );
            error::input(words, Some("format"))
        })?;
        let (plan, motion, robot) = self.parts();
        let config = match &self.0 {
            From::Pipeline(made) => made.config.export.clone(),
            From::File(_) => export::Config::default(),
        };
        let write = || export::export(plan, motion, robot, known, &config);
        let bytes = work::briefly(py, write)?.map_err(error::of)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// Plans as `scandent plan FLAGS` does; the terrain, where there is one, is that of the flags.
#[pyfunction]
pub fn from_flags(
    py: Python<'_>,
    terrain: Option<&Terrain>,
    flags: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Plan> {
    let mut flags = flags;
    if let Some(terrain) = terrain {
        flags.splice(1..1, terrain.flags());
    }
    let mut inputs = Inputs::default();
    let (mut scene, global) = command::plan::asked_by(&flags, &mut inputs).map_err(error::of)?;
    if let Some(terrain) = terrain {
        scene.files = terrain.files();
    }
    let mut made = search(py, &scene, &global, inputs, progress)?;
    if let (Some(terrain), From::Pipeline(made)) = (terrain, &mut made.0) {
        // The page shows what was perceived before.
        made.cloud_W.extend_from_slice(&terrain.cloud_W);
    }
    Ok(made)
}

/// Plans as `scandent run SCENE FLAGS` does.
#[pyfunction]
pub fn of_scene(
    py: Python<'_>,
    scene: &str,
    flags: Vec<String>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Plan> {
    let global = command::plan::global_of(&flags).map_err(error::of)?;
    let mut inputs = Inputs::default();
    let asked = command::run::asked(scene, None, &global, &mut inputs);
    let scene = asked.map_err(|e| error::input(e, Some("scene")))?;
    search(py, &scene, &global, inputs, progress)
}

fn search(
    py: Python<'_>,
    scene: &Scene,
    global: &Global,
    inputs: Inputs,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Plan> {
    let layers = Some((scene.name.as_str(), &scene.settings));
    let config = Config::layered(layers, global).map_err(|e| error::input(e, Some("config")))?;
    scene.will_read();
    let cancel = AtomicBool::new(false);
    let is_heard = progress.is_some();
    let made = work::long(py, &cancel, progress, |reporter| {
        let options = RunOptions {
            threads: global.threads,
            stage: &|_| {},
            progress: &|event| {
                if is_heard {
                    reporter.tell(event);
                }
            },
            cancel: &cancel,
            robots: &Robots::default(),
        };
        pipeline::plan(scene, &config, &options, inputs)
    })?;
    Ok(Plan(From::Pipeline(Box::new(made.map_err(error::of)?))))
}

/// The certificate of the plan in a file, as JSON.
#[pyfunction]
pub fn check(
    py: Python<'_>,
    path: PathBuf,
    against: Option<String>,
    threads: Option<usize>,
) -> PyResult<String> {
    let global = Global {
        threads: threads.and_then(std::num::NonZeroUsize::new),
        ..Global::default()
    };
    let checked = || {
        let plan = plan_file::open(&path)?;
        let robot = PlanRobotFlags::default();
        let path: &Path = &path;
        let certificate: Certificate =
            certificate(path, &plan, against.as_deref(), &robot, &global)?;
        certificate.to_json().map_err(anyhow::Error::from)
    };
    let checked = work::briefly(py, || reading_results(checked))?;
    checked.map_err(|e| error::input(e, Some("plan")))
}
