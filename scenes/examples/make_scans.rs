//! Takes the scans of the scenes that ship and writes them beside their scene files.
//!
//! ```sh
//! cargo run -p scandent-scenes --example make_scans                  # as they ship
//! cargo run -p scandent-scenes --example make_scans FOLDER SEED      # elsewhere, other noise
//! ```

use std::path::PathBuf;

use scenes::simulator::{DepthNoise, Scan};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let folder = std::env::args().nth(1).map_or_else(beside, PathBuf::from);
    let seed: Option<u64> = std::env::args()
        .nth(2)
        .map(|text| text.parse())
        .transpose()?;
    for scene in scenes::names().filter_map(scenes::builtin) {
        let noise = DepthNoise::default();
        let Some(scan) = scene.picture(&noise, seed.unwrap_or(scene.seed)) else {
            continue;
        };
        let path = folder.join(format!("{}_depth.png", scene.name));
        std::fs::write(&path, scan.png()?)?;
        println!("wrote {}", path.display());
        for (face, pixels) in visible(&(scene.truth)(), &scan) {
            println!("    {pixels:7} px  {face}");
        }
    }
    Ok(())
}

/// Faces with at least 500 measured pixels, most first.
fn visible(truth: &scenes::Truth, scan: &Scan) -> Vec<(String, usize)> {
    let mut counts: Vec<(String, usize)> = truth
        .faces()
        .into_iter()
        .map(|face| (face.name, 0))
        .collect();
    for (face, mm) in scan.face.iter().zip(&scan.depth_mm) {
        if let Some(count) = face
            .and_then(|face| counts.get_mut(face))
            .filter(|_| *mm > 0)
        {
            count.1 += 1;
        }
    }
    counts.retain(|(_, pixels)| *pixels >= 500);
    counts.sort_by_key(|(_, pixels)| std::cmp::Reverse(*pixels));
    counts
}
