//! What the search finds for the humanoid passes the verifier, and broken in every way fails.

#[path = "support/climb.rs"]
mod climb;
#[path = "support/mutations.rs"]
mod mutations;

use scandent::verify::{Options, verify};

#[test]
fn a_planned_climb_passes_and_every_broken_one_fails() {
    let robot = climb::humanoid();
    let plan = climb::plan(&robot, 2);
    let certificate = verify(&plan, &robot, &Options::default());
    println!("{}", certificate.table());
    assert!(certificate.pass, "{}", certificate.table());
    for mutation in mutations::mutations() {
        let mut broken = plan.clone();
        (mutation.apply)(&mut broken);
        let failed = verify(&broken, &robot, &Options::default()).failed_checks();
        assert_eq!(mutation.objection(&failed), None);
    }
}
