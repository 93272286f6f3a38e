//! Postures: of one contact set on a terrain, or of many in a file's form.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, bail};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2};
use posture::{BaseGoal, Contact, Environment, Freedom, Problem, stand};
use pyo3::prelude::*;
use rayon::prelude::*;
use scandent::command::posture::{Answer, Solver};
use scandent::command::posture_sets;
use scandent::config::Config;
use scandent::{output, posture_problem, threads};
use serde_json::Value;

use crate::robot::Robot;
use crate::terrain::{Terrain, settings};
use crate::{error, work};

/// A contact as Python gives it: patch, face, pose x y z qx qy qz qw of C in W, whether it may turn about
/// its normal, whether it may bear, coefficient of friction.
type Wanted = (
    String,
    Option<String>,
    Option<[f64; 7]>,
    bool,
    bool,
    Option<f64>,
);

/// Where the base is to be: x, y, z, within how far, heading, within what angle.
type BasePlace = ([Option<f64>; 3], f64, Option<f64>, f64);

fn isometry([x, y, z, qx, qy, qz, qw]: [f64; 7]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

fn contact(
    (patch, face, pose, turns, loaded, friction): &Wanted,
    robot: &robot_model::Robot,
    environment: &Environment,
) -> anyhow::Result<Contact> {
    let patch = robot.patch_id(patch)?;
    let face = face.as_deref().map(|face| environment.face(face));
    let contact = match (pose, face.transpose()?) {
        (Some(pose), face) => Contact {
            face,
            freedom: if *turns { Freedom::Yaw } else { Freedom::Fixed },
            ..Contact::at(
                robot,
                patch,
                robot.patches[patch].touching(&isometry(*pose)),
            )
        },
        (None, Some(face)) => Contact::anywhere_on(environment, face, robot, patch)?,
        (None, None) => bail!("neither a face nor a pose says where it is"),
    };
    let friction = friction.unwrap_or(contact.friction);
    Ok(Contact {
        friction,
        ..contact.loaded(*loaded)
    })
}

/// Solves one contact set on a terrain; the answer as JSON, as `scandent posture` writes it.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn solve(
    py: Python<'_>,
    robot: &Robot,
    terrain: &Terrain,
    contacts: Vec<Wanted>,
    reference: Option<Vec<f64>>,
    base: Option<BasePlace>,
    explain: bool,
    set: Vec<String>,
) -> PyResult<String> {
    let robot = &robot.robot;
    let worked = || {
        let mut config = Config::layered(None, &settings(set))?;
        config.posture.solver.thorough = true;
        let (thickness_m, sigmas) = (config.surfaces.body.thickness_m, config.posture.edge_sigmas);
        let environment = Environment::new(terrain.terrain.clone(), thickness_m, sigmas)?;
        let contacts = contacts.iter().enumerate().map(|(i, wanted)| {
            let contact = contact(wanted, robot, &environment);
            contact.with_context(|| format!("contacts[{i}]"))
        });
        let contacts = contacts.collect::<anyhow::Result<Vec<_>>>()?;
        let start = match reference {
            Some(q) => robot.configuration(&q).context("reference")?,
            None => stand::over_contacts(robot, &robot.resting(), &contacts),
        };
        let base_goal =
            base.map(
                |(position_m, tolerance_m, yaw_rad, yaw_tolerance_rad)| BaseGoal {
                    position_m,
                    tolerance_m,
                    yaw_rad,
                    yaw_tolerance_rad,
                },
            );
        let problem = Problem {
            base_goal,
            ..Problem::new(robot, &environment, contacts, &start)
        };
        let outcome = posture::solve(&problem, &config.posture)?;
        let mut answer = Answer::new(&Value::Null, &outcome, &problem, robot);
        if explain && outcome.posture().is_none() {
            let explained = posture::explain(&problem, &config.posture)?;
            answer.explanation = explained.map(|e| e.words);
        }
        anyhow::Ok(serde_json::to_string(&answer)?)
    };
    work::briefly(py, worked)?.map_err(error::of)
}

/// The answers to many problems.
#[pyclass(frozen)]
pub struct Postures {
    nq: usize,
    outcomes: Vec<&'static str>,
    q: Vec<Option<Vec<f64>>>,
    iterations: Vec<i64>,
    /// Each answer as the command line writes it.
    json: Vec<String>,
}

#[pymethods]
impl Postures {
    #[getter]
    fn outcomes(&self) -> Vec<&'static str> {
        self.outcomes.clone()
    }

    /// A row a problem, NaN where there is no posture.
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let mut rows = Array2::from_elem((self.q.len(), self.nq), f64::NAN);
        for (mut row, q) in rows.rows_mut().into_iter().zip(&self.q) {
            for (x, value) in row.iter_mut().zip(q.iter().flatten()) {
                *x = *value;
            }
        }
        PyArray2::from_owned_array(py, rows)
    }

    /// Iterations, 0 where there is no posture.
    fn iterations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_slice(py, &self.iterations)
    }

    fn __len__(&self) -> usize {
        self.q.len()
    }

    fn json(&self, index: usize) -> Option<&str> {
        self.json.get(index).map(String::as_str)
    }
}

/// Solves the problems of a text as `scandent posture` does of a file.
#[pyfunction]
pub fn solve_all(
    py: Python<'_>,
    robot: &Robot,
    problems: &[u8],
    reference: Option<&str>,
    set: Vec<String>,
    threads: Option<usize>,
) -> PyResult<Postures> {
    let robot = &robot.robot;
    let cancel = AtomicBool::new(false);
    let done = work::long(py, &cancel, None, |_| {
        let config = Config::layered(None, &settings(set))?;
        let set = posture_problem::parse(problems)?;
        if !(set.robot.is_empty() || set.robot == robot.name) {
            bail!(
                "these problems are for {}, not for {}",
                set.robot,
                robot.name
            );
        }
        let solver = Solver {
            robot,
            reference: match reference {
                Some(name) => robot.posture(name)?,
                None => robot.resting(),
            },
            config: &config.posture,
            body_m: set.body_m,
            repeat: 1,
            explain: false,
        };
        let threads = threads.and_then(std::num::NonZeroUsize::new);
        let answers = threads::pool(threads)?.install(|| {
            let solve = |problem| match cancel.load(Ordering::Relaxed) {
                true => bail!("interrupted"),
                false => solver.answer(problem),
            };
            let answers = set.problems.par_iter().map(solve);
            answers.collect::<anyhow::Result<Vec<_>>>()
        })?;
        let json = answers.iter().map(serde_json::to_string);
        Ok(Postures {
            nq: 7 + robot.nj(),
            outcomes: answers.iter().map(|a| a.outcome).collect(),
            iterations: answers
                .iter()
                .map(|a| a.iterations.unwrap_or(0) as i64)
                .collect(),
            json: json.collect::<Result<_, _>>()?,
            q: answers.into_iter().map(|a| a.q).collect(),
        })
    })?;
    done.map_err(|e| error::input(e, Some("problems")))
}

/// Problems drawn from the seed of the settings, as the bytes of the file that `scandent posture-sets` writes.
#[pyfunction]
pub fn draw(
    py: Python<'_>,
    robot: &Robot,
    family: &str,
    count: usize,
    seed: u64,
    set: Vec<String>,
) -> PyResult<String> {
    let drawn = || {
        let mut config = Config::layered(None, &settings(set))?;
        config.seed = seed;
        let set = posture_sets::draw(&robot.robot, family, count, &config)?;
        anyhow::Ok(String::from_utf8(output::json(&set)?)?)
    };
    work::briefly(py, drawn)?.map_err(error::of)
}
