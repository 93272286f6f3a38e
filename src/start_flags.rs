//! The flags that say where the robot is before its first step.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::Isometry3;
use robot_model::Configuration;

use crate::argument::{self, StartFlag};
use crate::plan_file;
use crate::provenance::Inputs;
use crate::scene::Start;
use crate::status::UsageError;

/// Where the robot starts, in the place of what a scene says.
#[derive(Debug, clap::Args)]
pub struct StartFlags {
    /// Start: POSTURE[@x,y,z[,roll,pitch,yaw]], POSTURE@x,y (on what is there), with JOINT=VALUE for joints that are elsewhere,
    /// rad; or PATCH=x,y,z[,roll,pitch,yaw] once a contact (default: the resting posture over the origin, soles on z = 0)
    #[arg(long, value_name = "START", value_parser = argument::start, allow_hyphen_values = true)]
    start: Vec<StartFlag>,
    /// Start as a stance of an earlier plan has the robot, counted from 0
    #[arg(long, value_name = "PLAN.json:STANCE", value_parser = argument::stance_of, conflicts_with_all = ["start", "before_floor"])]
    pub start_stance: Option<(PathBuf, usize)>,
    /// Start with the toes just before the floor that is seen ahead of the origin, and on its plane
    #[arg(long)]
    before_floor: bool,
    /// Patches that touch the ground at the start (default: all feet)
    #[arg(long, value_name = "PATCH,…", value_delimiter = ',')]
    start_contacts: Vec<String>,
}

impl StartFlags {
    /// Puts what they say in the place of a start.
    ///
    /// # Errors
    /// [`UsageError`] where they contradict each other; a plan that cannot be read or has no such stance.
    pub fn over(&self, start: &mut Start, inputs: &mut Inputs) -> Result<()> {
        if let Some((plan, number)) = &self.start_stance {
            *start = stance(plan, *number, inputs)?;
        }
        let mut joints = BTreeMap::new();
        let mut places = Vec::new();
        for flag in &self.start {
            match flag {
                StartFlag::Joint(name, value) => {
                    joints.insert(name.clone(), *value);
                }
                place => places.push(place),
            }
        }
        match places.as_slice() {
            [] if joints.is_empty() => {}
            [] => match start {
                Start::Posture { joints: own, .. } | Start::Over { joints: own, .. } => {
                    own.extend(joints);
                }
                Start::Contacts(_) => {
                    return usage(
                        "--start JOINT=… does not go with contacts: a posture is sought for these",
                    );
                }
            },
            [StartFlag::Posture(name, base)] => {
                *start = Start::Posture {
                    name: name.clone(),
                    joints,
                    base: *base,
                    before_floor: false,
                    contacts: Vec::new(),
                };
            }
            [StartFlag::Over(name, at_m)] => {
                *start = Start::Over {
                    name: name.clone(),
                    joints,
                    at_m: *at_m,
                    yaw_rad: 0.0,
                    contacts: Vec::new(),
                };
            }
            places => {
                let contacts = places.iter().map(|place| match place {
                    StartFlag::Contact(patch, pose) if joints.is_empty() => {
                        Ok((patch.clone(), *pose))
                    }
                    _ => usage("give --start either one posture, or contacts only"),
                });
                *start = Start::Contacts(contacts.collect::<Result<_>>()?);
            }
        }
        if self.before_floor {
            match start {
                Start::Posture {
                    base: None,
                    before_floor,
                    ..
                } => *before_floor = true,
                _ => {
                    return usage(
                        "--before-floor does not go with a place in --start: the floor that is seen says where",
                    );
                }
            }
        }
        if self.start_contacts.is_empty() {
            return Ok(());
        }
        match start {
            Start::Posture { contacts, .. } | Start::Over { contacts, .. } => {
                contacts.clone_from(&self.start_contacts);
                Ok(())
            }
            Start::Contacts(_) => usage("--start-contacts does not go with --start PATCH=…"),
        }
    }
}

/// The start that a stance of a plan is.
fn stance(file: &Path, number: usize, inputs: &mut Inputs) -> Result<Start> {
    let plan = plan_file::parsed(file, &inputs.read("earlier plan", file)?)?;
    let name = file.display();
    let Some(stance) = plan.stances.get(number) else {
        bail!(
            "{name}: no stance {number}: there are {}, from 0",
            plan.stances.len()
        );
    };
    let said = || format!("{name}: stance {number}");
    let q = Configuration::from_q(&stance.q).with_context(said)?;
    let names = &plan.robot.joint_names;
    if names.len() != q.joints.len() {
        bail!(
            "{}: {} joints, where the robot has {}",
            said(),
            q.joints.len(),
            names.len()
        );
    }
    let touching = stance.contacts.iter().map(|contact| contact.patch.clone());
    Ok(Start::Posture {
        name: None,
        joints: names
            .iter()
            .cloned()
            .zip(q.joints.iter().copied())
            .collect(),
        base: Some(Isometry3::from_parts(q.p_WB.into(), q.R_WB)),
        before_floor: false,
        contacts: touching.collect(),
    })
}

fn usage<T>(text: &str) -> Result<T> {
    Err(anyhow!(UsageError(text.to_owned())))
}
