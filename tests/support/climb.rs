//! The humanoid that ships, and a plan that the search makes for it on exactly known stairs.
#![allow(dead_code, non_snake_case, clippy::unwrap_used)]

use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use planner::plan::{GoalRecord, PLAN_FORMAT, Plan, Program, RequiredMargins, RobotSummary};
use planner::{Goal, Guide, Request, Start, Status};
use posture::{BaseGoal, Environment};
use robot_model::{Kinematics, Robot};
use surfaces::{ConvexPolygon, Surface, SurfaceSet};

/// The robot.
pub fn humanoid() -> Robot {
    robot_model::load_from_strings(
        include_str!("../../scenes/robots/hrp2/hrp2.urdf"),
        Some(include_str!("../../scenes/robots/hrp2/hrp2.srdf")),
        Some(include_str!("../../scenes/robots/hrp2/contacts.toml")),
        "hrp2",
        &|_| Err("it has no meshes".to_owned()),
        &robot_model::Config::default(),
    )
    .unwrap()
}

/// A rectangle by its middle, axes and half sizes.
fn face(
    id: String,
    p: Vector3<f64>,
    x: Vector3<f64>,
    y: Vector3<f64>,
    [a, b]: [f64; 2],
) -> Surface {
    let turn = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(p.into(), UnitQuaternion::from_rotation_matrix(&turn));
    let polygon = vec![[-a, -b], [a, -b], [a, b], [-a, b]];
    let mut surface = Surface::new(id, pose, ConvexPolygon::try_from(polygon).unwrap());
    surface.inset_m = 0.01;
    surface
}

/// A floor and `steps` steps of 0.15 m, each with its front.
fn stairs(steps: usize) -> SurfaceSet {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut surfaces = vec![face(
        "floor".into(),
        Vector3::new(-0.2, 0.0, 0.0),
        x,
        y,
        [0.44, 1.0],
    )];
    for k in 0..steps {
        let (start, length) = (
            0.24 + 0.34 * k as f64,
            if k + 1 == steps { 1.0 } else { 0.34 },
        );
        let height = 0.15 * (k + 1) as f64;
        let top = Vector3::new(start + length / 2.0, 0.0, height);
        surfaces.push(face(format!("step{k}"), top, x, y, [length / 2.0, 0.6]));
        let front = Vector3::new(start, 0.0, height / 2.0);
        surfaces.push(face(format!("front{k}"), front, -y, z, [0.6, height / 2.0]));
    }
    SurfaceSet {
        surfaces,
        obstacles: Vec::new(),
    }
}

/// A plan for the robot: up `steps` steps.
pub fn plan(robot: &Robot, steps: usize) -> Plan {
    let set = stairs(steps);
    let thickness_m = 0.05;
    let environment = Environment::new(&set, thickness_m).unwrap();
    let mut configuration = robot.posture("half_sitting").unwrap();
    let feet = ["left_foot", "right_foot"].map(|name| robot.patch_index(name).unwrap());
    let sole = Kinematics::new(robot, &configuration).X_WC(&robot.patches[feet[0]]);
    configuration.p_WB.z -= sole.translation.vector.z;
    let from = configuration.p_WB;
    let to = Vector3::new(0.34 * steps as f64 + 0.2, 0.0, 0.15 * steps as f64);
    let walkable: Vec<usize> = (0..set.surfaces.len())
        .filter(|i| set.surfaces[*i].normal_W().z > 0.8)
        .collect();
    let usable = robot.patches.iter().map(|patch| {
        if patch.has_role("foot") {
            walkable.clone()
        } else {
            Vec::new()
        }
    });
    let tolerance_m = 0.15;
    let request = Request {
        robot,
        environment: &environment,
        start: Start {
            configuration: configuration.clone(),
            contacts: feet.map(|patch| (patch, 0)).to_vec(),
        },
        goal: Goal {
            base: BaseGoal {
                position_m: [Some(to.x), Some(to.y), None],
                tolerance_m,
                yaw_rad: None,
                yaw_tolerance_rad: 0.1,
            },
            patches: feet.to_vec(),
            contacts: Vec::new(),
        },
        guide: Guide::new(vec![from, from + to]).unwrap(),
        usable: usable.collect(),
        reference: configuration,
    };
    let config = posture::Config::default();
    let search = planner::Config::default();
    let never = AtomicBool::new(false);
    let answer = planner::search(
        &request,
        &search,
        &config,
        &motion::Config::default(),
        &|_| {},
        &never,
    )
    .unwrap();
    assert_eq!(answer.status, Status::Found, "{:?}", answer.blocked.first());
    Plan {
        format: PLAN_FORMAT.to_owned(),
        program: Program {
            name: "scandent".to_owned(),
            version: "test".to_owned(),
        },
        scene: "exact-stairs".to_owned(),
        seed: 0,
        config: serde_json::Value::Null,
        inputs: Vec::new(),
        robot: RobotSummary {
            name: robot.name.clone(),
            joint_names: robot.joint_names().map(str::to_owned).collect(),
            mass_kg: robot.mass_kg,
        },
        stances: planner::record::stances(robot, &environment, &answer.path),
        surfaces: set.surfaces,
        obstacles: set.obstacles,
        thin_body_m: thickness_m,
        required: RequiredMargins::from(&config),
        goal: GoalRecord {
            base_position_m: Some([Some(to.x), Some(to.y), None]),
            tolerance_m,
            yaw_rad: None,
            contacts: Vec::new(),
        },
        motion: None,
        search: answer.summary,
    }
}
