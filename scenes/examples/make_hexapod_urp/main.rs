//! Writes `robots/hexapod_urp/{hexapod_urp.urdf, hexapod_urp.srdf, contacts.toml}`: the hexapod on
//! legs that slide.
//!
//! ```sh
//! cargo run -p scenes --example make_hexapod_urp
//! ```

use std::path::Path;

#[allow(dead_code)]
#[path = "../make_hexapod/facts.rs"]
mod facts;
mod files;
#[allow(dead_code)]
#[path = "../legged/mod.rs"]
mod legged;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hexapod_urp");
    std::fs::create_dir_all(&folder)?;
    for (name, text) in files::all() {
        std::fs::write(folder.join(name), text)?;
        println!("wrote {}", folder.join(name).display());
    }
    Ok(())
}
