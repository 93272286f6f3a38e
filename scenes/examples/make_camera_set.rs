//! Simulates the 52 poses of [chai2015] Table A1: writes `poses.csv` (joint readings) and a frame a
//! pose, as `scandent calibrate camera` reads them, and prints the true mount.
//!
//! ```sh
//! cargo run --release -p scandent-scenes --example make_camera_set -- FOLDER [ROBOT [SEED]]
//! scandent calibrate camera --robot builtin:hexapod --poses FOLDER/poses.csv --frames FOLDER
//! ```

use std::path::PathBuf;

use scenes::camera_set::{PoseNoise, published_extrinsics, readings, table};
use scenes::simulator::{DepthNoise, KINECT, distortion, scan_distorted};
use scenes::{stances, worlds};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("which folder?")?);
    let name = arguments.next().unwrap_or_else(|| "hexapod".to_owned());
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let robot = scenes::builtin_robot(&name)
        .ok_or("no such robot ships")?
        .load(&robot_model::Config::default())?;
    std::fs::create_dir_all(&folder)?;

    let world = worlds::ground::truth(None, seed).world();
    let mount = published_extrinsics();
    let noise = DepthNoise::default();
    let distortion = distortion(&KINECT, &noise, seed);
    let mut configurations = Vec::new();
    let mut frames = Vec::new();
    for (i, stance) in stances::TABLE_A1.iter().enumerate() {
        let said = stances::X_GR(*stance);
        configurations.push(readings(&robot, "standing", &said)?);
        let pose = PoseNoise::published().disturb(&said, seed, i as u64);
        let seed = seed * 1000 + i as u64;
        let X_WV = pose * mount;
        let shot = scan_distorted(&world, &KINECT, &X_WV, &noise, &distortion, seed);
        let name = format!("pose_{:02}.png", i + 1);
        std::fs::write(folder.join(&name), shot.png()?)?;
        frames.push(name);
    }
    let poses = table(&robot, &configurations, &frames);
    std::fs::write(folder.join("poses.csv"), poses)?;
    let (p, q) = (mount.translation.vector, mount.rotation.coords);
    println!("{} poses in {}", frames.len(), folder.display());
    let (p, q) = (p.as_slice(), q.as_slice());
    println!("true mount: p = {p:?}, quat_xyzw = {q:?}");
    Ok(())
}
