//! The way of one scan: from a scene to a verified plan.

use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use motion::Motion;
use planner::plan::{MotionFile, PLAN_FORMAT, Plan, RequiredMargins, RobotSummary};
use planner::{Answer, Blocked, Progress, Request, Status};
use posture::Environment;
use robot_model::Robot;
use surfaces::SurfaceSet;

use crate::config::Config;
use crate::environment::{self, Perceived};
use crate::provenance::{self, Inputs};
use crate::report::{Clock, Report, Stages, peak_memory_mb};
use crate::scene::{self, Scene};
use crate::start::{self, agreement, assumed, ground};
use crate::verify::{self, Certificate};
use crate::{goal, roles, threads};

/// Name of the file of a plan's motion, in the plan's folder.
pub const MOTION_FILE: &str = "motion.json";

/// How a plan is computed, beside what.
pub struct Manner<'a> {
    /// Threads; one a processor where there is no number.
    pub threads: Option<NonZeroUsize>,
    /// Called as the search goes on.
    pub progress: &'a (dyn Fn(&Progress) + Sync),
    /// Stops the search.
    pub cancel: &'a AtomicBool,
}

/// What came of a scene.
#[allow(non_snake_case)]
pub struct Planned {
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
    /// What blocks the way, nearest to the goal first; empty where a plan was found.
    pub blocked: Vec<Blocked>,
    /// The surfaces as they were extracted, without the ground under the start.
    pub extracted: SurfaceSet,
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
}

/// Plans for a scene and verifies the plan.
///
/// # Errors
/// A file that cannot be used, a start that is no stance, a goal that names what is not there; that
/// no plan exists is a [`Status`].
pub fn plan(
    scene: &Scene,
    config: &Config,
    manner: &Manner,
    mut inputs: Inputs,
) -> Result<Planned> {
    let mut stages = Stages::default();
    let pool = threads::pool(manner.threads)?;

    // Scan → surfaces.
    let perceived = pool.install(|| {
        environment::perceive(
            &scene.environment,
            &scene.files,
            config,
            &mut stages,
            &mut inputs,
        )
    })?;
    #[allow(non_snake_case)]
    let Perceived {
        set: extracted,
        cloud_W,
        mut notes,
    } = perceived;

    // URDF, SRDF, contacts → robot.
    let robot = stages.measure("robot", || {
        let mut robot = scene.robot.load(&config.robot_model, &mut inputs)?;
        apply_friction(&mut robot, scene)?;
        anyhow::Ok(robot)
    })?;
    notes.extend(robot.notes.iter().cloned());

    // The robot's own feet → the ground under them.
    let begin = stages.measure("start", || {
        let mut set = extracted.clone();
        let stand = start::stand(&robot, &scene.start, &config.posture)?;
        let ground = ground::add_ground(
            &mut set,
            &robot,
            &stand.configuration,
            &stand.patches,
            &config.ground,
        )?;
        let clearance_m = config.posture.clearance_m;
        let refuted = assumed::drop_refuted(&mut set, &robot, &stand.configuration, clearance_m);
        anyhow::Ok((set, stand, ground, refuted))
    });
    let (set, stand, ground, refuted) = begin?;
    notes.extend(ground.notes);
    // The ground that is seen, against the one under the feet.
    if let scene::Environment::Scans(scans) = &scene.environment
        && let Some(feet) = ground.contacts.first().map(|c| &set.surfaces[c.1])
    {
        let (robot, config) = (&config.calibration.camera, &config.ground);
        let mounts = &scene.mounts;
        notes.extend(agreement::disagreements(
            &extracted, scans, mounts, feet, robot, config,
        ));
    }
    if !refuted.is_empty() {
        notes.push(format!(
            "the robot stands where these would go on beyond the view: {}",
            refuted.join(", ")
        ));
    }

    // Start, goal, guide, roles → request.
    let standing_on: Vec<usize> = ground.contacts.iter().map(|c| c.1).collect();
    let goal = goal::goal(&scene.goal, &robot, &set, &stand)?;
    let guide = goal::guide(scene.guide.as_ref(), &goal, &stand, &set, &standing_on)?;
    let usable = roles::usable(&robot, &set, &ground.contacts, &config.surfaces.roles);
    let goal_record = goal::record(&goal, &robot, &set);

    // Request → stances and the motion between them.
    let clock = Clock::new();
    let (environment, answer) = pool.install(|| {
        stages.measure("planning", || {
            let environment = Environment::new(&set, config.surfaces.body.thickness_m)?;
            let request = Request {
                robot: &robot,
                environment: &environment,
                start: planner::Start {
                    configuration: stand.configuration.clone(),
                    contacts: ground.contacts.clone(),
                },
                goal,
                guide,
                usable,
                reference: stand.configuration.clone(),
            };
            let progress = |progress: Progress| {
                clock.note(progress.stage);
                (manner.progress)(&progress);
            };
            let answer = planner::search(
                &request,
                &config.planner,
                &config.posture,
                &config.motion,
                &progress,
                manner.cancel,
            )?;
            anyhow::Ok((environment, answer))
        })
    })?;
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
    let plan = Plan {
        format: PLAN_FORMAT.to_owned(),
        program: crate::program(),
        scene: scene.name.clone(),
        seed: config.seed(),
        config: serde_json::to_value(config).context("the settings")?,
        inputs: inputs.into_list(),
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        surfaces: set.surfaces,
        obstacles: set.obstacles,
        thin_body_m: config.surfaces.body.thickness_m,
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

    let report = report(&answer, &plan, stages, pool.current_num_threads());
    let Answer {
        status,
        blocked,
        motion,
        ..
    } = answer;
    Ok(Planned {
        status,
        plan,
        motion,
        motion_json,
        certificate,
        blocked,
        extracted,
        cloud_W,
        robot,
        config: config.clone(),
        report,
        notes,
    })
}

/// Puts the scene's coefficients of friction in the place of the contacts file's.
fn apply_friction(robot: &mut Robot, scene: &Scene) -> Result<()> {
    if let Some(friction) = scene.friction.default {
        robot
            .patches
            .iter_mut()
            .for_each(|patch| patch.friction = friction);
    }
    for (name, friction) in &scene.friction.patch {
        let patch = robot.patch_index(name).context("friction")?;
        robot.patches[patch].friction = *friction;
    }
    Ok(())
}

fn report(answer: &Answer, plan: &Plan, stages: Stages, threads: usize) -> Report {
    let found = answer.status == Status::Found;
    Report {
        stages_ms: stages.ms,
        surfaces: plan.surfaces.len(),
        nodes_generated: answer.summary.nodes_generated,
        nodes_expanded: answer.summary.nodes_expanded,
        path_stances: if found {
            answer.summary.path_stances
        } else {
            0
        },
        motion_s: plan.motion.as_ref().map_or(0.0, |m| m.duration_s),
        threads,
        peak_memory_mb: peak_memory_mb(),
    }
}
