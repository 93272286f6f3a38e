//! Contact sets with known answers, for the humanoid that ships.
#![allow(clippy::unwrap_used)]

use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion, Vector3};
use posture::{
    BaseGoal, Config, Constraint, Contact, Engine, Environment, Outcome, Place, Posture, Problem,
};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};
use surfaces::{ConvexPolygon, Surface, SurfaceSet};

fn humanoid() -> Robot {
    scenes::builtin_robot("hrp2")
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

/// Half sitting with the soles on z = 0.
fn standing(robot: &Robot) -> Configuration {
    let mut q = robot.posture("half_sitting").unwrap();
    let sole = robot.patch("left_foot").unwrap();
    q.p_WB.z -= Kinematics::new(robot, &q).X_WC(sole).translation.vector.z;
    q
}

/// A square of half width `half`, turned by `tilt` about y.
fn square(id: &str, p: Vector3<f64>, tilt_rad: f64, half: f64) -> Surface {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt_rad);
    let polygon = ConvexPolygon::new(
        [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(x, y)| Point2::new(x, y))
            .to_vec(),
    )
    .unwrap();
    Surface::new(
        id,
        Isometry3::from_parts(Translation3::from(p), turn),
        polygon,
    )
}

fn environment(surfaces: Vec<Surface>) -> Environment {
    Environment::new(
        &SurfaceSet {
            surfaces,
            obstacles: Vec::new(),
        },
        0.05,
    )
    .unwrap()
}

fn on(robot: &Robot, patch: &str, surface: usize, friction: f64) -> Contact {
    Contact {
        patch: robot.patch_index(patch).unwrap(),
        place: Place::OnSurface {
            surface,
            toward: None,
            yaw_rad: None,
        },
        loaded: true,
        friction,
    }
}

fn solve(
    robot: &Robot,
    environment: &Environment,
    contacts: Vec<Contact>,
    config: &Config,
) -> Outcome {
    let q = standing(robot);
    let problem = Problem {
        robot,
        environment,
        contacts,
        base_goal: None,
        reference: &q,
        guess: &q,
    };
    posture::solve(&problem, config).unwrap()
}

/// Balance, friction, torques and limits, from the posture alone.
fn assert_sound(robot: &Robot, posture: &Posture, config: &Config, friction: f64) {
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let mut force = Vector3::new(0.0, 0.0, -weight);
    let mut moment = Vector3::zeros();
    let kinematics = Kinematics::new(robot, &posture.q);
    let mut torques = nalgebra::DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut torques);
    for (state, patch) in posture.contacts.iter().zip(&robot.patches) {
        let normal = state.X_WC.rotation * Vector3::z();
        for (p, f) in state.force_points_W.iter().zip(&state.forces_W) {
            force += f;
            moment += (p - kinematics.com_W).cross(f);
            let pressed = f.dot(&normal);
            let slid = (f - pressed * normal).norm();
            assert!(
                pressed >= -1e-6 * weight,
                "a contact pulls with {pressed} N"
            );
            assert!(slid <= friction * config.friction_use * pressed + 1e-5 * weight);
            let mut jacobian = nalgebra::DMatrix::zeros(3, robot.nv());
            kinematics.point_jacobian(robot, patch.body, p, &mut jacobian);
            torques -= jacobian.transpose() * f;
        }
    }
    assert!(force.norm() < 1e-4 * weight, "unbalanced force {force}");
    assert!(moment.norm() < 1e-4 * weight, "unbalanced moment {moment}");
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        let torque = torques[6 + j];
        assert!(
            (torque - posture.torques[j]).abs() < 1e-6 * weight,
            "{}",
            body.joint
        );
        assert!(
            torque.abs() <= body.effort * (config.torque_use + 1e-4),
            "{}",
            body.joint
        );
        let q = posture.q.joints[j];
        assert!(q >= body.lower && q <= body.upper, "{}", body.joint);
    }
}

#[test]
fn it_stands_on_a_step_and_on_the_floor() {
    let robot = humanoid();
    let config = Config::default();
    let floor = square("floor", Vector3::zeros(), 0.0, 1.0);
    let step = square("step", Vector3::new(0.4, 0.2, 0.15), 0.1, 0.17);
    let world = environment(vec![floor, step]);
    let feet = || {
        vec![
            on(&robot, "left_foot", 1, 0.6),
            on(&robot, "right_foot", 0, 0.6),
        ]
    };
    let outcome = solve(&robot, &world, feet(), &config);
    let posture = outcome.posture().unwrap_or_else(|| panic!("{outcome:?}"));
    // The patches are in the order of the contacts here.
    assert_sound(&robot, posture, &config, 0.6);
    assert!(posture.margins.inclusion_m.unwrap() >= config.patch_margin_m - 1e-5);
    assert!(
        posture
            .margins
            .clearance_m
            .is_none_or(|d| d >= config.clearance_m - 1e-5)
    );

    // The other engine finds as good a posture.
    let robust = Config {
        engine: Engine::InteriorPoint,
        ..config.clone()
    };
    let other = solve(&robot, &world, feet(), &robust);
    let other = other.posture().expect("the interior point solves it too");
    assert_sound(&robot, other, &robust, 0.6);
    assert!(
        (posture.cost - other.cost).abs() < 0.02 * (0.1 + posture.cost),
        "costs {} and {}",
        posture.cost,
        other.cost
    );
}

#[test]
fn out_of_reach_is_said_to_be_out_of_reach() {
    let robot = humanoid();
    let world = environment(vec![
        square("floor", Vector3::zeros(), 0.0, 1.0),
        square("shelf", Vector3::new(0.3, 0.3, 1.4), 0.0, 0.2),
    ]);
    let feet = vec![
        on(&robot, "left_foot", 1, 0.6),
        on(&robot, "right_foot", 0, 0.6),
    ];
    let outcome = solve(&robot, &world, feet, &Config::default());
    let violation = outcome
        .violation()
        .expect("a foot at 1.4 m is not possible");
    assert!(violation.amount > 0.01, "{violation:?}");
}

#[test]
fn a_slope_steeper_than_friction_slips() {
    // One foot on a slope of 31° needs μ ≥ 0.6; 0.5 × 0.8 does not do, 1.2 × 0.8/√2 does.
    let robot = humanoid();
    let slope = square("slope", Vector3::zeros(), 0.54, 1.0);
    let world = environment(vec![slope]);
    let config = Config {
        com_margin_m: 0.01,
        ..Config::default()
    };
    let feet = |mu: f64| {
        vec![
            on(&robot, "left_foot", 0, mu),
            on(&robot, "right_foot", 0, mu),
        ]
    };
    let slips = solve(&robot, &world, feet(0.5), &config);
    let violation = slips.violation().expect("no friction pyramid holds this");
    assert!(
        matches!(
            violation.constraint,
            Constraint::Equilibrium | Constraint::Balance | Constraint::Closure(_)
        ),
        "{violation:?}"
    );
    let holds = solve(&robot, &world, feet(1.2), &config);
    assert_sound(
        &robot,
        holds.posture().expect("enough friction"),
        &config,
        1.2,
    );
}

#[test]
fn an_unloaded_contact_touches_and_carries_nothing() {
    let robot = humanoid();
    let world = environment(vec![square("floor", Vector3::zeros(), 0.0, 1.0)]);
    let mut feet = vec![
        on(&robot, "left_foot", 0, 0.6),
        on(&robot, "right_foot", 0, 0.6),
    ];
    feet[1].loaded = false;
    let outcome = solve(&robot, &world, feet, &Config::default());
    let posture = outcome.posture().expect("it can stand on one foot");
    assert!(posture.contacts[1].forces_W.iter().all(|f| f.norm() == 0.0));
    let left = &posture.contacts[0].X_WC;
    let com = left.inverse_transform_point(&Point3::from(posture.com_W));
    // The left sole is 0.131 m wide: 30 mm inside leaves ±35.5 mm.
    assert!(
        com.y.abs() < 0.0356 && com.x.abs() < 0.0851,
        "CoM at {com} in the left sole"
    );
}

#[test]
fn the_base_goal_is_kept_or_named() {
    let robot = humanoid();
    let world = environment(vec![square("floor", Vector3::zeros(), 0.0, 1.0)]);
    let q = standing(&robot);
    let goal = |x: f64| BaseGoal {
        position_m: [Some(x), None, None],
        tolerance_m: 0.01,
        ..BaseGoal::default()
    };
    let kinematics = Kinematics::new(&robot, &q);
    let fixed = |patch: &str| {
        let index = robot.patch_index(patch).unwrap();
        Contact {
            patch: index,
            place: Place::Fixed {
                X_WC: kinematics.X_WC(&robot.patches[index]),
                yaw_free: false,
                surface: Some(0),
            },
            loaded: true,
            friction: 0.6,
        }
    };
    for (x, possible) in [(0.03, true), (0.6, false)] {
        let problem = Problem {
            robot: &robot,
            environment: &world,
            contacts: vec![fixed("left_foot"), fixed("right_foot")],
            base_goal: Some(goal(x)),
            reference: &q,
            guess: &q,
        };
        let outcome = posture::solve(&problem, &Config::default()).unwrap();
        assert_eq!(outcome.posture().is_some(), possible, "{x}: {outcome:?}");
        if let Some(posture) = outcome.posture() {
            assert!((posture.q.p_WB.x - x).abs() < 0.0101);
        }
    }
}

/// The groups of the conflict, for two feet on squares at the given heights.
fn conflict(right: Vector3<f64>, friction: f64, tilt_rad: f64) -> posture::Explanation {
    let robot = humanoid();
    let q = standing(&robot);
    let sole = |name: &str| {
        let patch = robot.patch(name).unwrap();
        Kinematics::new(&robot, &q).X_WC(patch).translation.vector
    };
    let environment = environment(vec![
        square("s0", sole("left_foot"), tilt_rad, 0.2),
        square("s1", sole("right_foot") + right, tilt_rad, 0.2),
    ]);
    let contacts = vec![
        on(&robot, "left_foot", 0, friction),
        on(&robot, "right_foot", 1, friction),
    ];
    let problem = Problem {
        robot: &robot,
        environment: &environment,
        contacts,
        base_goal: None,
        reference: &q,
        guess: &q,
    };
    posture::explain(&problem, &Config::default())
        .unwrap()
        .unwrap()
}

#[test]
fn a_step_too_high_is_explained_by_its_place_and_by_how_much_it_is_too_high() {
    let found = conflict(Vector3::new(0.1, 0.0, 0.9), 0.6, 0.0);
    assert!(
        found.conflict.contains(&posture::Group::Place(1)),
        "{}",
        found.words
    );
    assert!(
        !found.conflict.contains(&posture::Group::Friction),
        "{}",
        found.words
    );
    let lower = found
        .relaxations
        .iter()
        .find(|r| r.group == posture::Group::Place(1))
        .unwrap();
    assert!(lower.amount > 0.02 && lower.amount < 0.6, "{}", found.words);
}

#[test]
fn a_slippery_slope_is_explained_by_the_friction_that_it_would_take() {
    let found = conflict(Vector3::zeros(), 0.3, 0.4);
    assert!(
        found.conflict.contains(&posture::Group::Friction),
        "{}",
        found.words
    );
    assert!(
        found.conflict.contains(&posture::Group::Equilibrium),
        "{}",
        found.words
    );
    let needed = found
        .relaxations
        .iter()
        .find(|r| r.group == posture::Group::Friction)
        .unwrap();
    // Down a slope the pyramid of 0.8 μ gives 0.8 μ/√2 along its axes.
    let least = 0.4f64.tan() * std::f64::consts::SQRT_2 / 0.8;
    assert!(
        needed.amount > 0.98 * least && needed.amount < 1.2 * least,
        "{}",
        found.words
    );
}
