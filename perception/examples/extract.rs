//! Extracts the surfaces of a scan and writes them for a script to look at.
//!
//!   cargo run --release -p scandent-perception --example extract -- SCAN OUT_PREFIX [--sensor NAME]
//!       [--intrinsics fx,fy,cx,cy] [--eye x,y,z] [--method auto|organised|voxels|brossette2013] [--runs N]
//!
//! Writes `OUT_PREFIX.json`, a list with one entry a plane (by the chain, one a surface), all in the sensor's optical frame (x right, y down, z forward; m):
//!
//!   [{"plane": [a, b, c, d], "polys": [[[x, y, z], …], …]}, …]
//!
//! with the unit normal (a, b, c) toward the sensor, a x + b y + c z + d = 0, and the convex
//! polygons that cover the plane's faces, less their insets (none for a plane without a face large enough; they may
//! overlap). Planes that kept too few pixels are all zeros. But by the chain also
//! `OUT_PREFIX_labels.bin`: 16-bit little-endian indices of these entries for every pixel, row by
//! row, or for every point of a cloud, 65535 where there is none.
//!
//! Prints `surfaces`, counts, and of N runs on one thread, from the decoded scan to the polygons, the
//! mean of the thread's own time where the system tells it, the median and the least of the clock's.

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
                    "voxels" => Method::Voxels,
                    "brossette2013" => Method::Brossette2013,
                    _ => return Err(format!("unknown method {value}").into()),
                }
            }
            "--runs" => runs = value.parse()?,
            _ => return Err(format!("unknown option {key}").into()),
        }
    }
    let scan = read_scan(Path::new(scan), &options)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (result, mut times, cpu_ms) = pool.install(|| {
        let mut times = Vec::new();
        let mut result = extract(&scan, &Isometry3::identity(), &config)?;
        // The scheduler counts a thread's time by its ticks: a run by itself is shorter than one.
        let before = thread_ms();
        for _ in 0..runs {
            let wall = Instant::now();
            let found = extract(&scan, &Isometry3::identity(), &config)?;
            times.push(wall.elapsed().as_secs_f64() * 1e3);
            result = found;
        }
        let cpu_ms = thread_ms()
            .zip(before)
            .map(|(after, before)| after - before);
        Ok::<_, perception::Error>((result, times, cpu_ms))
    })?;
    println!(
        "{} surfaces, {:?}",
        result.surfaces.len(),
        result.statistics
    );
    times.sort_by(f64::total_cmp);
    if let (Some(least), Some(median)) = (times.first(), times.get(times.len() / 2)) {
        if let Some(cpu_ms) = cpu_ms {
            print!("{:.2} ms CPU in the mean, ", cpu_ms / runs as f64);
        }
        println!("{median:.2} ms in the median, {least:.2} ms");
    }
    write(out, &result)
}

/// Time that this thread has run, ms; `None` where Linux' scheduler does not tell it.
fn thread_ms() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let ns: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(ns * 1e-6)
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
        let touchable = s.effective_polygon();
        let vertices = touchable.iter().flat_map(|p| p.vertices());
        vertices.map(|v| s.point_W(v).coords.into()).collect()
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
