//! The start: the robot's configuration before its first step, and which patches bear.

pub mod agreement;
pub mod assumed;
pub mod ground;

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Point3, Translation3};
use posture::{Contact, Outcome, Place, Problem};
use robot_model::{Configuration, Kinematics, Robot};

use crate::posture_problem::place_base;
use crate::scene::Start;

/// The role of the patches that stand where no patch is named.
const FOOT: &str = "foot";

/// Where the robot is and what it stands on.
#[derive(Clone, Debug, PartialEq)]
pub struct Stand {
    /// Base pose and joints.
    pub configuration: Configuration,
    /// Patches that touch the ground.
    pub patches: Vec<usize>,
}

/// The configuration that a scene's start describes.
///
/// # Errors
/// An unknown posture or patch, with those that there are; contacts that no posture reaches, with
/// the constraint that fails.
pub fn stand(robot: &Robot, start: &Start, config: &posture::Config) -> Result<Stand> {
    match start {
        Start::Posture {
            name,
            base,
            contacts,
        } => {
            let posture = named_posture(robot, name.as_deref())?;
            let patches = patches(robot, contacts)?;
            let base = base.unwrap_or_else(|| soles_on_zero(robot, &posture, &patches));
            Ok(Stand {
                configuration: posture.with_base(&base),
                patches,
            })
        }
        Start::Contacts(contacts) => on_contacts(robot, contacts, config),
    }
}

fn named_posture(robot: &Robot, name: Option<&str>) -> Result<Configuration> {
    match name {
        Some(name) => Ok(robot.posture(name)?),
        None => Ok(robot.resting()),
    }
}

fn patches(robot: &Robot, names: &[String]) -> Result<Vec<usize>> {
    if !names.is_empty() {
        return names
            .iter()
            .map(|name| Ok(robot.patch_index(name)?))
            .collect();
    }
    let feet: Vec<usize> = (0..robot.patches.len())
        .filter(|&p| robot.patches[p].has_role(FOOT))
        .collect();
    if feet.is_empty() {
        bail!(
            "{} has no contact patch of the role \"{FOOT}\": name those it stands on",
            robot.name
        );
    }
    Ok(feet)
}

/// The base upright over the origin, the lowest vertex or ball of the patches at z = 0.
fn soles_on_zero(robot: &Robot, posture: &Configuration, patches: &[usize]) -> Isometry3<f64> {
    let upright = posture.clone().with_base(&Isometry3::identity());
    let kinematics = Kinematics::new(robot, &upright);
    let lowest = patches
        .iter()
        .map(|&p| &robot.patches[p])
        .flat_map(|patch| {
            let pose = kinematics.X_WC(patch);
            patch
                .polygon
                .iter()
                .map(move |v| (pose * Point3::new(v.x, v.y, 0.0)).z)
                .map(|z| z - patch.point_radius_m().unwrap_or(0.0))
        })
        .fold(f64::INFINITY, f64::min);
    let height = if lowest.is_finite() { -lowest } else { 0.0 };
    Translation3::new(0.0, 0.0, height).into()
}

/// A posture that touches with every named patch at its pose.
fn on_contacts(
    robot: &Robot,
    named: &[(String, Isometry3<f64>)],
    config: &posture::Config,
) -> Result<Stand> {
    let mut contacts = Vec::new();
    for (name, pose) in named {
        let patch = robot.patch_index(name)?;
        let place = Place::Fixed {
            X_WC: *pose,
            yaw_free: false,
            surface: None,
        };
        let friction = robot.patches[patch].friction;
        contacts.push(Contact {
            patch,
            place,
            loaded: true,
            friction,
        });
    }
    let patches = contacts.iter().map(|contact| contact.patch).collect();
    let environment = posture::Environment::empty();
    let guess = place_base(robot, &robot.resting(), &contacts, &environment);
    let problem = Problem {
        robot,
        environment: &environment,
        contacts,
        base_goal: None,
        reference: &guess,
        guess: &guess,
    };
    match posture::solve(&problem, config).context("the start")? {
        Outcome::Feasible(posture) => Ok(Stand {
            configuration: posture.q,
            patches,
        }),
        other => {
            let reason = other
                .violation()
                .map(|v| v.describe(&problem))
                .unwrap_or_default();
            bail!("the start is no stance: {reason}")
        }
    }
}
