//! `scandent posture PROBLEMS.json`: a set of independent posture problems and their answers.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use planner::plan::{Input, Program};
use posture::{Contact, Environment, Outcome, Posture, Problem};
use rayon::prelude::*;
use robot_model::{Configuration, Robot};
use serde::Serialize;

use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::posture_problem::{self, ProblemRecord, place_base};
use crate::provenance::Inputs;
use crate::robot_files::RobotFlags;
use crate::status::Status;
use crate::threads;

/// Flags of `posture`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The problems: [{"id", "mu", "contacts": [{"link", "patch", "p", "R", "yaw_free"}]}]
    #[arg(value_name = "PROBLEMS.json")]
    problems: PathBuf,
    #[command(flatten)]
    robot: RobotFlags,
    /// The comfortable posture, as the SRDF names it (default: half_sitting, standing or the first)
    #[arg(long, value_name = "NAME")]
    reference: Option<String>,
    /// Where the results go
    #[arg(short, long, value_name = "RESULTS.json")]
    output: PathBuf,
}

/// The file of results.
#[derive(Serialize)]
struct Results<'a> {
    program: Program,
    config: &'a Config,
    inputs: Vec<Input>,
    joint_names: Vec<&'a str>,
    results: Vec<Answer<'a>>,
}

/// The answer to one problem; `null` where there is no posture.
#[derive(Serialize)]
struct Answer<'a> {
    id: &'a serde_json::Value,
    outcome: &'static str,
    /// Why there is no posture.
    reason: Option<String>,
    /// By how much the worst constraint is violated, scaled as posture::Violation says.
    violation: Option<f64>,
    /// `[p_WB, quat_xyzw, joints…]`, m and rad.
    q: Option<Vec<f64>>,
    forces: Option<Vec<ContactForces<'a>>>,
    margins: Option<planner::plan::Margins>,
    ms: f64,
}

/// The forces of one contact, in the order of the problem's contacts.
#[derive(Serialize)]
#[allow(non_snake_case)]
struct ContactForces<'a> {
    link: &'a str,
    patch: &'a str,
    /// Where the forces act, in W, m.
    points_W: Vec<[f64; 3]>,
    /// Force on the robot at each point, in W, N.
    forces_W: Vec<[f64; 3]>,
}

/// Solves the problems and writes the answers in the order of the problems.
///
/// # Errors
/// A file that cannot be read, a problem that makes no sense; an infeasible one is an answer.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let robot = args.robot.files().load(&config.robot_model, &mut inputs)?;
    let file = args.problems.display().to_string();
    let bytes = inputs.read("problems", &args.problems)?;
    let problems = posture_problem::parse(&bytes).with_context(|| file.clone())?;
    let reference = match &args.reference {
        Some(name) => robot.posture(name)?,
        None => robot.resting(),
    };

    let answers = threads::pool(global.threads)?.install(|| {
        let solve = |problem| answer(problem, &robot, &reference, &config.posture);
        problems.par_iter().map(solve).collect::<Result<Vec<_>>>()
    });
    let answers = answers.with_context(|| file)?;

    let count = |outcome| {
        answers
            .iter()
            .filter(|answer| answer.outcome == outcome)
            .count()
    };
    let (feasible, infeasible) = (count("feasible"), count("infeasible"));
    writeln!(
        out,
        "{} problems: {feasible} feasible, {infeasible} infeasible, {} undecided → {}",
        answers.len(),
        count("undecided"),
        args.output.display()
    )?;
    let results = Results {
        program: crate::program(),
        config: &config,
        inputs: inputs.into_list(),
        joint_names: robot.joint_names().collect(),
        results: answers,
    };
    output::write_json(&args.output, &results)?;
    Ok(Status::Done)
}

fn answer<'a>(
    record: &'a ProblemRecord,
    robot: &'a Robot,
    reference: &Configuration,
    config: &posture::Config,
) -> Result<Answer<'a>> {
    let contacts = record.contacts(robot)?;
    let begin = Instant::now();
    let guess = place_base(robot, reference, &contacts);
    let environment = Environment::empty();
    let problem = Problem {
        robot,
        environment: &environment,
        contacts,
        base_goal: None,
        reference: &guess,
        guess: &guess,
    };
    let outcome =
        posture::solve(&problem, config).with_context(|| format!("problem {}", record.id))?;
    let ms = begin.elapsed().as_secs_f64() * 1e3;
    let found = outcome.posture();
    let violation = outcome.violation();
    Ok(Answer {
        id: &record.id,
        outcome: match &outcome {
            Outcome::Feasible(_) => "feasible",
            Outcome::Infeasible(_) => "infeasible",
            Outcome::Undecided { .. } => "undecided",
        },
        reason: violation.map(|v| v.describe(&problem)),
        violation: violation.map(|v| v.amount),
        q: found.map(|posture| posture.q.to_q()),
        forces: found.map(|posture| forces(posture, &problem.contacts, robot)),
        margins: found.map(|posture| margins(&posture.margins)),
        ms,
    })
}

fn forces<'a>(found: &Posture, contacts: &[Contact], robot: &'a Robot) -> Vec<ContactForces<'a>> {
    let contacts = contacts.iter().zip(&found.contacts);
    contacts
        .map(|(contact, state)| {
            let patch = &robot.patches[contact.patch];
            ContactForces {
                link: &patch.link,
                patch: &patch.name,
                points_W: state.force_points_W.iter().map(|p| (*p).into()).collect(),
                forces_W: state.forces_W.iter().map(|f| (*f).into()).collect(),
            }
        })
        .collect()
}

fn margins(m: &posture::Margins) -> planner::plan::Margins {
    planner::plan::Margins {
        closure_m: m.closure_m,
        inclusion_m: m.inclusion_m,
        equilibrium: m.equilibrium,
        friction_use: m.friction_use,
        torque_use: m.torque_use,
        joint_rad: m.joint_rad,
        clearance_m: m.clearance_m,
        self_clearance_m: m.self_clearance_m,
    }
}
