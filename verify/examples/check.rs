//! Checks a plan, and the motion beside it, of a robot that ships.
//!
//!   cargo run -p scandent-verify --example check -- out/irregular-stairs hrp2

use std::path::PathBuf;

use plan::{Motion, Plan};
use verify::verify;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let folder = PathBuf::from(args.next().ok_or("the folder of a plan")?);
    let robot = scenes::robot(&args.next().ok_or("a robot")?).ok_or("no such robot")?;

    let plan: Plan = serde_json::from_slice(&std::fs::read(folder.join("plan.json"))?)?;
    let motion: Option<Motion> = match &plan.motion {
        Some(named) => Some(serde_json::from_slice(&std::fs::read(
            folder.join(&named.file),
        )?)?),
        None => None,
    };
    let certificate = verify(&plan, motion.as_ref(), &robot);
    print!("{}", certificate.table());
    Ok(())
}
