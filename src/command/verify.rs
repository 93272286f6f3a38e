//! `scandent verify PLAN.json`: everything that a plan promises, recomputed.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use plan::Plan;
use verify::Certificate;

use crate::cli::Global;
use crate::plan_file::{self, PlanRobotFlags};
use crate::status::Status;
use crate::told::Told;
use crate::{against, output, signature, threads};

/// Flags of `verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    #[command(flatten)]
    robot: PlanRobotFlags,
    /// Hold world and task against this scene (one that ships, a scene.toml, or the folder of the plan's),
    /// and fail where anything is left that must be believed; without it the plan's own scene is looked
    /// up, and what is not found is named as a condition
    #[arg(long, value_name = "DIR|SCENE")]
    against: Option<String>,
    /// Where the certificate goes, with every check of every stance
    #[arg(short, long, value_name = "CERTIFICATE.json")]
    output: Option<PathBuf>,
    /// Sign the certificate of a plan that passes with this private key (`openssl genpkey -algorithm
    /// ed25519`): CERTIFICATE.json.sig ties it to the plan
    #[arg(long, value_name = "KEY.pem", requires = "output")]
    sign: Option<PathBuf>,
    /// A certificate that is to be signed, as one of this very plan, by the owner of --by
    #[arg(
        long,
        value_name = "CERTIFICATE.json",
        requires = "by",
        conflicts_with = "sign"
    )]
    signed: Option<PathBuf>,
    /// The public key of who signed (`openssl pkey -in KEY.pem -pubout`)
    #[arg(long, value_name = "PUBLIC.pem", requires = "signed")]
    by: Option<PathBuf>,
}

/// Prints the table of margins; ends with [`Status::Failed`] where one does not hold, or where world and
/// task are to be those of a scene and something must be taken as the plan says it.
///
/// # Errors
/// A plan or a robot that cannot be read; a scene that the plan cannot be held against; a file that
/// cannot be written.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let plan = plan_file::open(&args.plan)?;
    if let (Some(certificate), Some(key)) = (&args.signed, &args.by) {
        signature::check(&args.plan, certificate, key)?;
        told.note(format_args!(
            "{}: signed for this plan",
            certificate.display()
        ))?;
    }
    let against = args.against.as_deref();
    let check = || certificate(&args.plan, &plan, against, &args.robot, global);
    let certificate = told.during("verifying", check)?;
    write!(told, "{}", certificate.table())?;
    told.fact("certificate", &certificate)?;
    if let Some(path) = &args.output {
        output::write(path, certificate.to_json()?.as_bytes())?;
        told.written(path)?;
        if let (Some(key), true) = (&args.sign, certificate.pass) {
            let signed = signature::sign(&args.plan, path, key)?;
            told.written(&signed)?;
        }
    }
    for row in certificate.failures() {
        told.fails(&row.sentence());
    }
    let believed = against.is_some() && !certificate.conditions.is_empty();
    Ok(match certificate.pass && !believed {
        true => Status::Done,
        false => Status::Failed,
    })
}

/// The certificate of the plan in a file, in the world that is found again.
///
/// # Errors
/// As [`run`].
pub fn certificate(
    path: &Path,
    plan: &Plan,
    against: Option<&str>,
    robot: &PlanRobotFlags,
    global: &Global,
) -> Result<Certificate> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let motion = plan_file::open_motion(path, plan)?;
    let motion = motion.as_ref();
    let (robot, world) = against::find(plan, motion, folder, against, robot, global)?;
    let check = || verify::verify_in(plan, motion, &robot, &world);
    Ok(threads::pool(global.threads)?.install(check))
}
