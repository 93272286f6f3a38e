//! Loads each URDF given and prints what was read of it, and what was assumed.
//!
//!   cargo run -p scandent-robot-model --example inspect -- robot_model/tests/golden/test_tree.urdf

use robot_model::{Kinematics, RobotFiles, load};

fn main() {
    for urdf in std::env::args().skip(1) {
        let robot = match load(&RobotFiles::new(&urdf)) {
            Ok(robot) => robot,
            Err(error) => {
                println!("refused: {error}");
                continue;
            }
        };
        let resting = robot.resting();
        println!(
            "{urdf}: {} joints, {} frames, {} shapes, {:.3} kg, centre of mass at {:.3?} m",
            robot.nj(),
            robot.frames.len(),
            robot.collision.shapes().len(),
            robot.mass_kg,
            Kinematics::new(&robot, &resting).com_W.as_slice(),
        );
        for pair in robot.colliding_pairs(&resting) {
            println!("    {} and {} overlap", pair.link_a, pair.link_b);
        }
        for note in &robot.notes {
            println!("    {note}");
        }
    }
}
