//! Writes the files of the robots that ship: `robots/NAME/{NAME.urdf, NAME.srdf, contacts.toml}`.
//!
//! ```sh
//! cargo run -p scandent-scenes --example make_robots
//! ```

use std::path::Path;

mod hexapod;
mod hexapod_urp;
mod hrp2;
mod hrp2_shapes;
mod parts;
mod quadruped;
mod writer;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    for robot in [
        hrp2::robot()?,
        hexapod::robot(),
        hexapod_urp::robot(),
        quadruped::robot(),
    ] {
        for (name, text) in robot.files() {
            let file = robots.join(robot.name).join(name);
            std::fs::write(&file, text)?;
            println!("wrote {}", file.display());
        }
    }
    Ok(())
}
