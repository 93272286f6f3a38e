//! Stairs of blocks on a floor.

use nalgebra::{UnitQuaternion, Vector3};
use planner::Status;
use robot_model::Configuration;
use surfaces::{Face, Terrain};

use crate::support::{face, humanoid, request, search, world};

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

#[test]
fn stairs_are_climbed_the_same_on_any_number_of_threads() {
    let robot = humanoid();
    let environment = world(stairs());
    let request = request(&robot, &environment, Vector3::new(1.9, 0.0, 0.71));
    let plan = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| search(&request).unwrap())
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
    let environment = world(stairs());
    let refused = |change: &dyn Fn(&mut Configuration)| {
        let mut request = request(&robot, &environment, Vector3::new(1.9, 0.0, 0.71));
        change(&mut request.start.configuration);
        search(&request).expect_err("this is no stance").to_string()
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
