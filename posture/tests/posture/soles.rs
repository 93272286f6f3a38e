//! The humanoid that ships, which stands on soles.

use nalgebra::{Isometry3, Point3, Vector3};
use posture::{
    BaseGoal, Config, Constraint, Contact, Engine, Environment, Explanation, Group, JointGoal,
    Outcome, Problem,
};
use robot_model::collision::Shape;
use robot_model::{Configuration, Kinematics, Robot};
use surfaces::{Face, Obstacle, Terrain};

use crate::world::{on, solve, square, standing, world};

const FEET: [&str; 2] = ["left_foot", "right_foot"];

/// The robot, half sitting on a world of these faces.
fn humanoid(faces: Vec<Face>) -> (Robot, Configuration, Environment) {
    let (robot, q) = standing("hrp2", "half_sitting", FEET[0]);
    (robot, q, world(faces))
}

fn floor() -> Face {
    square("floor", [0.0; 3], 0.0, 1.0)
}

/// The left and the right foot anywhere on two faces.
fn feet(world: &Environment, robot: &Robot, faces: [&str; 2], friction: f64) -> Vec<Contact> {
    let feet = FEET.iter().zip(faces);
    feet.map(|(foot, face)| on(world, robot, foot, face, friction))
        .collect()
}

#[test]
fn it_stands_on_a_step_and_on_the_floor() {
    let step = square("step", [0.4, 0.2, 0.15], 0.1, 0.17);
    let (robot, q, world) = humanoid(vec![floor(), step]);
    let config = Config::default();
    let feet = feet(&world, &robot, ["step", "floor"], 0.6);
    let outcome = solve(&robot, &world, &feet, None, &q, &config);
    let posture = outcome.posture().unwrap_or_else(|| panic!("{outcome:?}"));
    let margins = &posture.margins;
    assert!(margins.inclusion_m.unwrap() >= config.patch_margin_m - 1e-5);
    let clearance_m = margins.clearance_m.unwrap_or(f64::INFINITY);
    assert!(clearance_m >= config.clearance_m - 1e-5);

    // The other engine finds as good a posture.
    let mut robust = config.clone();
    robust.solver.engine = Engine::InteriorPoint;
    let other = solve(&robot, &world, &feet, None, &q, &robust);
    let other = other.posture().expect("the interior point solves it too");
    let (cost, apart) = (posture.cost, (posture.cost - other.cost).abs());
    assert!(apart < 0.02 * (0.1 + cost), "costs differ by {apart}");
}

#[test]
fn out_of_reach_is_said_to_be_out_of_reach() {
    let shelf = square("shelf", [0.3, 0.3, 1.4], 0.0, 0.2);
    let (robot, q, world) = humanoid(vec![floor(), shelf]);
    let feet = feet(&world, &robot, ["shelf", "floor"], 0.6);
    let outcome = solve(&robot, &world, &feet, None, &q, &Config::default());
    let violation = outcome.violation().expect("1.4 m is too high for a foot");
    assert!(violation.amount > 0.01, "{violation:?}");
}

#[test]
fn feet_farther_apart_than_the_robot_is_long_are_proved_impossible() {
    let (robot, q, world) = humanoid(Vec::new());
    let foot = |patch: &str, y: f64| {
        let patch = robot.patch_id(patch).unwrap();
        Contact::at(&robot, patch, Isometry3::translation(0.0, y, 0.0))
    };
    let feet = [foot(FEET[0], 2.5), foot(FEET[1], -2.5)];
    let outcome = solve(&robot, &world, &feet, None, &q, &Config::default());
    let Outcome::Infeasible(violation) = &outcome else {
        panic!("{outcome:?}");
    };
    assert!(matches!(violation.constraint, Constraint::Closure(_)));
}

#[test]
fn a_slope_steeper_than_friction_slips() {
    // Feet on a slope of 31° need 0.8 μ ≥ tan 31°: all of the cone is theirs.
    let (robot, q, world) = humanoid(vec![square("slope", [0.0; 3], 0.54, 1.0)]);
    let config = Config {
        com_margin_m: 0.01,
        ..Config::default()
    };
    let with = |friction: f64| {
        let feet = feet(&world, &robot, ["slope"; 2], friction);
        solve(&robot, &world, &feet, None, &q, &config)
    };
    let least = 0.54_f64.tan() / 0.8;
    let slips = with(0.99 * least);
    let violation = slips.violation().expect("no friction cone holds this");
    use Constraint::{Balance, Closure, Equilibrium};
    let slips = matches!(violation.constraint, Equilibrium | Balance | Closure(_));
    assert!(slips, "{violation:?}");
    assert!(with(1.01 * least).posture().is_some(), "enough friction");
}

#[test]
fn an_unloaded_contact_touches_and_carries_nothing() {
    let (robot, q, world) = humanoid(vec![floor()]);
    let mut feet = feet(&world, &robot, ["floor"; 2], 0.6);
    feet[1].loaded = false;
    let outcome = solve(&robot, &world, &feet, None, &q, &Config::default());
    let posture = outcome.posture().expect("it can stand on one foot");
    let left = &posture.contacts[0].X_WC;
    let com = left.inverse_transform_point(&Point3::from(posture.com_W));
    // The left sole is 0.131 m wide: 30 mm inside leaves ±35.5 mm.
    let inside = com.y.abs() < 0.0356 && com.x.abs() < 0.0851;
    assert!(inside, "CoM at {com} in the left sole");
}

/// Knees that are wanted straighter or more bent than they would be are so, to the tolerance.
#[test]
fn joints_that_are_wanted_are_where_they_are_wanted() {
    let (robot, q, world) = humanoid(vec![floor()]);
    let feet = feet(&world, &robot, ["floor"; 2], 0.6);
    let knees = ["RLEG_JOINT3", "LLEG_JOINT3"].map(|knee| robot.joint_index(knee).unwrap());
    for knee_rad in [0.5, 1.1] {
        let mut goal = JointGoal {
            wanted: vec![None; robot.nj()],
            tolerance_rad: 0.02,
        };
        knees
            .iter()
            .for_each(|&knee| goal.wanted[knee] = Some(knee_rad));
        let problem = Problem {
            joint_goal: Some(&goal),
            ..Problem::new(&robot, &world, feet.clone(), &q)
        };
        let outcome = posture::solve(&problem, &Config::default()).unwrap();
        let posture = outcome.posture().expect("it can stand so");
        for knee in knees {
            assert!((posture.q.joints[knee] - knee_rad).abs() < 0.0201);
        }
    }
}

#[test]
fn the_base_goal_is_kept_or_named() {
    let (robot, q, world) = humanoid(vec![floor()]);
    let kinematics = Kinematics::new(&robot, &q);
    let feet = FEET.map(|foot| {
        let patch = robot.patch_id(foot).unwrap();
        let X_WC = kinematics.X_WC(&robot.patches[patch]);
        Contact::at(&robot, patch, X_WC).on(world.face("floor").unwrap(), &world)
    });
    for (x, possible) in [(0.03, true), (0.6, false)] {
        let goal = BaseGoal {
            position_m: [Some(x), None, None],
            tolerance_m: 0.01,
            ..BaseGoal::default()
        };
        let outcome = solve(&robot, &world, &feet, Some(goal), &q, &Config::default());
        assert_eq!(outcome.posture().is_some(), possible, "{x}: {outcome:?}");
        if let Some(posture) = outcome.posture() {
            assert!((posture.q.p_WB.x - x).abs() < 0.0101);
        }
    }
}

/// Why the feet cannot stand on squares below them, the right one moved.
fn conflict(right: Vector3<f64>, friction: f64, tilt_rad: f64) -> Explanation {
    let (robot, q) = standing("hrp2", "half_sitting", FEET[0]);
    let kinematics = Kinematics::new(&robot, &q);
    let sole = |name: &str| {
        let patch = robot.patch(name).unwrap();
        kinematics.X_WC(patch).translation.vector
    };
    let world = world(vec![
        square("left", sole(FEET[0]).into(), tilt_rad, 0.2),
        square("right", (sole(FEET[1]) + right).into(), tilt_rad, 0.2),
    ]);
    let problem = Problem {
        robot: &robot,
        environment: &world,
        contacts: feet(&world, &robot, ["left", "right"], friction),
        base_goal: None,
        joint_goal: None,
        reference: &q,
        guess: &q,
    };
    let explanation = posture::explain(&problem, &Config::default()).unwrap();
    explanation.expect("no posture")
}

#[test]
fn a_step_too_high_is_explained_by_its_place_and_by_how_much_it_is_too_high() {
    let found = conflict(Vector3::new(0.1, 0.0, 0.9), 0.6, 0.0);
    let words = &found.words;
    assert!(found.conflict.contains(&Group::Place(1)), "{words}");
    assert!(!found.conflict.contains(&Group::Friction), "{words}");
    let mut relaxations = found.relaxations.iter();
    let lower = relaxations.find(|r| r.group == Group::Place(1)).unwrap();
    assert!(lower.amount > 0.02 && lower.amount < 0.6, "{words}");
}

#[test]
fn a_slippery_slope_is_explained_by_the_friction_that_it_would_take() {
    let found = conflict(Vector3::zeros(), 0.3, 0.4);
    let words = &found.words;
    assert!(found.conflict.contains(&Group::Friction), "{words}");
    assert!(found.conflict.contains(&Group::Equilibrium), "{words}");
    let mut relaxations = found.relaxations.iter();
    let needed = relaxations.find(|r| r.group == Group::Friction).unwrap();
    let needed = needed.amount * 0.8 / 0.4f64.tan();
    assert!(needed > 0.99 && needed < 1.01, "{words}: {needed}");
}

#[test]
fn a_robot_too_weak_for_a_step_is_told_the_torques_that_it_would_take() {
    let step = square("step", [0.4, 0.2, 0.15], 0.0, 0.17);
    let (robot, q, world) = humanoid(vec![floor(), step]);
    let mut contacts = feet(&world, &robot, ["step", "floor"], 0.6);
    contacts[1].loaded = false;
    let weak = Config {
        torque_use: 0.1,
        ..Config::default()
    };
    let problem = Problem {
        robot: &robot,
        environment: &world,
        contacts: contacts.clone(),
        base_goal: None,
        joint_goal: None,
        reference: &q,
        guess: &q,
    };
    let found = posture::remedy(&problem, &weak).unwrap();
    let found = found.expect("stronger joints are enough");
    let words = &found.words;
    assert_eq!(found.group, Group::Torques, "{words}");
    assert!(
        words.ends_with("of the limits (10 % may be used)"),
        "{words}"
    );
    let strong = Config {
        torque_use: 1.01 * found.amount,
        ..weak
    };
    let outcome = solve(&robot, &world, &contacts, None, &q, &strong);
    assert!(outcome.posture().is_some(), "{words}: {outcome:?}");
}

/// Clearance is for what scans have where it is not: a sole lies on its ground wherever that is, and its ankle with it.
#[test]
fn links_that_carry_a_sole_may_be_near_its_ground_and_to_nothing_else() {
    let (robot, q, world) = humanoid(vec![floor()]);
    let face = world.face("floor").unwrap();
    let sole = &robot.patches[robot.patch_id(FEET[0]).unwrap()];
    let least_m = |link: &str, self_clearance_m: f64| {
        let shape = collision_shape(&robot, link);
        world.contact_distance_m(&robot, (sole, face), shape, 0, self_clearance_m)
    };
    assert_eq!(least_m("LLEG_LINK5", 0.005), Some(f64::NEG_INFINITY));
    assert_eq!(least_m("LLEG_LINK3", 0.005), Some(0.005));
    for link in ["LLEG_LINK2", "RLEG_LINK3", "RLEG_LINK5"] {
        assert_eq!(least_m(link, 0.005), None, "{link}");
    }
    // The shanks are nearer than this to the floor, and the thighs are not. A beam ahead is kept away from.
    let config = Config {
        clearance_m: 0.32,
        ..Config::default()
    };
    let beam = Obstacle::cuboid("beam", [0.5, -0.5, 0.0], [0.55, 0.5, 0.1]);
    let terrain = Terrain::new(vec![floor()], vec![beam]).unwrap();
    let world = Environment::new(terrain, 0.05, 2.0).unwrap();
    let contacts = feet(&world, &robot, ["floor"; 2], 0.6);
    let outcome = solve(&robot, &world, &contacts, None, &q, &config);
    let posture = outcome.posture().unwrap_or_else(|| panic!("{outcome:?}"));
    let shank = collision_shape(&robot, "LLEG_LINK3");
    let X_WG = Kinematics::new(&robot, &posture.q).X_WB[shank.body] * shank.X_BG;
    let down_G = X_WG.inverse_transform_vector(&-Vector3::z());
    let lowest_W = X_WG * shank.geometry.support(&down_G);
    assert!(lowest_W.z < 0.32, "{}", lowest_W.z);
    assert!(posture.margins.clearance_m.unwrap() >= 0.32 - 1e-4);
}

fn collision_shape<'a>(robot: &'a Robot, link: &str) -> &'a Shape {
    let mut shapes = robot.collision.shapes().iter();
    shapes.find(|shape| shape.link == link).unwrap()
}
