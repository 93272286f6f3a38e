//! The way of one scan: from a scene to a verified plan.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail};
use plan::{Motion, MotionFile, PLAN_FORMAT, Plan, RequiredMargins, RobotSummary};
use planner::{Progress, Request, SearchResult, Status};
use posture::Environment;
use robot_model::{PatchId, Robot};
use surfaces::{FaceId, Terrain};
use verify::Certificate;

use crate::config::Config;
use crate::environment::{self, Perceived, levelled};
use crate::provenance::{self, Inputs};
use crate::report::{Clock, Report, Stages, peak_memory_mb};
use crate::scene::{self, Scene};
use crate::start::{self, agreement, assumed, ground};
use crate::{goal, roles, threads, unsolved};

/// Name of the file of a plan's motion, in the plan's folder.
pub const MOTION_FILE: &str = "motion.json";

/// How a plan is computed, beside what.
pub struct RunOptions<'a> {
    /// Threads; one a processor where there is no number.
    pub threads: Option<NonZeroUsize>,
    /// Called as the search goes on.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
    /// Stops the search.
    pub cancel: &'a AtomicBool,
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

    // Scan → surfaces.
    let files = &scene.files;
    let (environment, levelled) = levelled::levelled(&scene.environment, files, config)?;
    let environment = &environment;
    let perceived = pool
        .install(|| environment::perceive(environment, files, config, &mut stages, &mut inputs))?;
    let Perceived {
        terrain: extracted,
        cloud_W,
        mut notes,
    } = perceived;
    if let Some(why) = levelled::doubt(environment, &extracted) {
        bail!(why);
    }
    notes.extend(levelled);

    // URDF, SRDF, contacts → robot.
    let robot = stages.measure("robot", || {
        let mut robot = scene.robot.load(&config.robot_model, &mut inputs)?;
        apply_friction(&mut robot, scene)?;
        anyhow::Ok(robot)
    })?;
    notes.extend(robot.notes.iter().cloned());

    // The robot's own feet → the ground under them.
    let edge_sigmas = config.posture.edge_sigmas;
    let thickness_m = config.surfaces.body.thickness_m;
    let begin = stages.measure("start", || {
        let mut terrain = extracted.clone();
        let surroundings = match &scene.start {
            scene::Start::Over { .. } => {
                Environment::new(terrain.clone(), thickness_m, edge_sigmas)?
            }
            _ => Environment::default(),
        };
        let mut stand = start::stand(&robot, &scene.start, &surroundings, &config.posture)?;
        if scene.starts_before_floor() {
            start::floor::stand_before(&mut stand, &robot, &terrain);
        }
        let (posture, feet) = (&stand.configuration, &stand.patches);
        let ground = ground::add_ground(
            &mut terrain,
            &robot,
            posture,
            feet,
            &config.ground,
            edge_sigmas,
        )?;
        let clearance_m = config.posture.clearance_m;
        let refuted = assumed::drop_refuted(&mut terrain, &robot, posture, clearance_m);
        anyhow::Ok((terrain, stand, ground, refuted))
    });
    let (terrain, stand, ground, refuted) = begin?;
    notes.extend(ground.notes);
    // The ground that is seen, against the one under the feet.
    if let scene::Environment::Scans(scans) = environment
        && let Some((_, feet)) = ground.contacts.first()
    {
        let (feet, camera) = (terrain.get(feet)?, &config.calibration.camera);
        let mounts = &scene.mounts;
        let said = agreement::disagreements(&extracted, scans, mounts, feet, camera);
        notes.extend(said);
    }
    if !refuted.is_empty() {
        notes.push(format!(
            "the robot stands where these would go on beyond the view: {}",
            refuted.join(", ")
        ));
    }

    // Start, goal, guide, roles → request.
    let environment = Environment::new(terrain.clone(), thickness_m, edge_sigmas)?;
    let on = |(patch, face): &(PatchId, FaceId)| Ok((*patch, environment.face(face.as_str())?));
    let contacts: Vec<_> = ground.contacts.iter().map(on).collect::<Result<_>>()?;
    let standing_on = contacts.first().map(|c| c.1);
    let goal = goal::goal(&scene.goal, &robot, &environment, &stand)?;
    let guide = scene.guide.as_ref();
    let guide = goal::guide(guide, &goal, &stand, &environment, standing_on)?;
    let roles = &config.surfaces.roles;
    let usable = roles::usable(&robot, &environment, &contacts, roles, edge_sigmas);
    let goal_record = goal::record(&goal, &robot, &environment);

    // Request → stances and the motion between them.
    let clock = Clock::default();
    let request = Request {
        robot: &robot,
        environment: &environment,
        start: planner::Start {
            configuration: stand.configuration.clone(),
            contacts,
        },
        goal,
        guide,
        usable: usable.faces,
        reference: stand.configuration.clone(),
    };
    let progress = |progress: Progress| {
        clock.note(progress.stage);
        (options.progress)(&progress);
    };
    let (planner, posture, motion) = (&config.planner, &config.posture, &config.motion);
    let cancel = options.cancel;
    let search = || planner::search(&request, planner, posture, motion, &progress, cancel);
    let answer = pool.install(|| stages.measure("planning", search))?;
    stages.split("planning", "motion", clock.motion_ms());

    // Motion → file, and the plan that names it.
    let mut motion_json = Vec::new();
    let motion_file = match &answer.motion {
        Some(motion) => {
            motion_json = stages.measure("writing", || serde_json::to_vec(motion))?;
            Some(MotionFile {
                file: MOTION_FILE.to_owned(),
                sha256: provenance::sha256(&motion_json),
                duration_s: motion.duration_s(),
                samples: motion.samples.len(),
            })
        }
        None => None,
    };

    // Stances → plan, and the verdict of code that shares nothing with the search.
    let mut plan = Plan {
        format: PLAN_FORMAT.to_owned(),
        program: crate::program(),
        scene: scene.name.clone(),
        seed: config.seed,
        config: serde_json::to_value(config).context("the settings")?,
        inputs: inputs.into_list(),
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        faces: terrain.faces,
        obstacles: terrain.obstacles,
        thin_body_m: thickness_m,
        required: RequiredMargins::from(&config.posture),
        goal: goal_record,
        stances: planner::record::stances(&robot, &environment, &answer.path),
        motion: motion_file,
        search: answer.summary.clone(),
    };
    let certificate = pool.install(|| {
        stages.measure("verify", || {
            let options = verify::Options::default();
            verify::verify_with(&plan, answer.motion.as_ref(), &robot, &options)
        })
    });

    let (status, blocked) = (answer.status, &answer.blocked);
    plan.search.unsolved = unsolved::unsolved(status, blocked, &certificate, config);
    let report = report(&answer, &plan, stages, pool.current_num_threads());
    Ok(PlanOutcome {
        status: answer.status,
        plan,
        motion: answer.motion,
        motion_json,
        certificate,
        extracted,
        cloud_W,
        robot,
        config: config.clone(),
        report,
        notes,
        unusable: usable.notes,
    })
}

/// Puts the scene's coefficients of friction in the place of the contacts file's.
fn apply_friction(robot: &mut Robot, scene: &Scene) -> Result<()> {
    if let Some(friction) = scene.friction.default {
        let patches = robot.patches.iter_mut();
        patches.for_each(|patch| patch.friction = friction);
    }
    for (name, friction) in &scene.friction.patch {
        let patch = robot.patch_index(name).context("friction")?;
        robot.patches[patch].friction = *friction;
    }
    Ok(())
}

fn report(answer: &SearchResult, plan: &Plan, stages: Stages, threads: usize) -> Report {
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
        threads,
        peak_memory_mb: peak_memory_mb(),
    }
}
