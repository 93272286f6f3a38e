//! `scandent calibrate camera` as a user meets it: joint readings and frames in, the mount out; and
//! what it says of stances and files that will not do.

use std::path::Path;
use std::process::Output;

use scandent::extrinsics::file::Extrinsics;
use scenes::camera_set::{frame, published_extrinsics, readings, table};
use scenes::simulator::{DepthNoise, KINECT, distortion};
use scenes::{stances, worlds};

use crate::support::program::{self, assert_ended, robot, scandent};

/// β and γ in degrees, height in m: pitch and roll mixed.
const STANCES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.68],
    [15.0, 0.0, 0.66],
    [-15.0, 4.0, 0.68],
    [0.0, 15.0, 0.70],
    [3.0, -15.0, 0.68],
    [10.0, 10.0, 0.65],
    [-10.0, 10.0, 0.68],
    [10.0, -10.0, 0.72],
];

/// Writes `poses.csv` and a cloud a stance, by a sensor without noise; the table names the clouds.
fn write_set(folder: &Path, name: &str, stances: &[[f64; 3]]) {
    let robot = robot(name);
    let world = worlds::ground::truth(None, 0).world();
    let (camera, noise) = (KINECT.smaller(5), DepthNoise::none());
    let flat = distortion(&camera, &noise, 0);
    let mut configurations = Vec::new();
    let mut frames = Vec::new();
    for (i, stance) in stances.iter().enumerate() {
        let X_GR = stances::X_GR(*stance);
        configurations.push(readings(&robot, "standing", &X_GR).expect("in reach"));
        let mount = published_extrinsics();
        let shot = frame(&world, &camera, &X_GR, &mount, &noise, &flat, i as u64);
        let points = (0..camera.pixels()).filter(|i| shot.depth_mm[*i] > 0);
        let points = points.map(|i| {
            let ray = camera.ray((i % camera.width) as f64, (i / camera.width) as f64);
            (ray * (0.001 * f64::from(shot.depth_mm[i]))).into()
        });
        let cloud = program::ply(&points.collect::<Vec<_>>());
        let name = format!("{i}.ply");
        std::fs::write(folder.join(&name), cloud).expect("written");
        frames.push(name);
    }
    let text = table(&robot, &configurations, &frames);
    std::fs::write(folder.join("poses.csv"), text).expect("written");
}

fn calibrate(folder: &Path, robot: &str) -> Output {
    let (poses, out) = (folder.join("poses.csv"), folder.join("out"));
    let line = format!("calibrate camera --robot {robot} --poses @ --frames @ -o @");
    scandent(&line, &[&poses, folder, &out])
}

#[test]
fn both_hexapods_find_their_camera() {
    for name in ["hexapod", "hexapod_urp"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_set(folder.path(), name, &STANCES);
        let output = calibrate(folder.path(), &format!("builtin:{name}"));
        assert_ended(&output, 0, &["would help most"]);

        let read = |file: &str| program::read(folder.path().join("out").join(file));
        let mount = Extrinsics::parse(&read("camera.toml")).expect("a mount");
        assert_eq!((mount.robot.as_str(), mount.link.as_str()), (name, "body"));
        let error = mount.X_RV().inverse() * published_extrinsics();
        // Depths are whole millimetres, of thousands of points.
        let (shift, turn) = (error.translation.vector.norm(), error.rotation.angle());
        assert!(
            shift < 0.001 && turn < 0.05_f64.to_radians(),
            "{shift} m, {turn} rad"
        );
        assert_eq!(read("stances.csv").lines().count(), 1 + STANCES.len());
        let page = read("report.html");
        assert_eq!(page.matches("<svg").count(), 4);
        // Nothing is loaded from elsewhere.
        assert!(!page.contains("http") && !page.contains("src="), "{page}");
    }
}

#[test]
fn stances_that_only_pitch_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pitching = [-15.0, -8.0, 0.0, 8.0, 15.0].map(|beta| [beta, 0.0, 0.68]);
    write_set(folder.path(), "hexapod", &pitching);
    let output = calibrate(folder.path(), "builtin:hexapod");
    assert_ended(&output, 1, &["pitch only", "add poses that roll"]);
    assert!(!folder.path().join("out").exists());
}

#[test]
fn files_that_will_not_do_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write =
        |text: &str| std::fs::write(folder.path().join("poses.csv"), text).expect("written");
    let run = || calibrate(folder.path(), "builtin:hexapod");
    assert_ended(&run(), 1, &["poses.csv"]);
    write("frame,front_left_hip\na.png,0\n");
    let words = ["poses.csv", "line 1", "front_left_hip", "front_left_coxa"];
    assert_ended(&run(), 1, &words);
    write("front_left_coxa\n0\n");
    assert_ended(&run(), 1, &["line 2", "front_left_thigh"]);
    write("height_m,roll_rad,pitch_rad\n0.6,0,0\n0.6,0.1,0\n");
    assert_ended(&run(), 1, &["2 stances, but 0 frames"]);
    write("frame,height_m,roll_rad,pitch_rad\nno.png,0.6,0,0\n");
    assert_ended(&run(), 1, &["no.png"]);
}
