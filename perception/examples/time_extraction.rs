//! Times all that is done to a depth frame and writes what `benches/peers/surfaces/score.py` asks for.
//!
//!   time_extraction DEPTH.png OUT organised|voxels|auto RUNS [STEP [SENSOR]]
//!
//! Of a cloud every STEPth point is taken; the sensor is an Xtion where none is named, or NAME:fx,fy,cx,cy.
//!
//! OUT.json has one entry a plane, in the sensor's optical frame (x right, y down, z forward; m):
//!
//!   [{"plane": [a, b, c, d], "polys": [[[x, y, z], …], …]}, …]
//!
//! with the unit normal (a, b, c) toward the sensor, a x + b y + c z + d = 0, and triangles of its faces less their
//! insets; planes that kept too few pixels are all zeros. OUT_labels.bin has 16-bit little-endian indices of these
//! entries for every pixel or point, 65535 where there is none. OUT_ms.txt has the median and the least of the runs'
//! times on one thread, ms, from the decoded scan to the terrain.

use std::time::Instant;

use nalgebra::{Isometry3, Point2, Vector3};
use perception::{
    Config, Extraction, Intrinsics, Method, PosedScan, SensorOptions, extract, perceive, read_scan,
};

type AnyError = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), AnyError> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [path, out, method, runs, rest @ ..] = &args[..] else {
        return Err(
            "usage: time_extraction DEPTH.png OUT organised|voxels|auto RUNS [STEP [SENSOR]]"
                .into(),
        );
    };
    let step: usize = rest.first().map_or(Ok(1), |step| step.parse())?;
    let sensor = rest.get(1).map_or("xtion", String::as_str);
    let config = Config {
        method: match method.as_str() {
            "organised" => Method::Organised,
            "voxels" => Method::Voxels,
            "auto" => Method::Auto,
            _ => return Err(format!("unknown method {method}").into()),
        },
        ..Config::default()
    };
    let (sensor, k) = sensor.split_once(':').unwrap_or((sensor, ""));
    let k: Vec<f64> = (k.split(',').filter(|k| !k.is_empty()))
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let intrinsics = match k[..] {
        [fx, fy, cx, cy] => Some(Intrinsics { fx, fy, cx, cy }),
        _ => None,
    };
    let options = SensorOptions {
        sensor: sensor.into(),
        intrinsics,
        ..SensorOptions::default()
    };
    let mut scan = read_scan(path.as_ref(), &options)?;
    for (i, p) in scan.cloud.points.iter_mut().enumerate() {
        if i % step != 0 {
            *p = [f32::NAN; 3];
        }
    }
    let posed = [PosedScan::Scan {
        name: path,
        scan: &scan,
        X_WV: head(),
    }];
    let run = || perceive(&posed, &config);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (found, mut times_ms) = pool.install(|| {
        let found = extract(&scan, &Isometry3::identity(), &config)?;
        let mut times_ms = Vec::new();
        for _ in 0..runs.parse::<usize>()?.max(1) {
            let start = Instant::now();
            std::hint::black_box(run()?);
            times_ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
        Ok::<_, AnyError>((found, times_ms))
    })?;
    times_ms.sort_by(f64::total_cmp);
    let times = format!("{:.2} {:.2}\n", times_ms[times_ms.len() / 2], times_ms[0]);
    std::fs::write(format!("{out}_ms.txt"), times)?;
    write(out, &found)
}

/// The pose of a camera on its side that looks down by 47°, 1.3 m over the ground, as in the scenes that ship.
fn head() -> Isometry3<f64> {
    Isometry3::new(Vector3::z() * 1.3, Vector3::y() * 137_f64.to_radians())
}

fn write(out: &str, found: &Extraction) -> Result<(), AnyError> {
    let pixels = found.segmentation.as_ref().ok_or("no labels")?;
    let triangles = |number: usize| -> Vec<[[f64; 3]; 3]> {
        let faces = found.faces.iter().zip(&pixels.plane_of_face);
        let of_plane = faces.filter(|(_, plane)| usize::from(**plane) == number);
        let of_face = |(face, _): (&surfaces::Face, &u16)| {
            let at = |p: Point2<f64>| <[f64; 3]>::from(face.point_W(&p).coords);
            let left = face.inset_region(2.0, 0.0).regions().into_iter();
            let triangles = left.flat_map(|region| region.triangles());
            triangles.map(|t| t.map(at)).collect::<Vec<_>>()
        };
        of_plane.flat_map(of_face).collect()
    };
    let entry = |(number, plane): (usize, &Option<(nalgebra::Vector3<f64>, f64)>)| {
        let (n, d) = plane.map_or(([0.0; 3], 0.0), |(n, d)| (n.into(), d));
        let (polys, [a, b, c]) = (triangles(number), n);
        format!("{{\"plane\":[{a},{b},{c},{d}],\"polys\":{polys:?}}}")
    };
    let entries: Vec<String> = pixels.planes_V.iter().enumerate().map(entry).collect();
    std::fs::write(
        format!("{out}.json"),
        format!("[{}]\n", entries.join(",\n")),
    )?;
    let labels: Vec<u8> = pixels.labels.iter().flat_map(|l| l.to_le_bytes()).collect();
    std::fs::write(format!("{out}_labels.bin"), labels)?;
    Ok(())
}
