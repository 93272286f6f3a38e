//! Faces in simulated frames, as images and as clouds, and in real scans.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::found::{Found, read};
use crate::frames::{Frame, pose, write_pcd};
use crate::program::{Program, argument, json};
use crate::score::Score;
use crate::table::Worse::{Less, More, Neither};
use crate::table::{Table, column, mean, median};

/// Faces of known worlds, one row a kind of noise and of scan.
pub fn simulated(program: &Program, frames: &[Frame], folder: &Path) -> Result<Table> {
    let mut table = Table::new(
        &format!("Faces in {} simulated frames", frames.len()),
        vec![
            column("rec50", Less, 0.01, 0.0, 3),
            column("prec50", Less, 0.01, 0.0, 3),
            column("rec80", Less, 0.02, 0.0, 3),
            column("tops", Less, 0.01, 0.0, 3),
            column("RMS mm", More, 0.1, 0.05, 2),
            column("p90 mm", More, 0.3, 0.05, 1),
            column("off the face %", More, 0.05, 0.0, 2),
            column("cover %", Less, 1.0, 0.0, 1),
            column("planes", Neither, 0.0, 0.0, 0),
        ],
    );
    for noise in ["real", "white"] {
        for (name, kind) in [("image", "png"), ("cloud", "pcd")] {
            let mut score = Score::default();
            for frame in frames.iter().filter(|f| f.name.starts_with(noise)) {
                let scan = folder.join(format!("{}.{kind}", frame.name));
                match kind {
                    "png" => std::fs::write(&scan, frame.scan.png()?)?,
                    _ => write_pcd(&scan, &frame.scan, false)?,
                }
                let flags = format!("--sensor xtion --pose={}", pose(&frame.X_WV));
                score.add(frame, &extract(program, &scan, &flags, folder)?);
            }
            table.push(format!("{name}, {noise} noise"), figures(&score));
        }
    }
    table.note(
        "Found by half (rec50) or four fifths (rec80) of the union of pixels; of the planes found those that are a \
         face's (prec50); *off the face* and *cover* of the upward faces found, after the insets.",
    );
    Ok(table)
}

fn figures(score: &Score) -> Vec<Option<f64>> {
    let part = |n: usize, of: usize| (of > 0).then(|| n as f64 / of as f64);
    let mut rms = score.rms_m.clone();
    rms.sort_by(f64::total_cmp);
    let mm = |m: f64| 1e3 * m;
    vec![
        part(score.found[0], score.faces),
        part(score.planes[1], score.planes[0]),
        part(score.found[1], score.faces),
        part(score.tops[1], score.tops[0]),
        median(&rms).map(mm),
        rms.get(rms.len() * 9 / 10).copied().map(mm),
        (score.area_m2[0] > 0.0).then(|| 100.0 * score.area_m2[1] / score.area_m2[0]),
        mean(&score.cover).map(|c| 100.0 * c),
        Some(score.planes[0] as f64),
    ]
}

/// The faces that the program finds in a scan.
fn extract(program: &Program, scan: &Path, flags: &str, folder: &Path) -> Result<Vec<Found>> {
    let (scan, out) = (argument(scan), folder.join("surfaces.json"));
    let to = argument(&out);
    let mut args = vec!["surfaces", &scan, "-o", &to];
    args.extend(flags.split_whitespace());
    program.run(&args, &[0])?;
    read(&json(&out)?)
}

/// Real scans (`shared/scans/MANIFEST.md` says what they show) and the flags that read them.
const SCANS: [(&str, &str); 11] = [
    ("rgbd/k2_stairs_0000_depth.png", STAIRS),
    ("rgbd/k2_stairs_0001_depth.png", STAIRS),
    ("rgbd/mrpt_kinect_depth.png", MRPT),
    ("rgbd/rs_polylidar_00000000_depth.png", REALSENSE),
    ("rgbd/rs_polylidar_00000002_depth.png", REALSENSE),
    ("rgbd/rs_polylidar_00000004_depth.png", REALSENSE),
    ("rgbd/rs_polylidar_00000006_depth.png", REALSENSE),
    ("rgbd/cape_seq_example_depth.png", CAPE),
    ("lidar/planeseg_tilted-steps.pcd", "--eye 0.248,0.012,1.806"),
    (
        "lidar/planeseg_terrain_close_rect.pcd",
        "--eye=-0.029,-0.006,0.088",
    ),
    ("lidar/nebula_vlp16_1673400472138016708.pcd", ""),
];
const STAIRS: &str = "--sensor kinect_v2:365.3178,365.3172,254.6861,208.5499 \
                      --pose 0,0,0.975,-0.5914688,0.7975744,-0.0705781,0.0951757";
const MRPT: &str = "--sensor kinect_v1:572.9,542.7,314.6,240.2";
const CAPE: &str = "--sensor kinect_v1:575.93,576.41,315.15,230.59";
const REALSENSE: &str = "--sensor realsense_d4xx:307.853,307.864,204.473,121.658";

/// Faces of the real scans in `scans`; those that are not there are named in the notes.
pub fn real(program: &Program, scans: &Path, folder: &Path) -> Result<Table> {
    let mut table = Table::new(
        "Faces in real scans",
        vec![
            column("planes", Neither, 0.0, 0.0, 0),
            column("area m²", Less, 0.05, 0.1, 2),
            column("touchable m²", Less, 0.05, 0.1, 2),
            column("RMS mm", More, 0.3, 0.1, 2),
        ],
    );
    for (name, flags) in SCANS {
        let path: PathBuf = scans.join(name);
        if !path.exists() {
            eprintln!("SKIPPED: {} is not there", path.display());
            table.note(format!("SKIPPED: {name} is not there."));
            continue;
        }
        let found = extract(program, &path, flags, folder)?;
        let (mut area, mut touchable, mut squares) = (0.0, 0.0, 0.0);
        for face in &found {
            area += face.outline.area();
            touchable += face.touchable.area();
            squares += face.outline.area() * face.rms_m * face.rms_m;
        }
        let rms = (area > 0.0).then(|| 1e3 * f64::sqrt(squares / area));
        let count = found.len() as f64;
        table.push(name, vec![Some(count), Some(area), Some(touchable), rms]);
    }
    Ok(table)
}
