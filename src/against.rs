//! The world of a plan, found again from the files that it names.

use std::path::Path;

use anyhow::{Context, Result};
use plan::{Input, Plan};
use robot_model::Robot;
use verify::World;

use crate::cli::Global;
use crate::config::Config;
use crate::extrinsics::placement;
use crate::plan_file::PlanRobotFlags;
use crate::posed;
use crate::provenance::{FLAGS, Inputs};
use crate::report::Stages;
use crate::scene::{Environment, Scene};
use crate::threads;

/// The robot and the world that a plan is checked against: of the scene that `named` is, or that a folder
/// of this name holds; else of the one that the plan names, as far as its files are there.
///
/// # Errors
/// Files of the robot that cannot be read; with `named` whatever cannot be found again.
pub fn find(
    plan: &Plan,
    named: Option<&str>,
    flags: &PlanRobotFlags,
    global: &Global,
) -> Result<(Robot, World)> {
    let mut world = World::default();
    let scene = plan.inputs.iter().find(|input| input.role == "scene");
    let found = match (named, scene) {
        (Some(named), scene) => Some(again(plan, &in_folder(named, scene)?, global)?),
        (None, Some(scene)) => {
            let name = scene.name.strip_prefix("builtin:").unwrap_or(&scene.name);
            match again(plan, name, global) {
                Ok(found) => Some(found),
                Err(error) => {
                    world.leaves_open(format!("if world and task are right: {error:#}"));
                    None
                }
            }
        }
        (None, None) => {
            world.leaves_open("if world and task are right: the plan names no scene");
            None
        }
    };
    let (robot, mut world) = match found {
        Some((robot, found)) if !flags.any() => (robot, found),
        found => {
            let mut world = found.map_or(world, |(_, found)| found);
            let (robot, other) = flags.load_noted(plan)?;
            for file in other {
                world.leaves_open(format!("if the robot is that of {file}: not the plan's"));
            }
            (robot, world)
        }
    };
    if plan.inputs.iter().any(|input| input.role == FLAGS) {
        world.leaves_open("if flags beside the scene asked for what is wanted");
        world.may_be_overridden();
    }
    Ok((robot, world))
}

/// The scene of a name, or the plan's scene in a folder of that name.
fn in_folder(named: &str, scene: Option<&Input>) -> Result<String> {
    if !Path::new(named).is_dir() {
        return Ok(named.to_owned());
    }
    let scene = scene.context("the plan names no scene: nothing to hold it against")?;
    let file = Path::new(&scene.name).file_name();
    let file = file.with_context(|| format!("{}: no name of a file", scene.name))?;
    Ok(Path::new(named).join(file).display().to_string())
}

/// The robot and the world of a scene, by the settings of the plan.
fn again(plan: &Plan, scene: &str, global: &Global) -> Result<(Robot, World)> {
    let config = serde_json::from_value(plan.config.clone());
    let config: Config = config.context("the plan's settings")?;
    let mut inputs = Inputs::default();
    let mut scene = Scene::open(scene, &mut inputs)?;
    // A mount that was given beside the scene.
    let mount = match &scene.environment {
        Environment::Scans(sources) if sources.iter().all(|s| s.extrinsics.is_none()) => {
            let mut inputs = plan.inputs.iter();
            inputs.find(|input| input.role == "extrinsics")
        }
        _ => None,
    };
    placement::place(
        &mut scene,
        mount.map(|m| Path::new(&m.name)),
        global,
        &mut inputs,
    )?;
    let pool = threads::pool(global.threads)?;
    let posed = posed::pose(&scene, &config, &pool, &mut Stages::default(), &mut inputs)?;
    let mut world = posed.world(&config, &scene.name)?;
    world.rests_on(inputs.into_list());
    Ok((posed.robot, world))
}
