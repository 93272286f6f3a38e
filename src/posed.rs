//! A scene before its search: what is there, where the robot stands, and what it shall do.
//!
//! Planning begins with it, and `verify` finds it again to hold a plan against.

use anyhow::{Context, Result, bail};
use plan::{RequiredMargins, RobotSummary};
use posture::{Environment, FaceIndex};
use robot_model::{Kinematics, PatchId, Robot};
use surfaces::{FaceId, LookedThrough, Terrain};
use verify::World;

use crate::config::Config;
use crate::environment::{self, Perceived, levelled};
use crate::goal;
use crate::mistakes;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::robot_files::Robots;
use crate::scene::{self, Scene};
use crate::start::{self, StartState, agreement, assumed, clear_of_world, ground};

/// What a scene asks of which robot, in which environment.
pub struct Posed {
    /// The robot, with the scene's friction.
    pub robot: Robot,
    /// The terrain as it was extracted, without the ground under the start.
    pub extracted: Terrain,
    /// The terrain.
    pub terrain: Terrain,
    /// The scans' points in W, m.
    pub cloud_W: Vec<[f32; 3]>,
    /// What each scan looked through.
    pub looked: Vec<LookedThrough>,
    /// The terrain with the bodies behind it.
    pub environment: Environment,
    /// How the robot stands at the start.
    pub stand: StartState,
    /// Where that is for the planner, on what.
    pub start: planner::Start,
    /// The goal.
    pub goal: planner::Goal,
    /// What was found and assumed on the way, for the user.
    pub notes: Vec<String>,
}

/// Reads a scene's files, extracts its surfaces and stands the robot on them.
///
/// # Errors
/// A file that cannot be used, a start that is no stance, a goal that names what is not there.
pub fn pose(
    scene: &Scene,
    config: &Config,
    pool: &rayon::ThreadPool,
    stages: &mut Stages,
    inputs: &mut Inputs,
    robots: &Robots,
) -> Result<Posed> {
    // Scan → surfaces.
    let seen = surroundings(scene, config, pool, stages, inputs);

    // URDF, SRDF, contacts → robot.
    let robot = stages.measure("robot", || {
        robots.load(&scene.robot, &config.robot_model, inputs)
    });
    let ((environment, perceived), mut robot) = mistakes::both(seen, robot)?;
    let environment = &environment;
    let Perceived {
        terrain: extracted,
        cloud_W,
        looked,
        mut notes,
    } = perceived;
    let friction = apply_friction(&mut robot, scene);
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
        let clearance_m = config.posture.clearance_m;
        let (mut before, mut back) = (None, None);
        if scene.starts_before_floor() {
            before = start::floor::stand_before(&mut stand, &robot, &mut terrain);
            let body = |terrain| Environment::new(terrain, thickness_m, edge_sigmas);
            let room = (clearance_m, config.ground.join_gap_m);
            back = start::clear::step_back(&mut stand, &robot, &terrain, body, room)?;
        }
        let touching = match &scene.start {
            scene::Start::Posture { .. } => {
                start::touching::add_touching(&robot, &mut stand, &terrain)
            }
            _ => None,
        };
        let settled = match &scene.start {
            scene::Start::Posture { base, .. } => {
                let level = base.is_none();
                start::settle::settle(&robot, &mut stand, &terrain, level, &config.posture)?
            }
            _ => None,
        };
        let is_before = scene.starts_before_floor();
        let ground = ground::add_ground(
            &mut terrain,
            &robot,
            (&stand, is_before),
            &config.ground,
            edge_sigmas,
        )?;
        let raised_m = config.motion.swing_height_m;
        let refuted = assumed::drop_refuted(&mut terrain, &robot, &stand, clearance_m, raised_m);
        let said = before
            .into_iter()
            .chain(back)
            .chain(touching)
            .chain(settled)
            .chain(ground.notes);
        anyhow::Ok((
            terrain,
            stand,
            ground.contacts,
            refuted,
            said.collect::<Vec<_>>(),
        ))
    });
    let (terrain, mut stand, ground, refuted, said) = match begin {
        Ok(begin) if friction.is_ok() => begin,
        begin => {
            let seen = Environment::new(extracted, thickness_m, edge_sigmas);
            let seen = seen.map_err(|error| doubted(error.into(), &notes))?;
            let goal = goal::named(&scene.goal, &robot, &seen);
            let wrong = [friction.err(), begin.err(), goal.err()];
            let wrong = mistakes::several(wrong.into_iter().flatten().collect());
            return Err(doubted(wrong, &notes));
        }
    };
    notes.extend(said);
    // The ground that is seen, against the one under the feet.
    if let scene::Environment::Scans(scans) = environment
        && let Some((_, feet)) = ground.first()
    {
        let (feet, camera) = (terrain.get(feet)?, &config.calibration.camera);
        let mounts = &scene.mounts;
        let said = agreement::disagreements(&extracted, scans, mounts, feet, camera);
        notes.extend(said);
    }
    if !refuted.is_empty() {
        notes.push(format!(
            "the robot stands where these would go on beyond the view, or is what was seen: {}",
            refuted.join(", ")
        ));
    }

    // Start, goal, guide, roles → request.
    let environment = Environment::new(terrain.clone(), thickness_m, edge_sigmas);
    let environment = environment.map_err(|error| doubted(error.into(), &notes))?;
    let on = |(patch, face): &(PatchId, FaceId)| Ok((*patch, environment.face(face.as_str())?));
    let contacts: Vec<_> = ground.iter().map(on).collect::<Result<_>>()?;
    let excluded = |patch: PatchId| config.planner.excludes(&robot.patches[patch]);
    let mut start = planner::Start::new(&robot, stand.configuration.clone(), contacts, excluded);
    if let scene::Start::Contacts(_) = scene.start {
        let clear = clear_of_world(
            &robot,
            &start,
            &stand.nominal,
            &environment,
            &config.posture,
        )?;
        start.configuration = clear.unwrap_or(start.configuration);
        stand.configuration.clone_from(&start.configuration);
    }
    let goal = goal::goal(&scene.goal, &robot, &environment, (&start, &config.posture))?;
    Ok(Posed {
        robot,
        extracted,
        terrain,
        cloud_W,
        looked,
        environment,
        stand,
        start,
        goal,
        notes,
    })
}

/// The environment with poses for its scans, and what is seen there.
fn surroundings(
    scene: &Scene,
    config: &Config,
    pool: &rayon::ThreadPool,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<(scene::Environment, Perceived)> {
    let files = &scene.files;
    let (environment, levelled) = levelled::levelled(&scene.environment, files, config)?;
    let mut perceived =
        pool.install(|| environment::perceive(&environment, files, config, stages, inputs))?;
    if let Some(why) = levelled::doubt(&environment, &perceived.terrain) {
        bail!(why);
    }
    perceived.notes.extend(levelled);
    Ok((environment, perceived))
}

/// An error with what was doubted of the faces, which may be why.
pub fn doubted(error: anyhow::Error, notes: &[String]) -> anyhow::Error {
    let doubts = notes.iter().filter(|note| note.starts_with("warning: "));
    doubts.fold(error, |error, doubt| error.context(doubt.clone()))
}

impl Posed {
    /// What a plan for it must say.
    ///
    /// # Errors
    /// What cannot be written as JSON.
    pub fn world(&self, config: &Config, name: &str) -> Result<World> {
        let (robot, terrain) = (&self.robot, &self.terrain);
        let kinematics = Kinematics::new(robot, &self.stand.configuration);
        let on = |&(patch, face): &(PatchId, FaceIndex)| {
            let (face, patch) = (self.environment[face].id.to_string(), &robot.patches[patch]);
            let place = kinematics.X_WC(patch).translation.vector;
            (patch.name.clone(), face, place.into())
        };
        let mut world = World::default();
        world.says("scene", name)?;
        world.says("robot", summary(robot))?;
        world.says("faces", &terrain.faces)?;
        world.says("obstacles", &terrain.obstacles)?;
        world.says("thin_body_m", config.surfaces.body.thickness_m)?;
        world.says("required", RequiredMargins::from(&config.posture))?;
        world.says("goal", goal::record(&self.goal, robot, &self.environment))?;
        world.moves(motion::limits(&config.motion, &config.posture));
        world.starts(self.start.contacts.iter().map(on));
        Ok(world)
    }
}

/// What identifies a robot in a plan.
pub fn summary(robot: &Robot) -> RobotSummary {
    RobotSummary {
        name: robot.name.clone(),
        joint_names: robot.joint_names().map(str::to_owned).collect(),
        mass_kg: robot.mass_kg,
    }
}

/// Puts the scene's coefficients of friction in the place of the contacts file's.
fn apply_friction(robot: &mut Robot, scene: &Scene) -> Result<()> {
    if let Some(friction) = scene.friction.default {
        let patches = robot.patches.iter_mut();
        patches.for_each(|patch| patch.friction = friction);
    }
    mistakes::all(scene.friction.patch.iter().map(|(name, friction)| {
        let patch = robot.patch_index(name).context("friction")?;
        robot.patches[patch].friction = *friction;
        Ok(())
    }))?;
    Ok(())
}
