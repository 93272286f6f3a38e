//! `scandent robot URDF`: what was read of a robot.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use robot_model::propose::Kinds;
use robot_model::{JointKind, PatchKind, Robot};
use serde_json::{Value, json};

use crate::argument;
use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::propose::Proposal;
use crate::provenance::{Inputs, is_standard};
use crate::robot_files::{BesideUrdf, RobotFiles};
use crate::status::Status;
use crate::template::render;
use crate::told::Told;
use crate::view;

/// Flags of `robot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A URDF file, - for the standard input, or builtin:NAME
    #[arg(value_name = "URDF")]
    robot: String,
    #[command(flatten)]
    beside: BesideUrdf,
    /// Also list every joint with its limits
    #[arg(long)]
    joints: bool,
    /// Write what the URDF does not tell into this folder: contacts.toml, an SRDF with excepted pairs
    /// and a standing posture, and robot.html to look at
    #[arg(long, value_name = "FOLDER", value_parser = argument::folder)]
    propose: Option<PathBuf>,
    /// Patches to propose beside feet and hands
    #[arg(long, value_name = "PART", value_delimiter = ',', requires = "propose")]
    also: Vec<Part>,
}

/// A part of a limb that touches where it is asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// The front of the knees.
    Knees,
    /// The elbows.
    Elbows,
}

/// Prints degrees of freedom, mass, patches, postures, what collides at rest and what was assumed.
///
/// # Errors
/// As [`RobotFiles::load`].
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let files = RobotFiles {
        urdf: args.robot.clone(),
        beside: args.beside.clone(),
    };
    let (robot, proposed) = match &args.propose {
        Some(folder) => told.during("looking for patches and a standing posture", || {
            args.write_proposal(folder, &files, &config)
        })?,
        None => (
            files.load(&config.robot_model, &mut Inputs::default())?,
            None,
        ),
    };
    let said = said(&robot, args.joints);
    let text = render("robot.txt", include_str!("text/robot.txt"), &said)?;
    told.write_all(text.as_bytes())?;
    told.fact("robot", said)?;
    if let Some((page, files)) = proposed {
        let next = format!(
            "scandent plan --mesh WORLD.obj --goal X,Y --robot {} {}",
            files.urdf,
            files.beside.flags().join(" ")
        );
        writeln!(told, "then, with what it is to walk on: {next}")?;
        told.fact("next", next)?;
        told.open(page.display())?;
    }
    Ok(Status::Done)
}

impl Args {
    /// Writes what is proposed, and gives the robot as those files have it, with the page and the files.
    fn write_proposal(
        &self,
        folder: &Path,
        files: &RobotFiles,
        config: &Config,
    ) -> Result<(Robot, Option<(PathBuf, RobotFiles)>)> {
        if files.is_builtin() {
            bail!(
                "{} ships with contacts and an SRDF: --propose is for a URDF",
                files.urdf
            );
        }
        let kinds = Kinds {
            knees: self.also.contains(&Part::Knees),
            elbows: self.also.contains(&Part::Elbows),
        };
        let bare = files.bare(&files.of_model(&config.robot_model)?)?;
        let Proposal {
            contacts,
            srdf,
            notes,
        } = files.proposal(&bare, kinds)?;
        let urdf = Path::new(&files.urdf);
        let stem = match urdf.file_stem() {
            Some(stem) if !is_standard(urdf) => stem.to_string_lossy(),
            _ => bare.name.as_str().into(),
        };
        let mut files = files.clone();
        if files.beside.contacts.is_none() {
            let path = folder.join("contacts.toml");
            output::write(&path, contacts.as_bytes())?;
            files.beside.contacts = Some(path);
        }
        if files.beside.srdf.is_none() {
            let path = folder.join(format!("{stem}.srdf"));
            output::write(&path, srdf.as_bytes())?;
            files.beside.srdf = Some(path);
        }
        let mut robot = files.load(&config.robot_model, &mut Inputs::default())?;
        robot.notes.extend(notes);
        let page = view::robot_page(&robot)?;
        let path = folder.join("robot.html");
        output::write(&path, page.as_bytes())?;
        Ok((robot, Some((path, files))))
    }
}

/// What the template says of a robot, and of every joint where `joints` are wanted.
fn said(robot: &Robot, joints: bool) -> Value {
    let patches = robot.patches.iter().map(|patch| {
        let shape = match patch.kind {
            PatchKind::Area => format!("{} vertices", patch.polygon.len()),
            PatchKind::Point { radius_m } => format!("a point, radius {radius_m} m"),
        };
        json!({
            "name": patch.name,
            "link": patch.link,
            "shape": shape,
            "friction": patch.friction.to_string(),
            "roles": patch.roles,
        })
    });
    let overlapping = robot.meeting_at_rest.iter();
    let overlapping = overlapping.map(|p| json!([p.link_a, p.link_b, 1e3 * p.distance]));
    let joints = robot.joint_bodies().iter().filter(|_| joints).map(|body| {
        json!({
            "name": body.joint,
            "slides": body.kind == JointKind::Prismatic,
            "lower": body.lower,
            "upper": body.upper,
            "effort": body.effort.to_string(),
        })
    });
    json!({
        "name": robot.name,
        "nj": robot.nj(),
        "nv": robot.nv(),
        "mass_kg": robot.mass_kg,
        "links": robot.frames.len(),
        "shapes": robot.collision.shapes().len(),
        "patches": patches.collect::<Vec<_>>(),
        "postures": robot.postures.keys().collect::<Vec<_>>(),
        "overlapping": overlapping.collect::<Vec<_>>(),
        "notes": robot.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "joints": joints.collect::<Vec<_>>(),
    })
}
