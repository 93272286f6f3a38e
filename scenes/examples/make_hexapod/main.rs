//! Writes `robots/hexapod/{hexapod.urdf, hexapod.srdf, contacts.toml}`.
//!
//! ```sh
//! cargo run -p scenes --example make_hexapod
//! ```

use std::path::Path;

mod facts;
mod files;
#[path = "../legged/mod.rs"]
mod legged;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hexapod");
    for (name, text) in files::all() {
        std::fs::write(folder.join(name), text)?;
        println!("wrote {}", folder.join(name).display());
    }
    Ok(())
}
