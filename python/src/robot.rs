//! A robot, read from its files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context;
use pyo3::prelude::*;
use scandent::config::Config;
use scandent::provenance::Inputs;
use scandent::robot_files::{BesideUrdf, RobotFiles};

use crate::{error, work};

/// A robot and the files that it was read from.
#[pyclass(frozen)]
pub struct Robot {
    /// Where its files are.
    pub files: RobotFiles,
    /// What they say.
    pub robot: robot_model::Robot,
}

#[pymethods]
impl Robot {
    #[staticmethod]
    fn load(
        py: Python<'_>,
        urdf: String,
        srdf: Option<PathBuf>,
        contacts: Option<PathBuf>,
        packages: Vec<PathBuf>,
        set: Vec<String>,
    ) -> PyResult<Self> {
        let files = RobotFiles {
            urdf,
            beside: BesideUrdf {
                srdf,
                contacts,
                packages,
            },
        };
        let read = || {
            let config = Config::layered(None, &crate::terrain::settings(set))?;
            files.load(&config.robot_model, &mut Inputs::default())
        };
        let robot = work::briefly(py, read)?.map_err(error::of)?;
        Ok(Self { files, robot })
    }

    /// The text of its URDF.
    fn urdf(&self) -> PyResult<String> {
        let named = &self.files.urdf;
        let ships = named
            .strip_prefix("builtin:")
            .and_then(scenes::builtin_robot);
        let text =
            match ships {
                Some(robot) => Ok(robot.urdf.to_owned()),
                None => (self.files.of_model(&robot_model::Config::default())).and_then(|files| {
                    match files.document {
                        Some(document) => Ok(document.urdf),
                        None => std::fs::read_to_string(named).with_context(|| named.clone()),
                    }
                }),
            };
        text.map_err(|e| error::input(e, Some("urdf")))
    }

    /// The flags of `plan` that name the robot.
    fn flags(&self) -> Vec<String> {
        let mut flags = vec!["--robot".to_owned(), self.files.urdf.clone()];
        flags.extend(self.files.beside.flags());
        flags
    }

    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    #[getter]
    fn mass_kg(&self) -> f64 {
        self.robot.mass_kg
    }

    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.robot.joint_names().map(str::to_owned).collect()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.robot.notes.clone()
    }

    /// Patches by name: link, roles, coefficient of friction.
    #[getter]
    fn patches(&self) -> Vec<(String, String, Vec<String>, f64)> {
        let patches = self.robot.patches.iter();
        let told = patches.map(|p| (p.name.clone(), p.link.clone(), p.roles.clone(), p.friction));
        told.collect()
    }

    /// Named postures as q, the base at rest over the origin where they state none.
    #[getter]
    fn postures(&self) -> PyResult<BTreeMap<String, Vec<f64>>> {
        let names = self.robot.postures.keys();
        let q = names.map(|name| Ok((name.clone(), self.robot.posture(name)?.to_q())));
        q.collect::<anyhow::Result<_>>().map_err(error::of)
    }

    fn resting(&self) -> Vec<f64> {
        self.robot.resting().to_q()
    }
}
