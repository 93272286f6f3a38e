//! Robots, worlds and requests.

use nalgebra::{Isometry3, Point2, Rotation3, Translation3, UnitQuaternion, Vector3};
use planner::{Goal, Guide, Request, Start};
use posture::{BaseGoal, Environment, FaceIndex};
use robot_model::{Configuration, Robot};
use surfaces::{Face, Region};

pub fn humanoid() -> Robot {
    scenes::builtin_robot("hrp2")
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

/// The rectangle with that middle, axes and half sizes.
pub fn face(id: &str, p: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, half: [f64; 2]) -> Face {
    let rotation = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(
        Translation3::from(p),
        UnitQuaternion::from_rotation_matrix(&rotation),
    );
    let [a, b] = half;
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b)].map(|(u, v)| Point2::new(u, v));
    Face::new(id, pose, Region::new([corners.to_vec()]).unwrap())
}

/// The humanoid over the origin of the face "floor", on its way to a place.
pub fn request<'a>(
    robot: &'a Robot,
    environment: &'a Environment,
    to: Vector3<f64>,
) -> Request<'a> {
    let mut configuration: Configuration = robot.posture("half_sitting").unwrap();
    configuration.p_WB = Vector3::new(0.0, 0.0, 0.6487);
    let kinematics = robot_model::Kinematics::new(robot, &configuration);
    let foot = |name: &str| robot.patch_id(name).unwrap();
    let sole = kinematics
        .X_WC(&robot.patches[foot("left_foot")])
        .translation
        .vector
        .z;
    configuration.p_WB.z -= sole;
    let level = |face: &FaceIndex| environment[*face].normal_W().z > 0.8;
    let walkable: Vec<FaceIndex> = environment.faces().filter(level).collect();
    let floor = environment.face("floor").unwrap();
    let from = configuration.p_WB;
    Request {
        robot,
        environment,
        start: Start {
            configuration: configuration.clone(),
            contacts: vec![(foot("left_foot"), floor), (foot("right_foot"), floor)],
        },
        goal: Goal {
            base: BaseGoal {
                position_m: [Some(to.x), Some(to.y), None],
                tolerance_m: 0.15,
                yaw_rad: None,
                yaw_tolerance_rad: 0.2,
            },
            patches: vec![foot("left_foot"), foot("right_foot")],
            contacts: Vec::new(),
        },
        guide: Guide::new(vec![from, from + to]).unwrap(),
        usable: robot
            .patches
            .iter()
            .map(|p| {
                if p.has_role("foot") {
                    walkable.clone()
                } else {
                    Vec::new()
                }
            })
            .collect(),
        reference: configuration,
    }
}
