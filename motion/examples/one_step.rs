//! Moves a foot of the humanoid that ships onto a step: cargo run -p motion --example one_step
use motion::{Config, MotionContext, StanceRef, assemble, segment};
use nalgebra::Isometry3;
use posture::{Contact, Environment, Problem, stand};
use surfaces::{Face, Terrain};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = scenes::builtin_robot("hrp2").ok_or("no such robot")?;
    let robot = &robot.load(&robot_model::Config::default())?;
    let floor = Face::rectangle("floor", Isometry3::identity(), [0.6, 1.0])?;
    let step = Isometry3::translation(0.55, 0.0, 0.15);
    let faces = vec![floor, Face::rectangle("step", step, [0.5, 1.0])?];
    let environment = &Environment::new(Terrain::new(faces, Vec::new())?, 0.03, 0.0)?;
    let (left, right) = (robot.patch_id("left_foot")?, robot.patch_id("right_foot")?);
    let (floor, step) = (environment.face("floor")?, environment.face("step")?);

    // The weight on the right foot, which stays; the left one on the floor, then on the step.
    let margins = &posture::Config::default();
    let config = &Config::default();
    let start = stand::on_level_ground(robot, &robot.resting(), &[left, right]);
    let solve = |contacts: &[Contact]| -> Result<posture::Posture, Box<dyn std::error::Error>> {
        let problem = Problem::new(robot, environment, contacts.to_vec(), &start);
        let outcome = posture::solve(&problem, margins)?;
        Ok(outcome.posture().ok_or("no posture")?.clone())
    };
    let on = |patch, face| Contact::anywhere_on(environment, face, robot, patch);
    let before = [on(right, floor)?, on(left, floor)?.loaded(false)];
    let standing = solve(&before)?;
    let right = Contact::at(robot, right, standing.contacts[0].X_WC).on(floor, environment);
    let after = [right, on(left, step)?.loaded(false)];
    let stepped = solve(&after)?;

    let context = MotionContext::new(robot, environment, margins, config);
    let from = StanceRef::new(&before, &standing);
    match segment(&context, from, StanceRef::new(&after, &stepped))? {
        Ok(found) => println!("{} s", assemble(&context, &[&found]).duration_s()),
        Err(failure) => println!("{}", failure.describe()),
    }
    Ok(())
}
