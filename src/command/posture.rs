//! `scandent posture PROBLEMS.json`: a set of independent posture problems and their answers.

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use plan::{Input, Program};
use posture::{Contact, Outcome, Posture, Problem};
use rayon::prelude::*;
use robot_model::{Configuration, Robot};
use scenes::contact_sets::{Expected, ProblemRecord};
use serde::Serialize;

use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::posture_problem;
use crate::provenance::Inputs;
use crate::report::quantile;
use crate::robot_files::RobotFiles;
use crate::status::Status;
use crate::threads;
use crate::told::Told;

mod timing;

/// The outcome of a problem that has a posture.
const FEASIBLE: &str = "feasible";

/// Flags of `posture`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The problems: a file as `scandent posture-sets` writes it, or the list of its problems
    #[arg(value_name = "PROBLEMS.json")]
    problems: PathBuf,
    #[command(flatten)]
    robot: RobotFiles,
    /// The comfortable posture, as the SRDF names it (default: half_sitting, standing or the first)
    #[arg(long, value_name = "NAME")]
    reference: Option<String>,
    /// Where the results go
    #[arg(short, long, value_name = "RESULTS.json")]
    output: PathBuf,
    /// Solve every problem so often, one after another on one thread, and tell the median time
    #[arg(long, value_name = "N")]
    repeat: Option<NonZeroUsize>,
    /// Also tell of every problem without a posture which constraints cannot hold together, and
    /// what it would take, and write down the proof of every infeasible one
    #[arg(long)]
    explain: bool,
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
pub struct Answer<'a> {
    /// The problem's.
    pub id: &'a serde_json::Value,
    /// `feasible`, `infeasible` or `undecided`.
    pub outcome: &'static str,
    /// What is known of the answer by the way the problem was made.
    pub expected: Option<Expected>,
    /// Why there is no posture: the constraint that is violated most.
    pub reason: Option<String>,
    /// With `--explain`: the smallest group of constraints that cannot hold together, and what it
    /// would take.
    pub explanation: Option<String>,
    /// With `--explain`: the proof that there is no posture, which `verify` has recomputed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refutation: Option<plan::Refutation>,
    /// By how much the worst constraint is violated, scaled as posture::Violation says.
    pub violation: Option<f64>,
    /// `[p_WB, quat_xyzw, joints…]`, m and rad.
    pub q: Option<Vec<f64>>,
    /// Those of every contact.
    pub forces: Option<Vec<ContactForces<'a>>>,
    /// How far the posture is from each limit.
    pub margins: Option<plan::Margins>,
    /// Iterations over all starts, where there is a posture.
    pub iterations: Option<usize>,
    /// Time of the solve, µs; with `--repeat` the median.
    pub us: f64,
}

/// The forces of one contact, in the order of the problem's contacts.
#[derive(Serialize)]
pub struct ContactForces<'a> {
    /// The link that carries the patch.
    pub link: &'a str,
    /// The patch.
    pub patch: &'a str,
    /// Where the forces act, in W, m.
    pub points_W: Vec<[f64; 3]>,
    /// Force on the robot at each point, in W, N.
    pub forces_W: Vec<[f64; 3]>,
}

/// Solves the problems and writes the answers in the order of the problems.
///
/// # Errors
/// A file that cannot be read, a problem that makes no sense; an infeasible one is an answer.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let robot = args.robot.load(&config.robot_model, &mut inputs)?;
    let file = args.problems.display().to_string();
    let bytes = inputs.read("problems", &args.problems)?;
    output::check(&args.output)?;
    let set = posture_problem::parse(&bytes).with_context(|| file.clone())?;
    if !(set.robot.is_empty() || set.robot == robot.name) {
        let (meant, given) = (&set.robot, &robot.name);
        bail!("{file}: these problems are for {meant}, not for {given}");
    }
    let reference = match &args.reference {
        Some(name) => robot.posture(name)?,
        None => robot.resting(),
    };

    let solver = Solver {
        robot: &robot,
        reference,
        config: &config.posture,
        body_m: set.body_m,
        repeat: args.repeat.map_or(1, NonZeroUsize::get),
        explain: args.explain,
    };
    // Solves that are to be timed do not share the machine with one another.
    let threads = global.threads.or(args.repeat.and(NonZeroUsize::new(1)));
    let pool = threads::pool(threads)?;
    let answers = told.counting("solving problems", set.problems.len(), |done| {
        pool.install(|| {
            let solve = |problem| solver.answer(problem).inspect(|_| done());
            let answers = set.problems.par_iter().map(solve);
            answers.collect::<Result<Vec<_>>>()
        })
    });
    let answers = answers.with_context(|| file)?;

    let count = |outcome| answers.iter().filter(|a| a.outcome == outcome).count();
    let (feasible, infeasible) = (count(FEASIBLE), count("infeasible"));
    let (problems, undecided) = (answers.len(), count("undecided"));
    writeln!(
        told,
        "{problems} problems: {feasible} feasible, {infeasible} infeasible, {undecided} undecided"
    )?;
    timing::print(&answers, told)?;
    for (name, count) in [
        ("problems", problems),
        (FEASIBLE, feasible),
        ("infeasible", infeasible),
        ("undecided", undecided),
    ] {
        told.fact(name, count)?;
    }
    let results = Results {
        program: crate::program(),
        config: &config,
        inputs: inputs.into_list(),
        joint_names: robot.joint_names().collect(),
        results: answers,
    };
    output::write_json(&args.output, &results)?;
    told.written(&args.output)?;
    Ok(Status::Done)
}

/// What all problems of a file share.
pub struct Solver<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The comfortable posture.
    pub reference: Configuration,
    /// The settings.
    pub config: &'a posture::Config,
    /// Thickness of the body behind every surface, m.
    pub body_m: f64,
    /// How often each is solved, for its time.
    pub repeat: usize,
    /// Whether to tell what cannot hold together.
    pub explain: bool,
}

impl<'a> Solver<'a> {
    /// Solves one.
    ///
    /// # Errors
    /// A problem that makes no sense.
    pub fn answer(&self, record: &'a ProblemRecord) -> Result<Answer<'a>> {
        let posed = posture_problem::pose(record, self.robot, &self.reference, self.body_m)?;
        let problem = posed.problem(self.robot);
        let named = || format!("problem {}", record.id);
        let mut config = self.config.clone();
        config.solver.thorough = true;
        let solve = || {
            let begin = Instant::now();
            let outcome = posture::solve(&problem, &config).with_context(named)?;
            anyhow::Ok((outcome, begin.elapsed().as_secs_f64() * 1e6))
        };
        let (outcome, first_us) = solve()?;
        let mut times_us = vec![first_us];
        for _ in 1..self.repeat {
            times_us.push(solve()?.1);
        }
        let mut explanation = None;
        if self.explain && outcome.posture().is_none() {
            let explained = posture::explain(&problem, self.config).with_context(named)?;
            explanation = explained.map(|e| e.words);
        }
        let mut answer = Answer {
            expected: record.expected,
            explanation,
            us: quantile(&mut times_us, 0.5),
            ..Answer::new(&record.id, &outcome, &problem, self.robot)
        };
        if self.explain && matches!(outcome, Outcome::Infeasible(_)) {
            answer.prove(posture::refutation(&problem, &config), self.robot);
        }
        Ok(answer)
    }
}

impl<'a> Answer<'a> {
    /// Keeps a proof that `verify` finds to hold; without one nothing is decided.
    fn prove(&mut self, refutation: Option<plan::Refutation>, robot: &Robot) {
        let check = |refutation| verify::refuted(refutation, robot);
        let held = refutation.as_ref().map_or(Err("none".into()), check);
        match held {
            Ok(_) => self.refutation = refutation,
            Err(why) => {
                self.outcome = "undecided";
                let reason = self.reason.get_or_insert_default();
                reason.push_str(&format!(" (its proof does not hold: {why})"));
            }
        }
    }

    /// What an outcome says.
    pub fn new(
        id: &'a serde_json::Value,
        outcome: &Outcome,
        problem: &Problem,
        robot: &'a Robot,
    ) -> Self {
        let (found, violation) = (outcome.posture(), outcome.violation());
        Self {
            id,
            outcome: match &outcome {
                Outcome::Feasible(_) => FEASIBLE,
                Outcome::Infeasible(_) => "infeasible",
                Outcome::Undecided { .. } => "undecided",
            },
            expected: None,
            explanation: None,
            refutation: None,
            reason: violation.map(|v| v.describe(problem)),
            violation: violation.map(|v| v.amount),
            q: found.map(|posture| posture.q.to_q()),
            forces: found.map(|posture| forces(posture, &problem.contacts, robot)),
            margins: found.map(|posture| posture.margins),
            iterations: found.map(|posture| posture.iterations),
            us: 0.0,
        }
    }
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
