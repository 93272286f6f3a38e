//! Writes `robots/quadruped/{quadruped.urdf, quadruped.srdf, contacts.toml}`.
//!
//! ```sh
//! cargo run -p scenes --example make_quadruped
//! ```

use std::path::Path;

mod facts;
mod files;
#[path = "../legged/mod.rs"]
mod legged;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/quadruped");
    for (name, text) in files::all() {
        std::fs::write(folder.join(name), text)?;
        println!("wrote {}", folder.join(name).display());
    }
    Ok(())
}
