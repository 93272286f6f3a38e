//! Extracts the surfaces of a scan and writes them, with the pixels' labels, for a script to look at.
//!
//!   cargo run --release --example extract -- SCAN OUT_PREFIX [SENSOR] [fx fy cx cy]
//!
//! writes OUT_PREFIX.json (planes and polygons in the sensor's frame) and OUT_PREFIX_labels.bin
//! (16-bit little-endian labels, row by row), and prints the counts and the time.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use nalgebra::Isometry3;
use perception::{Config, Intrinsics, SensorOptions, extract, read_scan};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scan, out, rest @ ..] = args.as_slice() else {
        return Err("usage: extract SCAN OUT_PREFIX [SENSOR] [fx fy cx cy]".into());
    };
    let sensor = rest.first().cloned().unwrap_or_else(|| "xtion".to_owned());
    let numbers: Vec<f64> = rest
        .iter()
        .skip(1)
        .map(|s| s.parse())
        .collect::<Result<_, _>>()?;
    let intrinsics = match numbers[..] {
        [fx, fy, cx, cy] => Some(Intrinsics { fx, fy, cx, cy }),
        _ => None,
    };
    let scan = read_scan(
        Path::new(scan),
        &SensorOptions {
            sensor,
            intrinsics,
            ..SensorOptions::default()
        },
    )?;
    let config = Config::default();
    let x_wv = Isometry3::identity();
    let mut best = f64::INFINITY;
    let mut result = extract(&scan, &x_wv, &config)?;
    for _ in 0..5 {
        let start = Instant::now();
        result = extract(&scan, &x_wv, &config)?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!(
        "{} surfaces, {:?}, {:.2} ms",
        result.surfaces.len(),
        result.statistics,
        best * 1e3
    );
    let Some(segmentation) = &result.segmentation else {
        return Ok(());
    };
    let mut json = String::from("[");
    for (i, plane) in segmentation.planes_V.iter().enumerate() {
        let (n, d) = plane.map_or(([0.0; 3], 0.0), |(n, d)| (n.into(), d));
        let polys: Vec<Vec<[f64; 3]>> = result
            .surfaces
            .iter()
            .zip(&segmentation.plane_of_surface)
            .filter(|(_, label)| usize::from(**label) == i)
            .map(|(s, _)| s.vertices_W().iter().map(|p| [p.x, p.y, p.z]).collect())
            .collect();
        let comma = if i > 0 { "," } else { "" };
        write!(
            json,
            "{comma}\n{{\"plane\":[{},{},{},{d}],\"polys\":{polys:?}}}",
            n[0], n[1], n[2]
        )?;
    }
    json.push_str("\n]\n");
    std::fs::write(format!("{out}.json"), json)?;
    let labels: Vec<u8> = segmentation
        .labels
        .iter()
        .flat_map(|l| l.to_le_bytes())
        .collect();
    std::fs::write(format!("{out}_labels.bin"), labels)?;
    Ok(())
}
