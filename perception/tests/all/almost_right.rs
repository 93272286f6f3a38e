//! Input in another unit, of another lens or along rays is not taken for what it is not.

use std::path::Path;

use perception::{Config, Intrinsics, PosedScan, SensorOptions, parse_scan, perceive};

use crate::scan_files::png;

/// A floor 1 m below a camera that looks down by 45°, as depths in metres.
fn floor(v: u32) -> f64 {
    let slope = (f64::from(v) - 239.5) / 525.0;
    std::f64::consts::SQRT_2 / (1.0 + slope)
}

#[test]
fn input_that_is_almost_right_is_said_to_be_so() {
    let image = |unit_m: f64| {
        let row = |v: u32| ((floor(v) / unit_m) as u16).to_be_bytes().repeat(640);
        let rows: Vec<u8> = (0..480).flat_map(row).collect();
        png(640, 480, png::BitDepth::Sixteen, &rows)
    };
    // Distances along the rays, in mm.
    let distances = {
        let of = |(v, u): (u32, u32)| {
            let [x, y] = [(u, 319.5), (v, 239.5)].map(|(c, c0)| (f64::from(c) - c0) / 525.0);
            (1e3 * floor(v) * (1.0 + x * x + y * y).sqrt()) as u16
        };
        let pixels = (0..480).flat_map(|v| (0..640).map(move |u| (v, u)));
        let rows: Vec<u8> = pixels.flat_map(|at| of(at).to_be_bytes()).collect();
        png(640, 480, png::BitDepth::Sixteen, &rows)
    };
    let cloud = |unit_m: f64| {
        let points = (0..480)
            .step_by(8)
            .flat_map(|v| (0..640).step_by(8).map(move |u| (u, v)));
        let point = |(u, v): (u32, u32)| {
            let z = floor(v) / unit_m;
            let (x, y) = (
                (f64::from(u) - 319.5) / 525.0,
                (f64::from(v) - 239.5) / 525.0,
            );
            format!("{} {} {z}\n", x * z, y * z)
        };
        let rows: Vec<String> = points.map(point).collect();
        let count = rows.len();
        let head = "ply\nformat ascii 1.0\nelement vertex";
        let axes = "property float x\nproperty float y\nproperty float z\nend_header";
        format!("{head} {count}\n{axes}\n{}", rows.concat()).into_bytes()
    };
    // What the error or a warning says; none of what is right.
    let said = |name: &str, bytes: &[u8], options: &SensorOptions, range_max_m: f64| {
        let config = Config {
            range_max_m,
            ..Config::default()
        };
        let scan = match parse_scan(Path::new(name), bytes, options) {
            Ok(scan) => scan,
            Err(cause) => return cause.to_string(),
        };
        let X_WV = scan.X_WV;
        let posed = PosedScan::Scan {
            name,
            scan: &scan,
            X_WV,
        };
        match perceive(&[posed], &config) {
            Ok(found) => {
                let said = found.notices.iter().map(ToString::to_string);
                said.filter(|notice| notice.starts_with("warning"))
                    .collect()
            }
            Err(cause) => cause.to_string(),
        }
    };
    let [xtion, generic] = ["xtion", "generic"].map(|sensor| SensorOptions {
        sensor: sensor.into(),
        ..SensorOptions::default()
    });
    let pinhole = |f: f64, cx: f64, cy: f64| SensorOptions {
        intrinsics: Some(Intrinsics {
            fx: f,
            fy: f,
            cx,
            cy,
        }),
        ..xtion.clone()
    };
    let (of_half_size, of_mm) = (pinhole(262.5, 159.5, 119.5), pinhole(3.6, 319.5, 239.5));
    let (unit, size) = (
        "is a unit 0.001 m? Another is the last number of --sensor",
        "of another image size?",
    );
    let (ray, mm) = ("distances along the rays", "is the file in mm or cm?");
    let near = said("range.png", &image(1e-3), &xtion, 0.5);
    assert!(
        near.contains("0 of 307200 points are within 0.5 m"),
        "{near}"
    );
    for (name, bytes, options, expected) in [
        ("mm.png", image(1e-3), &xtion, ""),
        ("cm.png", image(1e-2), &xtion, unit),
        ("tenths.png", image(1e-4), &xtion, unit),
        ("size.png", image(1e-3), &of_half_size, size),
        ("focal.png", image(1e-3), &of_mm, "in another unit"),
        ("distances.png", distances, &xtion, ray),
        ("m.ply", cloud(1.0), &generic, ""),
        ("mm.ply", cloud(1e-3), &generic, mm),
        ("cm.ply", cloud(1e-2), &generic, mm),
    ] {
        let said = said(name, &bytes, options, 5.0);
        assert_eq!(said.is_empty(), expected.is_empty(), "{name}: {said}");
        assert!(said.contains(expected), "{name}: {said}");
        assert!(said.is_empty() || said.contains(name), "{name}: {said}");
    }
}
