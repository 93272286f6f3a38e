//! The whole search on exactly known stairs, with the humanoid that ships.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, Point2, Rotation3, Translation3, UnitQuaternion, Vector3};
use planner::{Config, Goal, Guide, Request, Start, Status};
use posture::{BaseGoal, Environment, FaceIndex};
use robot_model::{Configuration, Robot};
use surfaces::{Face, Region, Terrain};

fn humanoid() -> Robot {
    scenes::builtin_robot("hrp2")
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

/// The rectangle with that middle, axes and half sizes.
fn face(id: &str, p: Vector3<f64>, x: Vector3<f64>, y: Vector3<f64>, half: [f64; 2]) -> Face {
    let rotation = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let pose = Isometry3::from_parts(
        Translation3::from(p),
        UnitQuaternion::from_rotation_matrix(&rotation),
    );
    let [a, b] = half;
    let corners = [(-a, -b), (a, -b), (a, b), (-a, b)].map(|(u, v)| Point2::new(u, v));
    Face::new(id, pose, Region::new([corners.to_vec()]).unwrap())
}

/// Top and front of a box that stands on the floor: centre, length, width, height.
fn block(id: &str, [x, y]: [f64; 2], length: f64, width: f64, height: f64) -> [Face; 2] {
    let (ex, ey, ez) = (Vector3::x(), Vector3::y(), Vector3::z());
    [
        face(
            id,
            Vector3::new(x, y, height),
            ex,
            ey,
            [0.5 * length, 0.5 * width],
        ),
        face(
            &format!("{id}_front"),
            Vector3::new(x - 0.5 * length, y, 0.5 * height),
            -ey,
            ez,
            [0.5 * width, 0.5 * height],
        ),
    ]
}

fn stairs() -> Terrain {
    let mut faces = vec![face(
        "floor",
        Vector3::new(0.3, 0.0, 0.0),
        Vector3::x(),
        Vector3::y(),
        [1.0, 1.0],
    )];
    faces.extend(block("step1", [0.40, 0.0], 0.32, 0.8, 0.15));
    faces.extend(block("step2", [0.72, 0.0], 0.32, 0.8, 0.29));
    faces.extend(block("step3", [1.04, 0.0], 0.32, 0.8, 0.43));
    faces.extend(block("step4", [1.36, 0.0], 0.32, 0.8, 0.57));
    faces.extend(block("table", [2.02, 0.0], 1.0, 1.2, 0.71));
    Terrain {
        faces,
        obstacles: Vec::new(),
    }
}

fn request<'a>(robot: &'a Robot, environment: &'a Environment, to: Vector3<f64>) -> Request<'a> {
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

#[test]
fn stairs_are_climbed_the_same_on_any_number_of_threads() {
    let robot = humanoid();
    let environment = Environment::new(stairs(), 0.05, 2.0).unwrap();
    let request = request(&robot, &environment, Vector3::new(1.9, 0.0, 0.71));
    let plan = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            planner::search(
                &request,
                &Config::default(),
                &posture::Config::default(),
                &motion::Config::default(),
                &|_| {},
                &AtomicBool::new(false),
            )
            .unwrap()
        })
    };
    let one = plan(1);
    assert_eq!(one.status, Status::Found, "{:?}", one.blocked.first());
    // Six placements lift both feet over five steps; anything longer has wandered.
    assert!(one.summary.path_stances <= 13, "{:?}", one.summary);
    let stances = planner::record::stances(&robot, &environment, &one.path);
    for threads in [2, 4] {
        let many = plan(threads);
        assert_eq!(many.summary, one.summary);
        assert_eq!(
            planner::record::stances(&robot, &environment, &many.path),
            stances
        );
    }
}

#[test]
fn a_start_in_collision_or_out_of_balance_is_refused() {
    let robot = humanoid();
    let environment = Environment::new(stairs(), 0.05, 2.0).unwrap();
    let refused = |change: &dyn Fn(&mut Configuration)| {
        let mut request = request(&robot, &environment, Vector3::new(1.9, 0.0, 0.71));
        change(&mut request.start.configuration);
        let search = planner::search(
            &request,
            &Config::default(),
            &posture::Config::default(),
            &motion::Config::default(),
            &|_| {},
            &AtomicBool::new(false),
        );
        search.expect_err("this is no stance").to_string()
    };
    // The knees are in the first step.
    let reason = refused(&|q| q.p_WB.x += 0.25);
    assert!(reason.contains("too near"), "{reason}");
    // Bent forward by 46° at the chest, arms ahead, the CoM leaves the soles.
    let reason = refused(&|q| {
        for (joint, turn) in [
            ("CHEST_JOINT1", 0.8),
            ("RARM_JOINT0", -1.5),
            ("LARM_JOINT0", -1.5),
        ] {
            q.joints[robot.joint_index(joint).unwrap()] += turn;
        }
        q.R_WB = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.2);
    });
    assert!(reason.contains("balance"), "{reason}");
}
