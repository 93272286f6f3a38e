//! Writes the files of the robots that ship: `robots/NAME/{NAME.urdf, NAME.srdf, contacts.toml}`.
//!
//! ```sh
//! cargo run -p scandent-scenes --example make_robots
//! ```

mod robot;

fn main() -> Result<(), robot::Error> {
    for name in robot::NAMES {
        for (file, text) in robot::files(name)? {
            std::fs::write(&file, text)?;
            println!("wrote {}", file.display());
        }
    }
    Ok(())
}
