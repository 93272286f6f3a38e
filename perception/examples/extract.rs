//! Extracts the surfaces of a scan and writes them for a script to look at.
//!
//!   cargo run --release --example extract -- SCAN OUT_PREFIX [--sensor NAME]
//!       [--intrinsics fx,fy,cx,cy] [--eye x,y,z] [--method auto|organised|chain] [--runs N]
//!
//! writes OUT_PREFIX.json (planes, and polygons in the sensor's frame) and, of a depth image,
//! OUT_PREFIX_labels.bin (16-bit little-endian labels, row by row); prints counts and time.

use std::path::Path;
use std::time::Instant;

use nalgebra::Isometry3;
use perception::{Config, Intrinsics, Method, SensorOptions, extract, read_scan};

type AnyError = Box<dyn std::error::Error>;

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scan, out, rest @ ..] = args.as_slice() else {
        return Err("usage: extract SCAN OUT_PREFIX [options]".into());
    };
    let mut options = SensorOptions::default();
    let mut config = Config::default();
    let mut runs = 1;
    for pair in rest.chunks(2) {
        let [key, value] = pair else {
            return Err(format!("{} needs a value", pair[0]).into());
        };
        match key.as_str() {
            "--sensor" => options.sensor = value.clone(),
            "--intrinsics" => {
                let [fx, fy, cx, cy] = numbers(value)?;
                options.intrinsics = Some(Intrinsics { fx, fy, cx, cy });
            }
            "--eye" => options.eye_m = Some(numbers(value)?),
            "--method" => {
                config.method = match value.as_str() {
                    "auto" => Method::Auto,
                    "organised" => Method::Organised,
                    "chain" => Method::Chain,
                    _ => return Err(format!("unknown method {value}").into()),
                }
            }
            "--runs" => runs = value.parse()?,
            _ => return Err(format!("unknown option {key}").into()),
        }
    }
    let scan = read_scan(Path::new(scan), &options)?;
    let mut best = f64::INFINITY;
    let mut result = perception::Extraction::default();
    for _ in 0..runs {
        let start = Instant::now();
        result = extract(&scan, &Isometry3::identity(), &config)?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    println!(
        "{} surfaces, {:?}, {:.2} ms",
        result.surfaces.len(),
        result.statistics,
        best * 1e3
    );
    write(out, &result)
}

/// N numbers with commas between.
fn numbers<const N: usize>(list: &str) -> Result<[f64; N], AnyError> {
    let numbers = list
        .split(',')
        .map(str::parse)
        .collect::<Result<Vec<f64>, _>>()?;
    numbers
        .try_into()
        .map_err(|_| format!("{list} is not {N} numbers").into())
}

fn write(out: &str, result: &perception::Extraction) -> Result<(), AnyError> {
    // One entry a plane where the pixels have labels, else one a surface.
    let polygon = |s: &surfaces::Surface| -> Vec<[f64; 3]> {
        s.vertices_W().iter().map(|p| [p.x, p.y, p.z]).collect()
    };
    let entries: Vec<String> = match &result.segmentation {
        Some(pixels) => pixels
            .planes_V
            .iter()
            .enumerate()
            .map(|(i, plane)| {
                let (n, d) = plane.map_or(([0.0; 3], 0.0), |(n, d)| (n.into(), d));
                let polys: Vec<_> = result
                    .surfaces
                    .iter()
                    .zip(&pixels.plane_of_surface)
                    .filter(|(_, label)| usize::from(**label) == i)
                    .map(|(s, _)| polygon(s))
                    .collect();
                format!(
                    "{{\"plane\":[{},{},{},{d}],\"polys\":{polys:?}}}",
                    n[0], n[1], n[2]
                )
            })
            .collect(),
        None => result
            .surfaces
            .iter()
            .map(|s| {
                let n = s.normal_W();
                let d = -n.dot(&s.X_WS.translation.vector);
                let polys = polygon(s);
                format!(
                    "{{\"plane\":[{},{},{},{d}],\"polys\":[{polys:?}]}}",
                    n.x, n.y, n.z
                )
            })
            .collect(),
    };
    std::fs::write(
        format!("{out}.json"),
        format!("[{}]\n", entries.join(",\n")),
    )?;
    if let Some(pixels) = &result.segmentation {
        let labels: Vec<u8> = pixels.labels.iter().flat_map(|l| l.to_le_bytes()).collect();
        std::fs::write(format!("{out}_labels.bin"), labels)?;
    }
    Ok(())
}
