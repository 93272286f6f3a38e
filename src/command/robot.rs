//! `scandent robot URDF`: what was read of a robot.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;
use robot_model::{JointKind, PatchKind, Robot};

use crate::cli::Global;
use crate::config::Config;
use crate::provenance::Inputs;
use crate::robot_files::RobotFiles;
use crate::status::Status;

/// Flags of `robot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A URDF file, or builtin:NAME
    #[arg(value_name = "URDF")]
    robot: String,
    /// Named postures and pairs of links that may touch
    #[arg(long, value_name = "FILE.srdf")]
    srdf: Option<PathBuf>,
    /// Contact patches
    #[arg(long, value_name = "FILE.toml")]
    contacts: Option<PathBuf>,
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
    let files = RobotFiles {
        urdf: args.robot.clone(),
        srdf: args.srdf.clone(),
        contacts: args.contacts.clone(),
    };
    let robot = files.load(&config.robot_model, &mut Inputs::default())?;
    print(&robot, out)?;
    if args.joints {
        joints(&robot, out)?;
    }
    Ok(Status::Done)
}

fn print(robot: &Robot, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(
        out,
        "{}: {} joints ({} degrees of freedom with the floating base), {:.3} kg, {} links, \
         {} collision shapes",
        robot.name,
        robot.nj(),
        robot.nv(),
        robot.mass_kg,
        robot.frames.len(),
        robot.collision.shapes().len()
    )?;
    writeln!(out, "contact patches: {}", count(robot.patches.len()))?;
    for patch in &robot.patches {
        writeln!(
            out,
            "  {:<16} on {:<20} {}, friction {}, roles: {}",
            patch.name,
            patch.link,
            match patch.kind {
                PatchKind::Area => format!("{} vertices", patch.polygon.len()),
                PatchKind::Point { radius_m } => format!("a point, radius {radius_m} m"),
            },
            patch.friction,
            patch.roles.join(", ")
        )?;
    }
    let postures: Vec<&str> = robot.postures.keys().map(String::as_str).collect();
    let postures = match postures.as_slice() {
        [] => "none".to_owned(),
        some => some.join(", "),
    };
    writeln!(out, "postures: {postures}")?;
    let colliding = robot.colliding_pairs(&robot.resting());
    let pairs = count(colliding.len());
    writeln!(out, "pairs of links that overlap at rest: {pairs}")?;
    for pair in &colliding {
        let (a, b, depth_mm) = (&pair.link_a, &pair.link_b, -1e3 * pair.distance);
        writeln!(out, "  {a} and {b} by {depth_mm:.1} mm")?;
    }
    writeln!(out, "notes: {}", count(robot.notes.len()))?;
    for note in &robot.notes {
        writeln!(out, "  {note}")?;
    }
    Ok(())
}

fn count(n: usize) -> String {
    match n {
        0 => "none".to_owned(),
        n => n.to_string(),
    }
}

fn joints(robot: &Robot, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "joints:")?;
    for body in robot.joint_bodies() {
        let unit = match body.kind {
            JointKind::Prismatic => "m, N",
            _ => "rad, N·m",
        };
        writeln!(
            out,
            "  {:<24} [{:.4}, {:.4}], effort {} ({unit})",
            body.joint, body.lower, body.upper, body.effort
        )?;
    }
    Ok(())
}
