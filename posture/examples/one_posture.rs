//! Solves one posture: the humanoid that ships, one foot on the floor, the other on a step.
//!
//!   cargo run -p scandent-posture --example one_posture

use nalgebra::Isometry3;
use posture::{Config, Contact, Environment, Outcome, Problem, stand};
use surfaces::{Face, Terrain};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = scenes::robot("hrp2").ok_or("no such robot")?;

    // Two faces, known exactly, and bodies 3 cm deep behind them.
    let floor = Isometry3::translation(0.0, -0.2, 0.0);
    let step = Isometry3::translation(0.3, 0.2, 0.15);
    let faces = vec![
        Face::rectangle("floor", floor, [0.4, 0.4])?,
        Face::rectangle("step", step, [0.4, 0.4])?,
    ];
    let environment = Environment::new(Terrain::new(faces, Vec::new())?, 0.03, 0.0)?;

    // Each foot anywhere on its face.
    let mut contacts = Vec::new();
    for (patch, face) in [("right_foot", "floor"), ("left_foot", "step")] {
        let (patch, face) = (robot.patch_id(patch)?, environment.face(face)?);
        contacts.push(Contact::anywhere_on(&environment, face, &robot, patch)?);
    }
    let start = stand::over_contacts(&robot, &robot.resting(), &contacts);
    let problem = Problem::new(&robot, &environment, contacts, &start);
    let outcome = posture::solve(&problem, &Config::default())?;
    match (&outcome, outcome.violation()) {
        (Outcome::Feasible(posture), _) => println!("{:#?}", posture.margins),
        (_, Some(violation)) => println!("no posture: {}", violation.describe(&problem)),
        _ => {}
    }
    Ok(())
}
