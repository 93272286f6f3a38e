//! The quadruped walks up slopes from exactly known surfaces, straight and at an angle to the fall
//! line; the verifier agrees with every stance and every sample of the motion, and physics with the
//! whole.
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use planner::Status;
use surfaces::{Obstacle, Terrain};

use crate::support::program::{ends_with, robot};
use crate::support::walk::{Walk, Walked, face};

/// Where the slope starts on the robot's way: the front feet stand at 0.33 m.
const START_M: f64 = 0.8;
/// Length of the slope's face, m.
const LENGTH_M: f64 = 3.0;
/// How far up the slope the base goes along its way, m, measured level.
const UP_M: f64 = 1.0;

/// Ground, and a slope of `delta_deg` whose fall line is turned by `turn_deg` from the way ahead.
fn slope(delta_deg: f64, turn_deg: f64) -> (Terrain, Vec<Vector3<f64>>) {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), turn_deg.to_radians());
    let (sin, cos) = delta_deg.to_radians().sin_cos();
    let level = turn * Vector3::x();
    let across = turn * Vector3::y();
    let up = level * cos + Vector3::z() * sin;
    let start = Vector3::new(START_M, 0.0, 0.0);
    let half = 0.5 * LENGTH_M;
    // The ground ends at the start line: beyond it the slope stands on it.
    let ground = start - level * half;
    let terrain = Terrain {
        faces: vec![
            face("ground", ground, level, across, [half, 2.0]),
            face("slope", start + up * half, up, across, [half, 2.0]),
        ],
        obstacles: Vec::new(),
    };
    // Straight ahead; the base keeps its height over the ground, then over the slope.
    let rise = UP_M * turn_deg.to_radians().cos() * sin / cos;
    let way = vec![
        Vector3::new(START_M, 0.0, 0.0),
        Vector3::new(START_M + UP_M, 0.0, rise),
    ];
    (terrain, way)
}

fn walked(delta_deg: f64, turn_deg: f64) -> Walked {
    let (terrain, way) = slope(delta_deg, turn_deg);
    walk(terrain, way)
}

fn walk(terrain: Terrain, way: Vec<Vector3<f64>>) -> Walked {
    let walk = Walk {
        robot: robot("quadruped"),
        terrain,
        way,
        tolerance_m: 0.1,
        goal_face: Some("slope"),
        usable: ["ground", "slope"].map(str::to_owned).to_vec(),
        posture: posture::Config::default(),
    };
    walk.plan()
}

fn climbs(delta_deg: f64, turn_deg: f64) -> Walked {
    let walked = walked(delta_deg, turn_deg);
    walked.show(&format!("quadruped-{delta_deg}-{turn_deg}"));
    walked.assert_certified();
    #[cfg(feature = "mujoco")]
    walked.assert_executed();
    walked
}

#[test]
fn up_slopes_at_30_degrees_to_the_fall_line() {
    climbs(10.5, 30.0);
    climbs(23.8, 30.0);
}

/// What evades a pole comes to a stance in that stance's posture or not at all: a limb that ends on
/// the other side would leap.
#[test]
fn past_a_pole_no_limb_leaps() {
    let mut found = 0;
    let places = [0.6, 0.8].map(|x| [[x, 0.26], [x, -0.26]]);
    for [x, y] in places.into_iter().flatten() {
        let (mut terrain, way) = slope(10.5, 0.0);
        let (low, high) = ([x - 0.02, y - 0.02, 0.0], [x + 0.02, y + 0.02, 1.5]);
        terrain.obstacles.push(Obstacle::cuboid("pole", low, high));
        let walked = walk(terrain, way);
        if walked.answer.status == Status::Found {
            walked.assert_certified();
            found += 1;
        }
    }
    assert!(found >= 2, "{found} ways past a pole");
}

/// With friction 0.9, of which plans use 80 %, feet hold on up to 35.8°. Where hind feet on the ground may help, that is
/// no proof, and a short search finds nothing; farther up it is.
#[test]
fn what_friction_does_not_hold_is_refused_with_the_number() {
    for (farther, status) in [(1.0, Status::BudgetSpent), (2.2, Status::NoPlan)] {
        let (terrain, mut way) = slope(38.0, 0.0);
        way[1] = way[0] + (way[1] - way[0]) * farther;
        let walked = walk(terrain, way);
        assert_eq!(walked.answer.status, status);
        let all = &walked.answer.blocked;
        let named =
            |reason: &str| reason.contains("slopes by 38.0°") && reason.contains("up to 35.8°");
        assert!(all.iter().any(|blocked| named(&blocked.reason)), "{all:?}");
        let search = &walked.plan.search;
        assert!(search.nodes_generated <= 41, "{}", search.nodes_generated);
        assert!(status != Status::NoPlan || (all.len() == 1 && search.candidates_solved == 0));
    }
}

/// The steeper, the shorter the steps, the nearer the body to the slope and the more it pitches:
/// stances, distance of the base from the face, pitch.
#[test]
fn up_slopes_straight_with_steps_height_and_pitch_that_follow_them() {
    let measured = [0.0, 10.5, 23.8].map(|delta_deg: f64| {
        let walked = match delta_deg {
            0.0 => walked(delta_deg, 0.0),
            _ => climbs(delta_deg, 0.0),
        };
        assert_eq!(walked.answer.status, Status::Found);
        let stances = &walked.plan.stances;
        let (sin, cos) = delta_deg.to_radians().sin_cos();
        // Two steps of each leg, each off and onto, but for the goal's stance, whose place is the goal's: the body sways.
        let last = &stances[stances.len() - 17..stances.len() - 1];
        let heights = last.iter().map(|s| s.q[2] * cos - (s.q[0] - START_M) * sin);
        let height = heights.sum::<f64>() / last.len() as f64;
        let q = &stances[stances.len() - 2].q;
        let turn = UnitQuaternion::new_normalize([3, 4, 5, 6].map(|i| q[i]).into());
        let pitch = (turn * Vector3::x()).z.asin();
        (stances.len(), height, pitch.to_degrees())
    });
    let [level, gentle, steep] = measured;
    assert!(level.0 < gentle.0 && gentle.0 <= steep.0, "{measured:?}");
    // On a gentle slope shanks that are off it hold the body up about as on the level.
    let about = level.1 + 0.005;
    assert!(about > gentle.1 && gentle.1 > steep.1, "{measured:?}");
    // To what it sways by from step to step.
    for ((_, _, pitch), wanted) in [(level, 0.0), (gentle, 10.5), (steep, 23.8)] {
        assert!((pitch - wanted).abs() < 6.0, "{pitch}° on {wanted}°");
    }
}

/// The program ends well with a plan on balls: files of the formats that know of them.
#[test]
fn the_program_plans_and_verifies_and_refuses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (terrain, _) = slope(23.8, 0.0);
    let surfaces = folder.path().join("surfaces.json");
    std::fs::write(&surfaces, terrain.to_json().expect("JSON")).expect("writable");
    let plan = |name: &str, goal: &str, friction: &str, code: i32, words: &[&str]| {
        let out = folder.path().join(name);
        let robot = format!("--robot builtin:quadruped --friction {friction}");
        let line = format!("plan --surfaces @ {robot} --goal {goal} --guide 0.8,0,0.55 -o @");
        ends_with(&line, &[&surfaces, &out], code, words);
        out
    };
    let found = plan("found", "1.8,0", "0.9", 0, &[]);
    for (name, written) in [
        ("plan.json", true),
        ("plan.csv", true),
        ("contacts.yaml", false),
    ] {
        assert_eq!(found.join(name).exists(), written, "{name}");
    }
    plan("doubted", "1.8,0", "0.5", 4, &["holds up to 21.8°"]);
    plan("refused", "3.0,0", "0.5", 3, &["holds up to 21.8°"]);
}
