//! Prints the contacts of a plan that `scandent run` wrote, stance by stance.
//!
//!   cargo run -p scandent-plan --example stances -- out/irregular-stairs/plan.json

use plan::Plan;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("a plan.json")?;
    let plan: Plan = serde_json::from_slice(&std::fs::read(path)?)?;
    for (number, stance) in plan.stances.iter().enumerate() {
        let loads = stance.contacts.iter().map(|contact| {
            let load_n: f64 = contact.forces_W.iter().map(|force| force[2]).sum();
            format!("{} on {} ({load_n:.0} N)", contact.patch, contact.face)
        });
        println!("{number}: {}", loads.collect::<Vec<_>>().join(", "));
    }
    Ok(())
}
