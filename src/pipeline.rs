//! The way of one scan: from a scene to a verified plan.

mod around;
mod attempt;

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, anyhow};
use plan::{Motion, Plan, Trace};
use planner::{Progress, SearchResult, Status};
use robot_model::Robot;
use surfaces::Terrain;
use verify::Certificate;

use crate::config::Config;
use crate::posed::{self, Posed};
use crate::provenance::Inputs;
use crate::report::{Report, Stages, peak_memory_mb};
use crate::robot_files::Robots;
use crate::scene::Scene;
use crate::unseen::{Around, Unseen};
use crate::{goal, roles, start, threads, unsolved};
use attempt::{Run, Told};

/// Name of the file of a plan's motion, in the plan's folder.
pub const MOTION_FILE: &str = "motion.json";

/// How a plan is computed, beside what.
pub struct RunOptions<'a> {
    /// Threads; one a processor where there is no number.
    pub threads: Option<NonZeroUsize>,
    /// Called with what is done next: reading, searching, verifying.
    pub stage: &'a (dyn Fn(&str) + Sync),
    /// Called as the search goes on.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
    /// Stops the search.
    pub cancel: &'a AtomicBool,
    /// Robots that were read before.
    pub robots: &'a Robots,
}

/// What came of a scene.
pub struct PlanOutcome {
    /// How the search ended.
    pub status: Status,
    /// The plan, or the way to the contact set nearest to the goal where there is none.
    pub plan: Plan,
    /// The motion between its stances, where there is one.
    pub motion: Option<Motion>,
    /// The motion as it is written: the bytes that the plan's hash is of.
    pub motion_json: Vec<u8>,
    /// What the search tried for it.
    pub trace: Trace,
    /// The verifier's verdict on it.
    pub certificate: Certificate,
    /// The terrain as it was extracted, without the ground under the start.
    pub extracted: Terrain,
    /// The scans' points in W, m.
    pub cloud_W: Vec<[f32; 3]>,
    /// The robot.
    pub robot: Robot,
    /// The settings.
    pub config: Config,
    /// Times and sizes.
    pub report: Report,
    /// What was found and assumed on the way, for the user.
    pub notes: Vec<String>,
    /// Why faces serve no patch with a role, for who wonders why there is no plan.
    pub unusable: Vec<String>,
}

impl PlanOutcome {
    /// Whether there is a plan that the verifier passes.
    pub fn verified(&self) -> bool {
        self.status == Status::Found && self.certificate.pass
    }
}

/// Plans for a scene and verifies the plan.
///
/// # Errors
/// A file that cannot be used, a start that is no stance, a goal that names what is not there; that
/// no plan exists is a [`Status`].
pub fn plan(
    scene: &Scene,
    config: &Config,
    options: &RunOptions,
    mut inputs: Inputs,
) -> Result<PlanOutcome> {
    let mut stages = Stages::default();
    let pool = threads::pool(options.threads)?;

    (options.stage)("reading the surroundings and the robot");
    // Scan, robot, start, goal → what is to be planned.
    let posed = posed::pose(
        scene,
        config,
        &pool,
        &mut stages,
        &mut inputs,
        options.robots,
    )?;
    let Posed {
        robot,
        environment,
        start,
        goal,
        ..
    } = &posed;
    let contacts = &start.contacts;
    let standing_on = contacts.iter().find(|c| start.feet.contains(&c.0));
    let standing_on = standing_on.map(|c| c.1);
    let guide = scene.guide.as_ref();
    let guide = goal::guide(guide, goal, (robot, &posed.stand), environment, standing_on)?;
    let roles = &config.surfaces.roles;
    let edge_sigmas = config.posture.edge_sigmas;
    let usable = roles::usable(
        robot,
        environment,
        [contacts, &goal.contacts],
        roles,
        edge_sigmas,
    );

    let (faces, stands) = (posed.terrain.faces.len(), contacts.len());
    tracing::info!(
        "{}: {faces} faces, {stands} contacts at the start",
        robot.name
    );
    for note in &posed.notes {
        tracing::info!("{note}");
    }
    (options.stage)("searching");
    let mut run = Run {
        scene,
        config,
        options,
        pool: &pool,
        posed: &posed,
        guide,
        usable: usable.faces,
        inputs: inputs.into_list(),
        stages,
    };
    // Request → stances and the motion between them.
    let found = run.search(environment, &config.planner, None);
    let found = found.map_err(|error| {
        let is_start = matches!(error, planner::Error::Start { .. });
        let stands = (&posed.stand.configuration, &contacts[..]);
        let clearance_m = config.posture.clearance_m;
        let clear = || start::clear::hint(robot, environment, stands, &scene.start, clearance_m);
        let hint = is_start.then(clear);
        let error = match hint.flatten() {
            Some(hint) => anyhow!("{error}; {hint}"),
            None => error.into(),
        };
        posed::doubted(error, &posed.notes)
    })?;
    let (told, around) = run.around_walls(found)?;

    let Told {
        answer,
        mut plan,
        motion_json,
        through,
        certificate,
    } = told;
    let (status, blocked) = (answer.status, &answer.blocked);
    plan.search.unsolved = unsolved::unsolved(status, blocked, &plan, &certificate, config);
    let (stages, threads) = (run.stages, pool.current_num_threads());
    let report = report(&answer, &plan, (through, around), stages, threads);
    Ok(PlanOutcome {
        status: answer.status,
        plan,
        motion: answer.motion,
        trace: answer.trace,
        motion_json,
        certificate,
        extracted: posed.extracted,
        cloud_W: posed.cloud_W,
        robot: posed.robot,
        config: config.clone(),
        report,
        notes: posed.notes,
        unusable: usable.notes,
    })
}

fn report(
    answer: &SearchResult,
    plan: &Plan,
    (unseen, around): (Option<Unseen>, Option<Around>),
    stages: Stages,
    threads: usize,
) -> Report {
    let unsolved = plan.search.unsolved.clone();
    let status = unsolved.as_ref().map_or("verified", |u| u.status.as_str());
    Report {
        status: status.to_owned(),
        unsolved,
        stages_ms: stages.ms,
        surfaces: plan.faces.len(),
        nodes_generated: answer.summary.nodes_generated,
        nodes_expanded: answer.summary.nodes_expanded,
        path_stances: match answer.status {
            Status::Found => answer.summary.path_stances,
            _ => 0,
        },
        motion_s: plan.motion.as_ref().map_or(0.0, |m| m.duration_s),
        unseen,
        around,
        threads,
        peak_memory_mb: peak_memory_mb(),
    }
}
