//! Where the robot stands, nothing else is.
#![allow(non_snake_case)]

use robot_model::collision::World;
use robot_model::{Configuration, Kinematics, Robot};
use surfaces::{Obstacle, Terrain};

/// Drops the bodies beyond the view that the robot at its start would be too near to: what was
/// assumed there cannot be. Returns their names.
///
/// Bodies of a face's rim stay: the face itself was seen.
pub fn drop_refuted(
    terrain: &mut Terrain,
    robot: &Robot,
    configuration: &Configuration,
    clearance_m: f64,
) -> Vec<String> {
    let kinematics = Kinematics::new(robot, configuration);
    let meets = |obstacle: &Obstacle| {
        let Ok(world) = World::new(&[&obstacle.points_W]) else {
            return true;
        };
        let mut near = Vec::new();
        let (collision, all) = (&robot.collision, |_, _| false);
        collision.world_proximities(&kinematics, &world, clearance_m, &all, &mut near);
        !near.is_empty()
    };
    let mut dropped = Vec::new();
    terrain.obstacles.retain(|obstacle| {
        let refuted = obstacle.assumed && obstacle.surface.is_none() && meets(obstacle);
        if refuted {
            dropped.push(obstacle.id.clone());
        }
        !refuted
    });
    dropped
}
