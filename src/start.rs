//! The start: the robot's configuration before its first step, and which patches bear.

pub mod agreement;
pub mod assumed;
pub mod clear;
mod flight;
pub mod floor;
pub mod ground;
pub mod settle;
mod standing;
pub mod touching;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use posture::{Contact, Environment, Outcome, Problem, stand};
use robot_model::propose::looks_backward;
use robot_model::{Configuration, PatchId, Robot};

use crate::mistakes;
use crate::scene::Start;

/// The role of the patches that stand where no patch is named.
const FOOT: &str = "foot";

/// A joint is measured to be beyond its limits by this at most, rad (m where prismatic).
const MEASURED_RAD: f64 = 0.01;

/// Where the robot is and what it stands on.
#[derive(Clone, Debug, PartialEq)]
pub struct StartState {
    /// Base pose and joints.
    pub configuration: Configuration,
    /// The posture that all others are near to, its base aside: as it stands, and where contacts alone say how it
    /// stands (hands on a table, a foot on a step), at rest.
    pub nominal: Configuration,
    /// Patches that touch the ground.
    pub patches: Vec<PatchId>,
    /// The ground that it is put on, its plane z = 0: balls do not tell how it leans.
    pub X_WG: Isometry3<f64>,
}

/// The configuration that a scene's start describes, in these surroundings.
///
/// # Errors
/// An unknown posture or patch, with those that there are; contacts that no posture reaches, with
/// the constraint that fails; a place without ground.
pub fn stand(
    robot: &Robot,
    start: &Start,
    environment: &Environment,
    config: &posture::Config,
) -> Result<StartState> {
    match start {
        Start::Posture {
            name,
            joints,
            base,
            contacts,
            ..
        } => {
            let named = named_posture(robot, name.as_deref(), joints);
            let ((posture, nominal), patches) = mistakes::both(named, patches(robot, contacts))?;
            let configuration = match base {
                Some(base) => posture.with_base(base),
                // It looks ahead, whichever way its base does.
                None => {
                    let turn = f64::from(u8::from(looks_backward(robot))) * PI;
                    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
                    let level = stand::on_level_ground(robot, &posture, &patches);
                    let p_WB = level.p_WB.into();
                    level.with_base(&Isometry3::from_parts(p_WB, turn))
                }
            };
            Ok(StartState {
                nominal: match joints.is_empty() {
                    true => configuration.clone(),
                    false => nominal,
                },
                configuration,
                patches,
                X_WG: Isometry3::identity(),
            })
        }
        Start::Over {
            name,
            joints,
            at_m,
            yaw_rad,
            contacts,
        } => {
            let named = named_posture(robot, name.as_deref(), joints);
            let ((posture, _), feet) = mistakes::both(named, patches(robot, contacts))?;
            let place = (*at_m, *yaw_rad);
            let (contacts, guess) = standing::contacts(robot, environment, &posture, &feet, place)?;
            on_contacts(robot, contacts, &guess, environment, config)
        }
        Start::Contacts(named) => {
            let contacts = named.iter().map(|(name, pose)| {
                let patch = robot.patch_id(name)?;
                Ok(Contact::at(robot, patch, *pose))
            });
            let contacts: Vec<Contact> = mistakes::all(contacts)?;
            let guess = stand::over_contacts(robot, &robot.resting(), &contacts);
            let nominal = robot.resting();
            let nothing = Environment::default();
            let stands = on_contacts(robot, contacts, &guess, &nothing, config)?;
            Ok(StartState { nominal, ..stands })
        }
    }
}

/// A posture with some joints at other values, and without.
fn named_posture(
    robot: &Robot,
    name: Option<&str>,
    joints: &BTreeMap<String, f64>,
) -> Result<(Configuration, Configuration)> {
    let named = match name {
        Some(name) => robot.posture(name)?,
        None => robot.resting(),
    };
    let mut posture = named.clone();
    let unknown = joints.keys().map(|name| robot.joint_index(name));
    let unknown: Vec<_> = unknown.filter_map(Result::err).collect();
    if let Some(first) = unknown.first() {
        let more = match unknown.len() - 1 {
            0 => String::new(),
            more => format!("; nor are there {more} other joints that are named"),
        };
        bail!("the start: {first}{more}");
    }
    mistakes::all(joints.iter().map(|(name, value)| {
        let joint = robot.joint_index(name)?;
        let body = &robot.joint_bodies()[joint];
        let beyond = (body.lower - value).max(value - body.upper);
        if beyond > MEASURED_RAD {
            let (lower, upper) = (body.lower, body.upper);
            bail!("the start: {name} at {value:.3} is beyond its limits, {lower:.3} to {upper:.3}");
        }
        posture.joints[joint] = *value;
        Ok(())
    }))?;
    Ok((posture, named))
}

/// The patches of these names; all with the role of a foot where there is none.
///
/// # Errors
/// An unknown patch, with those that there are; a robot without feet.
pub fn patches(robot: &Robot, names: &[String]) -> Result<Vec<PatchId>> {
    if !names.is_empty() {
        return mistakes::all(names.iter().map(|name| Ok(robot.patch_id(name)?)));
    }
    let is_foot = |p: &PatchId| robot.patches[*p].has_role(FOOT);
    let feet: Vec<PatchId> = robot.patch_ids().filter(is_foot).collect();
    if feet.is_empty() {
        bail!(
            "{} has no contact patch of the role \"{FOOT}\": name those it stands on",
            robot.name
        );
    }
    Ok(feet)
}

/// The posture of a start that was found for its contacts alone, clear of what is around it and near to `nominal`; nothing
/// where none is found.
///
/// # Errors
/// Contacts that cannot be posed.
pub fn clear_of_world(
    robot: &Robot,
    start: &planner::Start,
    nominal: &Configuration,
    environment: &Environment,
    config: &posture::Config,
) -> Result<Option<Configuration>> {
    let contacts = start.touching(robot, environment);
    let nominal = stand::over_contacts(robot, nominal, &contacts);
    let problem = Problem {
        reference: &nominal,
        ..Problem::new(robot, environment, contacts, &start.configuration)
    };
    let found = posture::solve(&problem, &thorough(config)).context("the start")?;
    Ok(found.posture().map(|posture| posture.q.clone()))
}

/// The one posture that all else begins with is worth many tries.
fn thorough(config: &posture::Config) -> posture::Config {
    let mut config = config.clone();
    config.solver.thorough = true;
    config
}

/// A posture near `guess` that touches with every patch at its place.
fn on_contacts(
    robot: &Robot,
    contacts: Vec<Contact>,
    guess: &Configuration,
    environment: &Environment,
    config: &posture::Config,
) -> Result<StartState> {
    let patches = contacts.iter().map(|contact| contact.patch).collect();
    let problem = Problem::new(robot, environment, contacts, guess);
    match posture::solve(&problem, &thorough(config)).context("the start")? {
        Outcome::Feasible(posture) => Ok(StartState {
            nominal: posture.q.clone(),
            configuration: posture.q,
            patches,
            X_WG: Isometry3::identity(),
        }),
        other => {
            let reason = other.violation().map(|v| v.describe(&problem));
            bail!("the start is no stance: {}", reason.unwrap_or_default())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As an iCub's base, whose x looks backward: it is the robot that looks ahead.
    #[test]
    fn a_robot_looks_ahead_whichever_way_its_base_does() {
        let start = |robot: &Robot| {
            let config = posture::Config::default();
            let stands = stand(robot, &Start::default(), &Environment::default(), &config);
            stands.unwrap().configuration.R_WB * Vector3::x()
        };
        let mut robot = scenes::robot("hrp2").unwrap();
        assert!((start(&robot) - Vector3::x()).norm() < 1e-9);
        for patch in robot.patches.iter_mut().filter(|p| p.has_role(FOOT)) {
            patch.X_BC.translation.x -= 0.2;
        }
        assert!((start(&robot) + Vector3::x()).norm() < 1e-9);
    }
}
