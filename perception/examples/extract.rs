//! Prints the faces of a depth image.
//!
//!   cargo run --release -p scandent-perception --example extract -- DEPTH.png [SENSOR]

use nalgebra::Isometry3;
use perception::{Config, SensorOptions, extract, read_scan};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("usage: extract DEPTH.png [SENSOR]")?;
    let options = SensorOptions {
        sensor: args.next().unwrap_or_else(|| "xtion".into()),
        ..SensorOptions::default()
    };
    let scan = read_scan(path.as_ref(), &options)?;
    // In the sensor's own frame: x right, y down, z forward.
    let found = extract(&scan, &Isometry3::identity(), &Config::default())?;
    for face in &found.faces {
        let n = face.normal_W();
        println!(
            "{}: {:.3} m², {} rings, normal ({:.3}, {:.3}, {:.3})",
            face.id,
            face.region.area(),
            face.region.rings().len(),
            n.x,
            n.y,
            n.z
        );
    }
    Ok(())
}
