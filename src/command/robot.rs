//! `scandent robot URDF`: what was read of a robot.

use std::io::Write;

use anyhow::Result;
use robot_model::{JointKind, PatchKind, Robot};
use serde_json::{Value, json};

use crate::cli::Global;
use crate::config::Config;
use crate::provenance::Inputs;
use crate::robot_files::BesideUrdf;
use crate::status::Status;
use crate::template::render;

/// Flags of `robot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A URDF file, or builtin:NAME
    #[arg(value_name = "URDF")]
    robot: String,
    #[command(flatten)]
    beside: BesideUrdf,
    /// Also list every joint with its limits
    #[arg(long)]
    joints: bool,
}

/// Prints degrees of freedom, mass, patches, postures, what collides at rest and what was assumed.
///
/// # Errors
/// As [`RobotFiles::load`].
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let files = args.beside.files(&args.robot);
    let robot = files.load(&config.robot_model, &mut Inputs::default())?;
    let text = render(
        "robot.txt",
        include_str!("text/robot.txt"),
        said(&robot, args.joints),
    )?;
    out.write_all(text.as_bytes())?;
    Ok(Status::Done)
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
