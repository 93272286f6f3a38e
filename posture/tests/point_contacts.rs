//! Contact sets of the hexapod that ships, which stands on balls.
#![allow(clippy::unwrap_used)]

use nalgebra::{Isometry3, Point2, Translation3, UnitQuaternion, Vector3};
use posture::{
    BaseGoal, Config, Constraint, Contact, Environment, Outcome, Place, Posture, Problem,
};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};
use surfaces::{ConvexPolygon, Surface, SurfaceSet};

const FEET: [&str; 6] = [
    "front_left",
    "middle_left",
    "rear_left",
    "rear_right",
    "middle_right",
    "front_right",
];
const FRICTION: f64 = 0.6;

fn hexapod() -> Robot {
    scenes::builtin_robot("hexapod")
        .unwrap()
        .load(&robot_model::Config::default())
        .unwrap()
}

/// Standing with the balls on z = 0.
fn standing(robot: &Robot) -> Configuration {
    let mut q = robot.posture("standing").unwrap();
    let patch = robot.patch(FEET[0]).unwrap();
    let centre = Kinematics::new(robot, &q).X_WC(patch).translation.vector;
    q.p_WB.z -= centre.z - patch.point_radius_m().unwrap();
    q
}

/// A square of half width `half`, turned by `tilt` about y.
fn square(id: &str, p: Vector3<f64>, tilt_rad: f64, half: f64) -> Surface {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt_rad);
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let polygon = ConvexPolygon::new(corners.map(|(x, y)| Point2::new(x, y)).to_vec()).unwrap();
    let pose = Isometry3::from_parts(Translation3::from(p), turn);
    Surface::new(id, pose, polygon)
}

fn environment(surfaces: Vec<Surface>) -> Environment {
    let obstacles = Vec::new();
    Environment::new(
        &SurfaceSet {
            surfaces,
            obstacles,
        },
        0.05,
    )
    .unwrap()
}

fn floor() -> Surface {
    square("floor", Vector3::zeros(), 0.0, 2.0)
}

fn contact(robot: &Robot, foot: &str, place: Place) -> Contact {
    Contact {
        patch: robot.patch_index(foot).unwrap(),
        place,
        loaded: true,
        friction: FRICTION,
    }
}

/// The foot where it stands, on the floor.
fn fixed(robot: &Robot, foot: &str) -> Contact {
    let centre = Kinematics::new(robot, &standing(robot)).X_WC(robot.patch(foot).unwrap());
    let place = Place::Fixed {
        X_WC: Isometry3::from_parts(centre.translation, UnitQuaternion::identity()),
        yaw_free: false,
        surface: Some(0),
    };
    contact(robot, foot, place)
}

fn on(robot: &Robot, foot: &str, surface: usize) -> Contact {
    let place = Place::OnSurface {
        surface,
        toward: None,
        yaw_rad: Some(0.3),
    };
    contact(robot, foot, place)
}

fn solve(robot: &Robot, environment: &Environment, contacts: &[Contact]) -> Outcome {
    let q = standing(robot);
    let problem = Problem {
        robot,
        environment,
        contacts: contacts.to_vec(),
        base_goal: None,
        reference: &q,
        guess: &q,
    };
    posture::solve(&problem, &Config::default()).unwrap()
}

/// Touched points, balance, friction, torques and limits, from the posture alone.
fn assert_sound(robot: &Robot, environment: &Environment, contacts: &[Contact], posture: &Posture) {
    let config = Config::default();
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let mut force = Vector3::new(0.0, 0.0, -weight);
    let mut moment = Vector3::zeros();
    let kinematics = Kinematics::new(robot, &posture.q);
    let mut torques = nalgebra::DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut torques);
    for (state, contact) in posture.contacts.iter().zip(contacts) {
        let patch = &robot.patches[contact.patch];
        let surface = &environment.surfaces[contact.place.surface().unwrap()];
        let normal = surface.normal_W();
        let centre = kinematics.X_WC(patch).translation.vector;
        let touched = centre - patch.point_radius_m().unwrap() * normal;
        let height = normal.dot(&(touched - surface.X_WS.translation.vector));
        assert!(height.abs() < 1e-4, "{}: {height} m", patch.name);
        assert!((state.X_WC.translation.vector - centre).norm() < 1e-9);
        assert!((state.X_WC.rotation * Vector3::z()).angle(&normal) < 1e-6);
        assert_eq!(state.vertices_W, state.force_points_W);
        let [p] = state.force_points_W[..] else {
            panic!("{} force points", state.force_points_W.len());
        };
        assert!((p - touched).norm() < 1e-9, "{p} instead of {touched}");
        let f = state.forces_W[0];
        force += f;
        moment += (p - kinematics.com_W).cross(&f);
        let pressed = f.dot(&normal);
        let slid = (f - pressed * normal).norm();
        assert!(
            pressed >= -1e-6 * weight,
            "a contact pulls with {pressed} N"
        );
        assert!(slid <= FRICTION * config.friction_use * pressed + 1e-5 * weight);
        let mut jacobian = nalgebra::DMatrix::zeros(3, robot.nv());
        kinematics.point_jacobian(robot, patch.body, &p, &mut jacobian);
        torques -= jacobian.transpose() * f;
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
    }
}

fn stands(robot: &Robot, environment: &Environment, contacts: &[Contact]) {
    let outcome = solve(robot, environment, contacts);
    let posture = outcome.posture().unwrap_or_else(|| panic!("{outcome:?}"));
    assert_sound(robot, environment, contacts, posture);
}

#[test]
fn it_stands_on_six_balls_and_on_three() {
    let robot = hexapod();
    let world = environment(vec![floor()]);
    for feet in [&[0, 1, 2, 3, 4, 5][..], &[0, 2, 4], &[1, 3, 5]] {
        let contacts = |make: &dyn Fn(&str) -> Contact| -> Vec<Contact> {
            feet.iter().map(|&i| make(FEET[i])).collect()
        };
        stands(&robot, &world, &contacts(&|foot| fixed(&robot, foot)));
        stands(&robot, &world, &contacts(&|foot| on(&robot, foot, 0)));
    }
}

/// Distance of the centre of mass from the nearest edge of what the balls support, m.
fn inside(posture: &Posture) -> f64 {
    let corners = posture.contacts.iter().map(|c| c.vertices_W[0].xy().into());
    let polygon = ConvexPolygon::hull(&corners.collect::<Vec<_>>()).unwrap();
    -polygon.signed_distance(&posture.com_W.xy().into())
}

/// A margin that is asked for moves the centre of mass away from the support polygon's edge.
#[test]
fn on_three_balls_the_centre_of_mass_keeps_its_margin() {
    let robot = hexapod();
    let world = environment(vec![floor()]);
    let contacts = [0, 2, 4].map(|i| fixed(&robot, FEET[i]));
    let q = standing(&robot);
    let solved = |com_margin_m: f64, base_goal: Option<BaseGoal>, like: &Configuration| {
        let problem = Problem {
            robot: &robot,
            environment: &world,
            contacts: contacts.to_vec(),
            base_goal,
            reference: like,
            guess: like,
        };
        let config = Config {
            com_margin_m,
            ..Config::default()
        };
        let outcome = posture::solve(&problem, &config).unwrap();
        let posture = outcome.posture().unwrap_or_else(|| panic!("{outcome:?}"));
        assert_sound(&robot, &world, &contacts, posture);
        posture.clone()
    };
    // The base at y ≥ 0.2 m, toward the edge between front and rear left, which is at 0.39 m.
    let aside = BaseGoal {
        position_m: [None, Some(1.2), None],
        tolerance_m: 1.0,
        ..BaseGoal::default()
    };
    let near = solved(0.0, Some(aside), &q);
    // The most similar posture with a greater margin.
    let asked = inside(&near) + 0.02;
    let with = inside(&solved(asked, None, &near.q));
    assert!(with >= asked - 1e-4, "{with} m, {asked} m asked for");
    assert!(with < asked + 0.02, "{with} m, {asked} m asked for");
}

/// How much every ball must bear follows from where the balls come to be, not from where they were.
#[test]
fn the_margin_holds_where_the_balls_come_to_be() {
    let robot = hexapod();
    let q = standing(&robot);
    let kinematics = Kinematics::new(&robot, &q);
    let feet = [0, 2, 4].map(|i| FEET[i]);
    // Footholds far nearer to each other than the feet stand.
    let footholds = feet.map(|foot| {
        let p = kinematics
            .X_WC(robot.patch(foot).unwrap())
            .translation
            .vector;
        square(foot, Vector3::new(0.75 * p.x, 0.75 * p.y, 0.0), 0.0, 0.03)
    });
    let world = environment(footholds.to_vec());
    let contacts: Vec<Contact> = (0..3).map(|i| on(&robot, feet[i], i)).collect();
    // The base toward the edge between front and rear left: there is not much room for a margin.
    let aside = BaseGoal {
        position_m: [None, Some(1.15), None],
        tolerance_m: 1.0,
        ..BaseGoal::default()
    };
    let solved = |com_margin_m: f64| {
        let problem = Problem {
            robot: &robot,
            environment: &world,
            contacts: contacts.clone(),
            base_goal: Some(aside.clone()),
            reference: &q,
            guess: &q,
        };
        let config = Config {
            com_margin_m,
            ..Config::default()
        };
        let outcome = posture::solve(&problem, &config).unwrap();
        if let Some(posture) = outcome.posture() {
            assert_sound(&robot, &world, &contacts, posture);
        }
        outcome
    };
    let without = inside(solved(0.0).posture().unwrap());
    // There are 4 mm more than the base's goal asks for: half of them can be had, up to the solver's
    // tolerance, and five times as much cannot.
    let with = inside(solved(without + 0.002).posture().unwrap());
    assert!(
        with >= without + 0.002 - 1e-4,
        "{with} m, {without} m without"
    );
    let outcome = solved(without + 0.02);
    assert!(matches!(outcome, Outcome::Infeasible(_)), "{outcome:?}");
}

#[test]
fn feet_on_a_slope_and_a_step_touch_along_their_normals() {
    let robot = hexapod();
    let slope = square("slope", Vector3::new(1.2, 0.0, 0.1), -0.3, 0.6);
    let step = square("step", Vector3::new(-1.0, 0.0, 0.1), 0.0, 0.6);
    let world = environment(vec![floor(), slope, step]);
    let surfaces = [1, 0, 2, 2, 0, 1];
    let contacts: Vec<Contact> = FEET
        .iter()
        .zip(surfaces)
        .map(|(foot, surface)| on(&robot, foot, surface))
        .collect();
    stands(&robot, &world, &contacts);
}

#[test]
fn feet_on_one_side_hold_it_only_where_it_leans_over_them() {
    let robot = hexapod();
    let world = environment(vec![floor()]);
    // The other feet, at the same places, touch and bear nothing.
    let contacts: Vec<Contact> = FEET
        .iter()
        .enumerate()
        .map(|(i, foot)| Contact {
            loaded: i < 3,
            ..fixed(&robot, foot)
        })
        .collect();
    // Free to lean, it brings its weight just between the three, and no margin inside.
    let q = standing(&robot);
    let lean = |com_margin_m: f64| {
        let problem = Problem {
            robot: &robot,
            environment: &world,
            contacts: contacts.clone(),
            base_goal: None,
            reference: &q,
            guess: &q,
        };
        let config = Config {
            com_margin_m,
            ..Config::default()
        };
        posture::solve(&problem, &config).unwrap()
    };
    let refused = lean(Config::default().com_margin_m);
    assert!(refused.violation().is_some(), "{refused:?}");
    let leaning = lean(0.0);
    let posture = leaning.posture().expect("it leans");
    assert_sound(&robot, &world, &contacts, posture);
    let edge = posture.contacts[0].vertices_W[0].y;
    assert!(edge > 0.1, "front and rear left stand at y = {edge}");
    assert!(posture.com_W.y > edge - 1e-3, "CoM at {}", posture.com_W);

    let problem = Problem {
        robot: &robot,
        environment: &world,
        contacts,
        base_goal: Some(BaseGoal {
            position_m: [Some(0.0), Some(0.0), None],
            tolerance_m: 0.05,
            ..BaseGoal::default()
        }),
        reference: &q,
        guess: &q,
    };
    let outcome = posture::solve(&problem, &Config::default()).unwrap();
    let violation = outcome.violation().expect("with its middle kept it falls");
    assert!(violation.amount > 1e-3, "{violation:?}");

    // No place of the centre of mass is held by a foot on a wall.
    let mut wall = fixed(&robot, FEET[0]);
    if let Place::Fixed { X_WC, .. } = &mut wall.place {
        X_WC.rotation = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 1.4);
    }
    let outcome = solve(&robot, &world, &[wall]);
    let violation = outcome.violation().expect("it slides down");
    assert!(
        matches!(
            violation.constraint,
            Constraint::Balance | Constraint::Equilibrium
        ),
        "{violation:?}"
    );
}

#[test]
fn a_ball_out_of_reach_is_said_to_be_out_of_reach() {
    let robot = hexapod();
    let shelf = square("shelf", Vector3::new(0.8, 0.5, 3.0), 0.0, 0.3);
    let world = environment(vec![floor(), shelf]);
    let mut contacts: Vec<Contact> = FEET.iter().map(|foot| fixed(&robot, foot)).collect();
    contacts[0] = on(&robot, FEET[0], 1);
    let outcome = solve(&robot, &world, &contacts);
    let violation = outcome.violation().expect("a foot at 3 m is not possible");
    assert!(violation.amount > 0.01, "{violation:?}");
}
