//! Plans the humanoid that ships over three boxes: cargo run -p scandent-planner --example three_boxes
use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, Vector3};
use planner::{Config, Request, Status};
use posture::{Environment, stand};
use surfaces::{Face, Terrain};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = &scenes::robot("hrp2").ok_or("no robot")?;
    // The tops of three boxes behind a floor, each 10 cm higher than the one before.
    let top = |(name, x, z)| Face::rectangle(name, Isometry3::translation(x, 0.0, z), [0.4, 1.0]);
    let boxes = [("low", 0.4, 0.1), ("middle", 0.8, 0.2), ("high", 1.2, 0.3)];
    let faces = [("floor", 0.0, 0.0)].into_iter().chain(boxes).map(top);
    let terrain = Terrain::new(faces.collect::<Result<_, _>>()?, Vec::new())?;
    let environment = &Environment::new(terrain, 0.05, 0.0)?;

    let feet = [robot.patch_id("left_foot")?, robot.patch_id("right_foot")?];
    let stands = stand::on_level_ground(robot, &robot.resting(), &feet);
    let from = (&feet[..], environment.face("floor")?);
    let by = Vector3::new(1.2, 0.0, 0.3);
    let request = Request::walk(robot, environment, stands, from, by)?;
    let (config, margins, motion) = (Config::default(), Default::default(), Default::default());
    let never = AtomicBool::new(false);
    let found = planner::search(&request, &config, &margins, &motion, &|_| {}, &never)?;
    assert_eq!(found.status, Status::Found);
    let (sets, nodes) = (found.path.len() - 1, found.summary.nodes_generated);
    println!("{sets} contact sets on the path, {nodes} in the tree");
    Ok(())
}
