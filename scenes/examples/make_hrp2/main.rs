//! Writes `robots/hrp2/{hrp2.urdf, hrp2.srdf, contacts.toml}` from `robots/hrp2/joints.csv`.
//!
//! ```sh
//! cargo run -p scenes --example make_hrp2
//! ```

use std::path::Path;

mod facts;
mod files;
mod shapes;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hrp2");
    let rows = facts::read(&std::fs::read_to_string(folder.join("joints.csv"))?)?;
    for (name, text) in files::all(&rows) {
        std::fs::write(folder.join(name), text)?;
        println!("wrote {}", folder.join(name).display());
    }
    Ok(())
}
