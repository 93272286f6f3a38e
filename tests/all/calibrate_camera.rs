//! `scandent calibrate camera` as a user meets it: joint readings and frames in, the mount out; and
//! what it says of stances and files that will not do.

use std::f64::consts::PI;
use std::path::Path;
use std::process::Output;

use nalgebra::Vector3;
use robot_model::Configuration;
use scandent::extrinsics::file::Extrinsics;
use scenes::camera_set::{published_extrinsics, readings, table};
use scenes::simulator::{DepthNoise, KINECT, distortion, scan_distorted};
use scenes::{stances, worlds};

use crate::support::program::{self, assert_ended, robot, scandent};

/// β and γ in degrees, height in m: pitch and roll mixed.
pub const STANCES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.68],
    [15.0, 0.0, 0.66],
    [-15.0, 4.0, 0.68],
    [0.0, 15.0, 0.70],
    [3.0, -15.0, 0.68],
    [10.0, 10.0, 0.65],
    [-10.0, 10.0, 0.68],
    [10.0, -10.0, 0.72],
];

/// Writes a cloud a stance, by a sensor without noise of which the points are taken for `seen`; their
/// names.
fn write_frames(
    folder: &Path,
    stances: &[[f64; 3]],
    seen: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Vec<String> {
    let world = worlds::ground::truth(None, 0).world();
    let (camera, noise) = (KINECT.smaller(5), DepthNoise::none());
    let flat = distortion(&camera, &noise, 0);
    let mut frames = Vec::new();
    for (i, stance) in stances.iter().enumerate() {
        let (X_GR, mount) = (stances::X_GR(*stance), published_extrinsics());
        let shot = scan_distorted(&world, &camera, &(X_GR * mount), &noise, &flat, i as u64);
        let points = (0..camera.pixels()).filter(|i| shot.depth_mm[*i] > 0);
        let points = points.map(|i| {
            let ray = camera.ray((i % camera.width) as f64, (i / camera.width) as f64);
            seen(ray * (0.001 * f64::from(shot.depth_mm[i]))).into()
        });
        let cloud = program::ply(&points.collect::<Vec<_>>());
        let name = format!("{i}.ply");
        std::fs::write(folder.join(&name), cloud).expect("written");
        frames.push(name);
    }
    frames
}

/// The joint readings of a robot in these stances.
fn configurations(name: &str, stances: &[[f64; 3]]) -> Vec<Configuration> {
    let robot = robot(name);
    let of = |stance: &[f64; 3]| readings(&robot, "standing", &stances::X_GR(*stance));
    stances.iter().map(|s| of(s).expect("in reach")).collect()
}

/// Writes `poses.csv` and the clouds; the table names the clouds.
pub fn write_set(folder: &Path, name: &str, stances: &[[f64; 3]]) {
    let frames = write_frames(folder, stances, |p| p);
    let text = table(&robot(name), &configurations(name, stances), &frames);
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

/// Every mistake ends with exit code 1, or with a warning on the terminal and the page, that names it.
#[test]
fn mistakes_are_named() {
    // The more tilts, the surer.
    let mut stances = STANCES.to_vec();
    let more = STANCES.map(|[beta, gamma, height]| [0.7 * gamma + 2.0, -0.7 * beta, height + 0.01]);
    stances.extend(more);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |text: &str| std::fs::write(folder.path().join("poses.csv"), text);
    let run = || calibrate(folder.path(), "builtin:hexapod");
    let plain = write_frames(folder.path(), &stances, |p| p);
    let hexapod = robot("hexapod");
    let right = configurations("hexapod", &stances);

    // Joints: times a factor, of all or of those with this ending.
    for (factor, ending, words) in [
        (180.0 / PI, "", "in degrees"),
        (-1.0, "coxa", "sign of the joints \"…coxa\""),
    ] {
        let mut wrong = right.clone();
        let names: Vec<&str> = hexapod.joint_names().collect();
        for configuration in &mut wrong {
            let joints = configuration.joints.iter_mut().zip(&names);
            let of_ending = joints.filter(|(_, name)| name.ends_with(ending));
            of_ending.for_each(|(value, _)| *value *= factor);
        }
        write(&table(&hexapod, &wrong, &plain)).expect("written");
        assert_ended(&run(), 1, &["poses.csv", words]);
    }
    // The columns of two of them, swapped.
    let [a, b] = ["front_left_coxa", "rear_right_thigh"].map(|name| {
        let mut names = hexapod.joint_names();
        names.position(|joint| joint == name).expect("a joint")
    });
    let mut wrong = right.clone();
    for configuration in &mut wrong {
        configuration.joints.swap_rows(a, b);
    }
    write(&table(&hexapod, &wrong, &plain)).expect("written");
    let words = "columns of \"front_left_coxa\" and \"rear_right_thigh\" are swapped";
    assert_ended(&run(), 1, &["poses.csv", words]);
    // Poses: factors of height, roll and pitch.
    for (factors, words) in [
        ([1.0, 180.0 / PI, 180.0 / PI], "pitch_rad are in degrees"),
        ([1000.0, 1.0, 1.0], "height_m is in mm"),
        ([1.0, -1.0, 1.0], "sign of roll_rad or of pitch_rad"),
    ] {
        let mut text = "frame,height_m,roll_rad,pitch_rad\n".to_owned();
        for (stance, frame) in stances.iter().zip(&plain) {
            let X_GR = stances::X_GR(*stance);
            let (roll, pitch, _) = X_GR.rotation.euler_angles();
            let [h, r, p] = factors;
            let row = [h * X_GR.translation.z, r * roll, p * pitch].map(|v| v.to_string());
            text += &format!("{frame},{}\n", row.join(","));
        }
        write(&text).expect("written");
        assert_ended(&run(), 1, &["poses.csv", words]);
    }
    // Frames: shifted, swapped.
    let mut shifted = plain.clone();
    shifted.rotate_left(1);
    write(&table(&hexapod, &right, &shifted)).expect("written");
    assert_ended(&run(), 1, &["rows are shifted", "1 earlier"]);
    // Of a frame that was lost all rows after it have the next one.
    let more: Vec<[f64; 3]> = (stances.iter())
        .map(|[beta, gamma, height]| [0.6 * beta + 3.0, 0.8 * gamma - 2.0, height + 0.005])
        .collect();
    let all = [&stances[..], &more[..]].concat();
    let kept: Vec<String> = (0..all.len()).map(|i| format!("{i}.ply")).collect();
    let both = tempfile::tempdir().expect("a temporary folder");
    write_frames(both.path(), &all, |p| p);
    let rows = &configurations("hexapod", &all)[..all.len() - 1];
    let lost = [&kept[..14], &kept[15..]].concat();
    let text = table(&hexapod, rows, &lost);
    std::fs::write(both.path().join("poses.csv"), text).expect("written");
    let words = ["row 16 and of each after it stands 1 earlier"];
    assert_ended(&calibrate(both.path(), "builtin:hexapod"), 1, &words);
    let backward: Vec<String> = plain.iter().rev().cloned().collect();
    write(&table(&hexapod, &right, &backward)).expect("written");
    assert_ended(&run(), 1, &["are the frames those of their rows"]);
    let mut swapped = plain.clone();
    swapped.swap(1, 3);
    write(&table(&hexapod, &right, &swapped)).expect("written");
    assert_ended(&run(), 0, &["3.ply and 1.ply are swapped"]);
    // The sensor: another focal length, depths too long.
    write(&table(&hexapod, &right, &plain)).expect("written");
    assert_ended(&run(), 0, &["would help most"]);
    let page = || program::read(folder.path().join("out/report.html"));
    assert!(page().contains("agree.</strong>"), "{}", page());
    let focal = |p: Vector3<f64>| Vector3::new(p.x / 1.12, p.y / 1.12, p.z);
    write_frames(folder.path(), &stances, focal);
    assert_ended(&run(), 0, &["not what it is taken for", "fx 0.8", "fy 0.8"]);
    assert!(page().contains("Not to be trusted"), "{}", page());
    write_frames(folder.path(), &stances, |p| 1.1 * p);
    assert_ended(
        &run(),
        0,
        &["not what it is taken for", "the depth scale 0.9"],
    );
}
