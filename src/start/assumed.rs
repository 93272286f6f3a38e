//! Where the robot stands, nothing else is.

use nalgebra::{Point3, Vector3};
use robot_model::collision::{BodyShape, World};
use robot_model::{Kinematics, PatchId, Robot};
use surfaces::loose::is_loose;
use surfaces::{Obstacle, Terrain};

use super::StartState;

/// Drops the bodies beyond the view, and of points that lie on no face, that the robot at its start would be too near
/// to, or one of its feet where it was put down, straight from `raised_m` over its place: what was assumed there cannot
/// be, and what was seen there is the robot. Returns their names.
///
/// Bodies of a face's rim stay: the face itself was seen.
pub fn drop_refuted(
    terrain: &mut Terrain,
    robot: &Robot,
    start: &StartState,
    clearance_m: f64,
    raised_m: f64,
) -> Vec<String> {
    let meets =
        |obstacle: &Obstacle| meets(&obstacle.points_W, robot, start, clearance_m, raised_m);
    let mut dropped = Vec::new();
    terrain.obstacles.retain(|obstacle| {
        let refuted = may_be_refuted(obstacle) && meets(obstacle);
        if refuted {
            dropped.push(obstacle.id.clone());
        }
        !refuted
    });
    dropped
}

/// Whether a body gives way to a robot that stands there: it lies beyond the view, or is of points on no face.
pub fn may_be_refuted(obstacle: &Obstacle) -> bool {
    (obstacle.assumed && obstacle.surface.is_none()) || is_loose(obstacle)
}

/// Whether the robot at its start would be too near to a body, or one of its feet where it was put down, straight from
/// `raised_m` over its place.
///
/// Units: m.  Frames: W.
pub fn meets(
    body_W: &[Point3<f64>],
    robot: &Robot,
    start: &StartState,
    clearance_m: f64,
    raised_m: f64,
) -> bool {
    let kinematics = Kinematics::new(robot, &start.configuration);
    // Instead of the foot the body is moved, the other way.
    let is_near = |foot: Option<PatchId>, raised_m: f64| {
        let down = Vector3::z() * raised_m;
        let points: Vec<_> = body_W.iter().map(|p| p - down).collect();
        let Ok(world) = World::new(&[&points]) else {
            return true;
        };
        let body = foot.map(|foot| robot.patches[foot].body);
        let except = |shape: BodyShape, _| body.is_some_and(|body| shape.body != body);
        let mut near = Vec::new();
        let collision = &robot.collision;
        collision.world_proximities(&kinematics, &world, clearance_m, &except, &mut near);
        !near.is_empty()
    };
    let mut feet = start.patches.iter();
    is_near(None, 0.0)
        || feet.any(|&foot| {
            [0.5, 1.0]
                .iter()
                .any(|part| is_near(Some(foot), part * raised_m))
        })
}

#[cfg(test)]
mod tests {
    use posture::{Config, Environment};

    use super::*;
    use crate::scene::Start;
    use crate::start::stand;

    #[test]
    fn what_was_seen_where_the_robot_stands_is_the_robot() {
        let robot = scenes::robot("hrp2").unwrap();
        let nothing = Environment::default();
        let start = stand(&robot, &Start::default(), &nothing, &Config::default()).unwrap();
        let body = |id: &str, x: f64| Obstacle::cuboid(id, [x, -0.1, 0.3], [x + 0.1, 0.1, 0.4]);
        let mut terrain = Terrain {
            faces: Vec::new(),
            obstacles: vec![
                body("loose0", 0.0),
                body("loose1", 1.0),
                body("loose plank", 0.0),
            ],
        };
        let dropped = drop_refuted(&mut terrain, &robot, &start, 0.02, 0.1);
        assert_eq!(dropped, ["loose0"]);
        let left: Vec<&str> = terrain.obstacles.iter().map(|o| o.id.as_str()).collect();
        assert_eq!(left, ["loose1", "loose plank"]);
    }
}
