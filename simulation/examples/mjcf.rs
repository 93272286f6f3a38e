//! Prints a robot that ships as MuJoCo's model text, to open in MuJoCo's own viewer.
//!
//!   cargo run -p scandent-simulation --example mjcf -- hexapod > hexapod.xml

use simulation::mjcf::model;
use simulation::physics::{Physics, Scales, Servo};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).ok_or("a robot")?;
    let robot = scenes::builtin_robot(&name).ok_or("no such robot")?;
    let robot = robot.load(&robot_model::Config::default())?;
    let physics = Physics::from(&simulation::Config::default());
    print!(
        "{}",
        model(&robot, &[], &physics, Servo::STIFF, &Scales::default())?
    );
    Ok(())
}
