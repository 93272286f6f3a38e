//! The world of a plan, found again from the files that it names.

use std::path::Path;

use anyhow::{Context, Result};
use plan::{Input, Motion, Plan};
use robot_model::Robot;
use verify::World;

use crate::cli::Global;
use crate::command;
use crate::config::{Config, differing};
use crate::extrinsics::placement;
use crate::plan_file::{PlanRobotFlags, located};
use crate::posed;
use crate::provenance::{FLAGS, Inputs};
use crate::report::Stages;
use crate::robot_files::Robots;
use crate::scene::{Environment, Scene};
use crate::{threads, unseen};

/// The robot and the world that a plan in a folder is checked against: of the scene that `named` is, or that
/// a folder of this name holds; else of what the plan itself says it was asked for, as far as its files are
/// there.
///
/// # Errors
/// Files of the robot that cannot be read; with `named` whatever cannot be found again.
pub fn find(
    plan: &Plan,
    motion: Option<&Motion>,
    folder: &Path,
    named: Option<&str>,
    flags: &PlanRobotFlags,
    global: &Global,
) -> Result<(Robot, World)> {
    let mut world = World::default();
    let mut inputs = Inputs::default();
    let found = match named {
        Some(named) => {
            let name = in_folder(named, role(plan, "scene"))?;
            let mut scene = Scene::open(&name, &mut inputs)?;
            mount(plan, folder, &mut scene, global, &mut inputs)?;
            Some(again((plan, motion), &scene, inputs, global)?)
        }
        None => {
            let scene = asked(plan, folder, global, &mut inputs);
            match scene.and_then(|scene| again((plan, motion), &scene, inputs, global)) {
                Ok(found) => Some(found),
                Err(error) => {
                    world.leaves_open(format!("if world and task are right: {error:#}"));
                    None
                }
            }
        }
    };
    let is_found = found.is_some();
    let (robot, mut world) = match found {
        Some((robot, found)) if !flags.any() => (robot, found),
        found => {
            let mut world = found.map_or(world, |(_, found)| found);
            let (robot, other) = flags.load_noted(plan, &Robots::default())?;
            for file in other {
                world.leaves_open(format!("if the robot is that of {file}: not the plan's"));
            }
            (robot, world)
        }
    };
    if (named.is_some() || !is_found) && role(plan, FLAGS).is_some() {
        world.leaves_open("if flags beside the scene asked for what is wanted");
        world.may_be_overridden();
    }
    Ok((robot, world))
}

fn role<'a>(plan: &'a Plan, role: &str) -> Option<&'a Input> {
    plan.inputs.iter().find(|input| input.role == role)
}

/// The scene that a plan names, or that its flags ask for.
fn asked(plan: &Plan, folder: &Path, global: &Global, inputs: &mut Inputs) -> Result<Scene> {
    if let Some(flags) = role(plan, FLAGS) {
        return command::plan::again(&flags.name, folder, global, inputs);
    }
    let scene = role(plan, "scene").context("the plan names no scene")?;
    let mut scene = match scene.name.strip_prefix("builtin:") {
        Some(name) => Scene::open(name, inputs)?,
        None => {
            let path = located(folder, Path::new(&scene.name))?;
            Scene::open(&path.display().to_string(), inputs)?
        }
    };
    mount(plan, folder, &mut scene, global, inputs)?;
    Ok(scene)
}

/// Puts the scans of a scene where their mounts say, or the one that was given beside the scene.
fn mount(
    plan: &Plan,
    folder: &Path,
    scene: &mut Scene,
    global: &Global,
    inputs: &mut Inputs,
) -> Result<()> {
    let given = match &scene.environment {
        Environment::Scans(sources) if sources.iter().all(|s| s.extrinsics.is_none()) => {
            role(plan, "extrinsics")
        }
        _ => None,
    };
    let given = given.map(|given| located(folder, Path::new(&given.name)));
    placement::place(scene, given.transpose()?.as_deref(), global, inputs)
}

/// The plan's scene in a folder of that name, or the scene of a name.
fn in_folder(named: &str, scene: Option<&Input>) -> Result<String> {
    if !Path::new(named).is_dir() {
        return Ok(named.to_owned());
    }
    let scene = scene.context("the plan names no scene: nothing to hold it against")?;
    let file = Path::new(&scene.name).file_name();
    let file = file.with_context(|| format!("{}: no name of a file", scene.name))?;
    Ok(Path::new(named).join(file).display().to_string())
}

/// The robot and the world of a scene, by the settings of the plan; those that are not the scene's own
/// are told.
fn again(
    (plan, motion): (&Plan, Option<&Motion>),
    scene: &Scene,
    mut inputs: Inputs,
    global: &Global,
) -> Result<(Robot, World)> {
    let config = serde_json::from_value(plan.config.clone());
    let config: Config = config.context("the plan's settings")?;
    let pool = threads::pool(global.threads)?;
    let (mut stages, robots) = (Stages::default(), Robots::default());
    let posed = posed::pose(scene, &config, &pool, &mut stages, &mut inputs, &robots)?;
    let mut world = posed.world(&config, &scene.name)?;
    let unseen = unseen::unseen(plan, motion, &posed.robot, &posed.looked)?;
    unseen.iter().for_each(|unseen| unseen.tell(&mut world));
    world.rests_on(inputs.into_list());
    let own = Config::layered(Some((&scene.name, &scene.settings)), &Global::default())?;
    let own = serde_json::to_value(&own).context("the scene's settings")?;
    let mut other = Vec::new();
    differing(&plan.config, &own, "", &mut other);
    other.retain(|setting| {
        !BEARS_ON_NOTHING
            .iter()
            .any(|table| setting.starts_with(table))
    });
    if !other.is_empty() {
        let other = other.join(", ");
        world.leaves_open(format!(
            "if these settings, which are not the scene's, are wanted: {other}"
        ));
    }
    Ok((posed.robot, world))
}

/// Settings of how a plan was found, not of what it promises.
const BEARS_ON_NOTHING: [&str; 5] = [
    "seed",
    "planner.",
    "export.",
    "simulation.",
    "posture.restarts",
];
