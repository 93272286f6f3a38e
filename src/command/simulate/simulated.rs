//! The simulation that `scandent simulate` asks for.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail};
use plan::Motion;
use robot_model::Robot;
use simulation::execution::execute;
use simulation::mjcf;
use simulation::outcome::Executed;
use simulation::perturbation::{Kinds, Perturbation};
use simulation::physics::{Physics, Scales, Servo};
use simulation::playback::Playback;
use simulation::world::WorldBody;

use super::{Args, Perturb, Simulated, World};
use crate::cli::Global;
use crate::config::Config;
use crate::pipeline::MOTION_FILE;
use crate::plan_file::PlanRobotFlags;
use crate::robot_files::Robots;
use crate::simulate::report::{Report, SIMULATION_FORMAT};
use crate::simulate::trace::Trace;
use crate::simulate::{
    self,
    execute::robust_runs,
    hold::{HOLDS, hold_all},
    table,
};
use crate::told::Told;
use crate::{output, plan_file, provenance, threads};

/// Time between two rows of the trace, s.
const TRACE_EVERY_S: f64 = 0.01;
/// Time between two pictures, s.
const FRAME_EVERY_S: f64 = 0.04;

/// Simulates; Ctrl-C or whoever raises `cancel` stops it between two runs.
///
/// # Errors
/// A plan, a motion or a robot that cannot be read or simulated; that it was stopped.
pub fn simulate(
    args: &Args,
    global: &Global,
    cancel: &AtomicBool,
    robots: &Robots,
    told: &mut Told,
) -> Result<Simulated> {
    if let Some(file) = &args.video {
        simulate::video::check(file).context("--video")?;
    }
    let plan = plan_file::open(&args.plan)?;
    let (mut robot, _) = args.robot.load_noted(&plan, robots)?;
    simulate::stance::apply_friction(&mut robot, &plan)?;
    let config = Config::layered(None, global)?;
    let (world, true_world) = match &args.mesh {
        Some(mesh) => (simulate::world::of_mesh(mesh, &plan.faces, &config)?, true),
        None => simulate::world::world(&plan, args.world)?,
    };
    let (seed, config) = (config.seed, config.simulation);
    let pool = threads::pool(global.threads)?;
    let mut report = Report {
        format: SIMULATION_FORMAT,
        program: crate::program(),
        plan_sha256: provenance::sha256(&provenance::read("plan", &args.plan)?),
        motion_sha256: None,
        true_world,
        seed,
        config: config.clone(),
        stances: Vec::new(),
        execution: None,
        robust: Vec::new(),
        robustness: Vec::new(),
        pass: true,
    };
    let (mut trace, mut failures) = (None, Vec::new());
    let which = ["as planned", "the true ones"][usize::from(true_world)];
    writeln!(told, "world: {} bodies, {which}", world.len())?;
    if !args.execute {
        let holds = HOLDS * plan.stances.len();
        let held = told.counting("holding the stances", holds, |done| {
            pool.install(|| hold_all(&plan, &robot, &world, &config, cancel, done))
        })?;
        write!(told, "{}", table::of_stances(&held))?;
        let failed = held.iter().filter(|held| !held.pass());
        failures.extend(failed.map(table::failures_of_stance));
        report.stances = held;
    }
    if !args.hold
        && let Some((motion, sha256)) = motion(args)?
    {
        report.motion_sha256 = Some(sha256);
        let playback = Playback::new(&robot, motion)?;
        let mut rows = Trace::new(&robot, TRACE_EVERY_S);
        let execute = || plain(&robot, &world, &playback, &config, args, &mut rows);
        let executed = told.during("executing the motion", execute)?;
        trace = Some(rows.text().to_owned());
        let title = "executed as planned";
        write!(told, "{}", table::of_run(title, &executed.criteria))?;
        failures.extend(table::failures(&executed.criteria));
        report.execution = Some(executed);
        if !args.perturb.is_empty() {
            let kinds = kinds(&args.perturb);
            let (runs, asked) = (args.runs, (&config, kinds, seed));
            let stage = "executing it perturbed";
            report.robust = told.counting(stage, runs as usize, |done| {
                let world = &world;
                pool.install(|| robust_runs(&robot, world, &playback, asked, runs, cancel, done))
            })?;
            write!(told, "{}", table::of_robust(&report.robust))?;
            let robustness = table::robust(&report.robust);
            write!(told, "{}", table::of_run("all of them", &robustness))?;
            failures.extend(table::failures(&robustness));
            report.robustness = robustness.into();
        }
    }
    report.pass = failures.is_empty();
    Ok(Simulated {
        json: output::json(&report)?,
        trace,
        robot: robot.name,
        failures,
    })
}

/// The robot of a plan in its world as a model of MuJoCo's, with stiff servos at the joints.
///
/// # Errors
/// A plan or a robot that cannot be read or simulated.
pub fn model(plan: &Path) -> Result<String> {
    let plan = plan_file::open(plan)?;
    let mut robot = PlanRobotFlags::default().load(&plan)?;
    simulate::stance::apply_friction(&mut robot, &plan)?;
    let (world, _) = simulate::world::world(&plan, World::Known)?;
    let physics = Physics::from(&simulation::Config::default());
    let scales = Scales::default();
    Ok(mjcf::model(
        &robot,
        &world,
        &physics,
        Servo::STIFF,
        &scales,
    )?)
}

/// The run as planned, with its trace and pictures.
fn plain(
    robot: &Robot,
    world: &[WorldBody],
    playback: &Playback,
    config: &simulation::Config,
    args: &Args,
    trace: &mut Trace,
) -> Result<Executed> {
    let undisturbed = Perturbation::default();
    // Pictures that only the video is made of are not kept.
    let passing = tempfile::tempdir()?;
    let folder = match (&args.frames, &args.video) {
        (Some(folder), _) => Some(folder.as_path()),
        (None, Some(_)) => Some(passing.path()),
        (None, None) => None,
    };
    let executed = match folder {
        None => execute(robot, world, playback, config, &undisturbed, trace)?,
        Some(folder) => drawn(robot, world, playback, config, folder, trace)
            .context("pictures of the motion")?,
    };
    if let (Some(file), Some(folder)) = (&args.video, folder) {
        simulate::video::encode(folder, FRAME_EVERY_S, file).context("--video")?;
    }
    Ok(executed)
}

#[cfg(feature = "render")]
fn drawn(
    robot: &Robot,
    world: &[WorldBody],
    playback: &Playback,
    config: &simulation::Config,
    folder: &Path,
    trace: &mut Trace,
) -> Result<Executed> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let mut pictures = simulation::picture::Pictures::new(folder, FRAME_EVERY_S);
    let mut both = (trace, &mut pictures);
    let still = Perturbation::default();
    Ok(execute(robot, world, playback, config, &still, &mut both)?)
}

#[cfg(not(feature = "render"))]
fn drawn(
    _: &Robot,
    _: &[WorldBody],
    _: &Playback,
    _: &simulation::Config,
    _: &Path,
    _: &mut Trace,
) -> Result<Executed> {
    bail!("this program was built without pictures: build it with --features render")
}

/// The motion and its hash; `None` where none is named and none lies beside the plan.
fn motion(args: &Args) -> Result<Option<(Motion, String)>> {
    let path = match &args.motion {
        Some(path) => path.clone(),
        None => args.plan.with_file_name(MOTION_FILE),
    };
    if args.motion.is_none() && !path.exists() {
        if args.execute || !args.perturb.is_empty() {
            bail!("{}: there is no motion to execute", path.display());
        }
        return Ok(None);
    }
    let bytes = provenance::read("motion", &path)?;
    let motion: Motion = serde_json::from_slice(&bytes)
        .with_context(|| format!("{}: not a motion", path.display()))?;
    Ok(Some((motion, provenance::sha256(&bytes))))
}

fn kinds(perturb: &[Perturb]) -> Kinds {
    let any = |kind: Perturb| perturb.contains(&kind) || perturb.contains(&Perturb::All);
    Kinds {
        friction: any(Perturb::Friction),
        mass: any(Perturb::Mass),
        surfaces: any(Perturb::Surfaces),
        pushes: any(Perturb::Pushes),
        sensing: any(Perturb::Sensing),
    }
}
