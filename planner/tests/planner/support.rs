//! Robots, worlds and requests.

use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use planner::{Config, Error, Request, SearchResult};
use posture::{Environment, stand};
use robot_model::{PatchId, Robot};
use surfaces::{Face, Terrain};

pub fn humanoid() -> Robot {
    robot("hrp2")
}

pub fn robot(name: &str) -> Robot {
    scenes::robot(name).unwrap()
}

/// The rectangle with that middle, axes and half sizes.
pub fn face(id: &str, p: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, half: [f64; 2]) -> Face {
    let rotation = UnitQuaternion::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(p.into(), rotation);
    Face::rectangle(id, pose, half.map(|half| 2.0 * half)).unwrap()
}

/// A robot on its feet over the origin of the face "floor", on its way to a place.
pub fn request<'a>(
    robot: &'a Robot,
    environment: &'a Environment,
    to: Vector3<f64>,
) -> Request<'a> {
    let is_foot = |id: &PatchId| robot.patches[*id].has_role("foot");
    let feet: Vec<PatchId> = robot.patch_ids().filter(is_foot).collect();
    let stands = stand::on_level_ground(robot, &robot.resting(), &feet);
    let floor = environment.face("floor").unwrap();
    let mut request = Request::walk(robot, environment, stands, (&feet, floor), to).unwrap();
    // Wherever the base is over its feet.
    request.goal.base.position_m = [Some(to.x), Some(to.y), None];
    request
}

/// What is found by default.
pub fn search(request: &Request) -> Result<SearchResult, Error> {
    planner::search(
        request,
        &Config::default(),
        &posture::Config::default(),
        &motion::Config::default(),
        &|_| {},
        &AtomicBool::new(false),
    )
}

/// A terrain with bodies behind its faces.
pub fn world(terrain: Terrain) -> Environment {
    Environment::new(terrain, 0.05, 2.0).unwrap()
}
