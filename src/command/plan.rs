//! `scandent plan`: the pipeline on what the command line names, or on a scene.toml.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use scenes::scene_file::{Friction, Goal, GoalContact, Guide};

use super::run::plan_with_progress;
use crate::argument::{self, GoalFlag, GoalPosture};
use crate::cli::{Cli, Command, Global};
use crate::environment_flags::ScanFlags;
use crate::extrinsics::placement;
use crate::plan_file::located;
use crate::provenance::{FLAGS, Inputs};
use crate::robot_files::{BesideUrdf, RobotFiles};
use crate::scene::{Environment, Files, Scene, Start};
use crate::start_flags::StartFlags;
use crate::status::{Status, UsageError};
use crate::told::Told;

/// Name of a plan without a scene.
const NAME: &str = "plan";

/// Flags of `plan`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.toml or a scene that ships; the flags below replace what it says
    scene: Option<String>,
    /// Surfaces that were extracted before
    #[arg(long, value_name = "SURFACES.json", group = "environment")]
    surfaces: Option<PathBuf>,
    /// Scans: depth images (16-bit PNG, TIFF, npy, npz), point clouds (npy, npz, PCD, PLY, LAS, E57, text) or ROS 2 bags (MCAP)
    #[arg(long, value_name = "SCAN", num_args = 1.., group = "environment")]
    scan: Vec<PathBuf>,
    /// A mesh of the environment (STL, OBJ, PLY, DAE, glTF)
    #[arg(long, value_name = "MESH", value_parser = argument::file, group = "environment")]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    how: ScanFlags,
    /// Take the sensor's place from this file, as `calibrate` writes it: the robot stands as at the
    /// start
    #[arg(long, value_name = "MOUNT.toml", conflicts_with = "pose")]
    extrinsics: Option<PathBuf>,
    /// The robot: a URDF file, - for the standard input, or builtin:NAME (default: builtin:hrp2)
    #[arg(long, value_name = "URDF")]
    robot: Option<String>,
    #[command(flatten)]
    beside: BesideUrdf,
    #[command(flatten)]
    start: StartFlags,
    /// Goal of the base: x,y or x,y,z or x,y,z,yaw
    #[arg(long, value_name = "X,Y[,Z[,YAW]]", value_parser = argument::goal, allow_hyphen_values = true)]
    goal: Option<GoalFlag>,
    /// A contact that the goal must have: PATCH=SURFACE or PATCH=x,y,z (repeatable)
    #[arg(long, value_name = "PATCH=PLACE", value_parser = argument::goal_contact)]
    goal_contact: Vec<GoalContact>,
    /// A posture that the goal must have: one of the SRDF's, or JOINT=VALUE, rad (repeatable)
    #[arg(long, value_name = "NAME|JOINT=RAD", value_parser = argument::goal_posture, allow_hyphen_values = true)]
    goal_posture: Vec<GoalPosture>,
    /// Farthest that the base may be from the goal, m
    #[arg(long, value_name = "M", value_parser = positive)]
    goal_tolerance_m: Option<f64>,
    /// A place that the base should pass: x,y,z (repeatable; default: a straight line)
    #[arg(long, value_name = "X,Y,Z", value_parser = argument::key_posture, allow_hyphen_values = true)]
    guide: Vec<[f64; 4]>,
    /// Coefficient of friction of every patch (default: the contacts file's)
    #[arg(long, value_name = "MU", value_parser = positive)]
    friction: Option<f64>,
    /// Folder of the results
    #[arg(short, long, value_name = "FOLDER", value_parser = argument::folder, default_value = "out/plan")]
    output: PathBuf,
}

/// Plans and writes the results to the folder.
///
/// # Errors
/// As [`super::run::run`]; [`UsageError`] where something needed is not said.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let mut inputs = Inputs::default();
    let scene = args.placed(global, &mut inputs, &said(std::env::args().skip(1)))?;
    plan_with_progress(&scene, inputs, &args.output, global, told)
}

/// The scene that recorded flags ask for; their files are looked for in `beside` and the folders above.
///
/// # Errors
/// What is no such record; files that are not there; else as [`run`].
pub fn again(recorded: &str, beside: &Path, global: &Global, inputs: &mut Inputs) -> Result<Scene> {
    let flags: Vec<String> = serde_json::from_str(recorded).context("no record of flags")?;
    let (mut args, _) = parsed(&flags)?;
    for path in args.paths() {
        *path = located(beside, path)?;
    }
    for name in [&mut args.scene, &mut args.robot].into_iter().flatten() {
        if !name.starts_with("builtin:") && scenes::builtin(name).is_none() {
            *name = located(beside, Path::new(name))?.display().to_string();
        }
    }
    args.placed(global, inputs, recorded)
}

/// The scene and the settings that the flags of `plan` ask for, as if they stood on the command line.
///
/// # Errors
/// As [`run`]; flags that are none.
pub fn asked_by(flags: &[String], inputs: &mut Inputs) -> Result<(Scene, Global)> {
    let (args, global) = parsed(flags)?;
    let scene = args.placed(&global, inputs, &said(flags.iter().cloned()))?;
    Ok((scene, global))
}

/// The settings among flags of `plan`.
///
/// # Errors
/// Flags that are none.
pub fn global_of(flags: &[String]) -> Result<Global> {
    Ok(parsed(flags)?.1)
}

fn parsed(flags: &[String]) -> Result<(Box<Args>, Global)> {
    let cli = Cli::of(flags)?;
    match cli.command {
        Some(Command::Plan(args)) => Ok((args, cli.global)),
        _ => Err(usage("no flags of `plan`")),
    }
}

/// The command line as a plan records it: all that bears on the plan, as a list in JSON.
fn said(flags: impl Iterator<Item = String>) -> String {
    let mut flags = flags.peekable();
    let mut kept = Vec::new();
    while let Some(flag) = flags.next() {
        match flag.as_str() {
            "--json" => {}
            "-o" | "--output" | "--threads" => drop(flags.next()),
            _ if flag.starts_with("-o") => {}
            _ if flag.starts_with("--output=") || flag.starts_with("--threads=") => {}
            _ => kept.push(flag),
        }
    }
    serde_json::Value::from(kept).to_string()
}

impl Args {
    /// The scene with what the flags say; they are noted, as `said`, where a scene's file alone does not
    /// say what was asked.
    fn placed(&self, global: &Global, inputs: &mut Inputs, said: &str) -> Result<Scene> {
        let (before, mut scene) = match &self.scene {
            Some(name) => {
                let scene = Scene::open(name, inputs)?;
                (asked(&scene), self.over(scene, inputs)?)
            }
            None => (String::new(), self.over(self.bare()?, inputs)?),
        };
        if asked(&scene) != before {
            inputs.note(FLAGS, said, said.as_bytes());
        }
        placement::place(&mut scene, self.extrinsics.as_deref(), global, inputs)?;
        Ok(scene)
    }

    /// The files that flags name.
    fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let one = [&mut self.surfaces, &mut self.mesh, &mut self.extrinsics];
        let beside = [&mut self.beside.srdf, &mut self.beside.contacts];
        let earlier = self.start.start_stance.as_mut().map(|(plan, _)| plan);
        one.into_iter()
            .chain(beside)
            .flatten()
            .chain(earlier)
            .chain(&mut self.scan)
            .chain(self.how.paths())
    }

    /// A scene of defaults; what has none must be among the flags.
    fn bare(&self) -> Result<Scene> {
        if self.surfaces.is_none() && self.mesh.is_none() && self.scan.is_empty() {
            let wanted = "give a scene, or one of --surfaces, --scan and --mesh";
            return Err(usage(wanted));
        }
        if !self.has_goal() {
            return Err(usage(
                "give a scene, or --goal, --goal-contact or --goal-posture",
            ));
        }
        Ok(Scene {
            name: NAME.to_owned(),
            environment: Environment::Scans(Vec::new()),
            mounts: Vec::new(),
            robot: RobotFiles::named("builtin:hrp2"),
            start: Start::default(),
            goal: Goal::default(),
            guide: None,
            friction: Friction::default(),
            settings: toml::Table::new(),
            files: Files::Folder(PathBuf::new()),
        })
    }

    /// The environment that the flags name.
    fn environment(&self, inputs: &mut Inputs) -> Result<Option<Environment>> {
        let named = |path: &PathBuf| path.display().to_string();
        Ok(match (&self.surfaces, &self.mesh) {
            (Some(path), _) => Some(Environment::Surfaces(named(path))),
            (None, Some(path)) => Some(Environment::Mesh(named(path))),
            (None, None) if !self.scan.is_empty() => Some(self.how.scans(&self.scan, inputs)?),
            (None, None) => None,
        })
    }

    /// The scene with what the flags say in the place of what it said.
    fn over(&self, mut scene: Scene, inputs: &mut Inputs) -> Result<Scene> {
        if let Some(environment) = self.environment(inputs)? {
            scene.environment = environment;
            scene.files = Files::Folder(PathBuf::new());
        } else if self.how.sensor.is_some() || !self.how.pose.is_empty() {
            return Err(usage("--sensor and --pose belong to --scan"));
        }
        if let Some(urdf) = &self.robot {
            // Another robot does not have the postures and patches of the scene's.
            scene.robot = RobotFiles::named(urdf);
        }
        let (given, beside) = (&self.beside, &mut scene.robot.beside);
        if given.srdf.is_some() {
            beside.srdf.clone_from(&given.srdf);
        }
        if given.contacts.is_some() {
            beside.contacts.clone_from(&given.contacts);
        }
        beside.packages.extend_from_slice(&given.packages);
        self.start.over(&mut scene.start, inputs)?;
        self.over_goal(&mut scene.goal);
        if !self.guide.is_empty() {
            scene.guide = Some(Guide {
                key_postures: self.guide.clone(),
            });
        }
        if let Some(friction) = self.friction {
            scene.friction = Friction {
                default: Some(friction),
                ..Friction::default()
            };
        }
        Ok(scene)
    }

    fn has_goal(&self) -> bool {
        self.goal.is_some() || !self.goal_contact.is_empty() || !self.goal_posture.is_empty()
    }

    fn over_goal(&self, goal: &mut Goal) {
        if self.has_goal() {
            *goal = Goal {
                tolerance_m: goal.tolerance_m,
                joint_tolerance_rad: goal.joint_tolerance_rad,
                ..Goal::default()
            };
        }
        if let Some(flag) = &self.goal {
            goal.base_position_m = Some(flag.position_m.clone());
            goal.yaw_rad = flag.yaw_rad;
        }
        goal.contact.extend(self.goal_contact.iter().cloned());
        for wanted in &self.goal_posture {
            match wanted {
                GoalPosture::Named(name) => goal.posture = Some(name.clone()),
                GoalPosture::Joint(joint, value) => {
                    goal.joints_rad.insert(joint.clone(), *value);
                }
            }
        }
        if let Some(tolerance_m) = self.goal_tolerance_m {
            goal.tolerance_m = tolerance_m;
        }
    }
}

/// All that flags may replace of a scene.
fn asked(scene: &Scene) -> String {
    let places = (&scene.environment, &scene.robot, &scene.start);
    format!("{:?}", (places, &scene.goal, &scene.guide, &scene.friction))
}

fn usage(cause: &str) -> anyhow::Error {
    anyhow!(UsageError(cause.to_owned()))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("not a positive number".to_owned()),
    }
}
