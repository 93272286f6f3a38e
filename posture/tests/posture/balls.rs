//! The hexapod that ships, which stands on balls.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use posture::{BaseGoal, Config, Constraint, Contact, Environment, Freedom, Outcome, Posture};
use robot_model::collision::CollisionModel;
use robot_model::{Configuration, Kinematics, PatchKind, Robot};
use surfaces::{ConvexPolygon, Face};

use crate::world::{self, solve, square, standing, world};

const FEET: [&str; 6] = [
    "front_left",
    "middle_left",
    "rear_left",
    "rear_right",
    "middle_right",
    "front_right",
];
const FRICTION: f64 = 0.6;

/// The robot, standing on a world of these faces.
struct Hexapod {
    robot: Robot,
    q: Configuration,
    world: Environment,
}

impl Hexapod {
    fn new(faces: Vec<Face>) -> Self {
        let (robot, q) = standing("hexapod", "standing", FEET[0]);
        let world = world(faces);
        Self { robot, q, world }
    }

    fn centre(&self, foot: &str) -> Vector3<f64> {
        let patch = self.robot.patch(foot).unwrap();
        let kinematics = Kinematics::new(&self.robot, &self.q);
        kinematics.X_WC(patch).translation.vector
    }

    /// The foot where it stands, on the floor.
    fn fixed(&self, foot: &str) -> Contact {
        let patch = self.robot.patch_id(foot).unwrap();
        let at = Isometry3::from_parts(self.centre(foot).into(), UnitQuaternion::identity());
        let contact =
            Contact::at(&self.robot, patch, at).on(self.world.face("floor").unwrap(), &self.world);
        Contact {
            friction: FRICTION,
            ..contact
        }
    }

    /// The foot anywhere on a face.
    fn on(&self, foot: &str, face: &str) -> Contact {
        let mut contact = world::on(&self.world, &self.robot, foot, face, FRICTION);
        if let Freedom::Within(area) = &mut contact.freedom {
            area.yaw_rad = Some(0.3);
        }
        contact
    }

    /// What comes of a problem with a margin of the centre of mass.
    fn solve(
        &self,
        contacts: &[Contact],
        base_goal: Option<BaseGoal>,
        com_margin_m: f64,
        like: &Configuration,
    ) -> Outcome {
        let config = Config {
            com_margin_m,
            ..Config::default()
        };
        solve(&self.robot, &self.world, contacts, base_goal, like, &config)
    }

    fn stands(&self, contacts: &[Contact]) {
        let outcome = self.solve(contacts, None, Config::default().com_margin_m, &self.q);
        assert!(outcome.posture().is_some(), "{outcome:?}");
    }
}

fn floor() -> Face {
    square("floor", [0.0; 3], 0.0, 2.0)
}

/// The base at y up to a metre to either side of this.
fn aside(y: f64) -> Option<BaseGoal> {
    Some(BaseGoal {
        position_m: [None, Some(y), None],
        tolerance_m: 1.0,
        ..BaseGoal::default()
    })
}

/// Distance of the centre of mass from the nearest edge of what the balls support, m.
fn inside(posture: &Posture) -> f64 {
    let corners = posture.contacts.iter().map(|c| c.vertices_W[0].xy().into());
    let polygon = ConvexPolygon::hull(&corners.collect::<Vec<_>>()).unwrap();
    -polygon.signed_distance(&posture.com_W.xy().into())
}

#[test]
fn it_stands_on_six_balls_and_on_three() {
    let hexapod = Hexapod::new(vec![floor()]);
    for feet in [&[0, 1, 2, 3, 4, 5][..], &[0, 2, 4], &[1, 3, 5]] {
        let names = feet.iter().map(|&i| FEET[i]);
        let fixed = names.clone().map(|foot| hexapod.fixed(foot));
        hexapod.stands(&fixed.collect::<Vec<_>>());
        let free = names.map(|foot| hexapod.on(foot, "floor"));
        hexapod.stands(&free.collect::<Vec<_>>());
    }
}

/// A margin that is asked for moves the centre of mass away from the support polygon's edge.
#[test]
fn on_three_balls_the_centre_of_mass_keeps_its_margin() {
    let hexapod = Hexapod::new(vec![floor()]);
    let contacts = [0, 2, 4].map(|i| hexapod.fixed(FEET[i]));
    // The base at y ≥ 0.2 m, toward the edge between front and rear left, which is at 0.39 m.
    let near = hexapod.solve(&contacts, aside(1.2), 0.0, &hexapod.q);
    let near = near.posture().unwrap_or_else(|| panic!("{near:?}"));
    // The most similar posture with a greater margin.
    let asked = inside(near) + 0.02;
    let with = hexapod.solve(&contacts, None, asked, &near.q);
    let with = inside(with.posture().unwrap_or_else(|| panic!("{with:?}")));
    assert!(with >= asked - 1e-4, "{with} m, {asked} m asked for");
    assert!(with < asked + 0.02, "{with} m, {asked} m asked for");
}

/// How much every ball must bear follows from where the balls come to be, not from where they were.
#[test]
fn the_margin_holds_where_the_balls_come_to_be() {
    let feet = [0, 2, 4].map(|i| FEET[i]);
    // Footholds far nearer to each other than the feet stand.
    let stands = Hexapod::new(Vec::new());
    let footholds = feet.map(|foot| {
        let p = stands.centre(foot);
        square(foot, [0.75 * p.x, 0.75 * p.y, 0.0], 0.0, 0.0102)
    });
    let hexapod = Hexapod::new(footholds.to_vec());
    let contacts = feet.map(|foot| hexapod.on(foot, foot));
    // The base toward the edge between front and rear left: there is not much room for a margin.
    let solved = |margin_m: f64| hexapod.solve(&contacts, aside(1.15), margin_m, &hexapod.q);
    let without = inside(solved(0.0).posture().unwrap());
    // There are 4 mm more than the base's goal asks for: half of them can be had, up to the solver's
    // tolerance, and five times as much cannot.
    let with = inside(solved(without + 0.002).posture().unwrap());
    let asked = without + 0.002;
    assert!(with >= asked - 1e-4, "{with} m, {asked} m asked for");
    let outcome = solved(without + 0.02);
    // The places are free: a search that finds nothing proves nothing.
    assert!(matches!(outcome, Outcome::Undecided { .. }), "{outcome:?}");
}

#[test]
fn feet_on_a_slope_and_a_step_touch_along_their_normals() {
    let slope = square("slope", [1.2, 0.0, 0.1], -0.3, 0.6);
    let step = square("step", [-1.0, 0.0, 0.1], 0.0, 0.6);
    let hexapod = Hexapod::new(vec![floor(), slope, step]);
    let faces = ["slope", "floor", "step", "step", "floor", "slope"];
    let feet = FEET.iter().zip(faces);
    let contacts = feet.map(|(foot, face)| hexapod.on(foot, face));
    hexapod.stands(&contacts.collect::<Vec<_>>());
}

#[test]
fn feet_on_one_side_hold_it_only_where_it_leans_over_them() {
    let hexapod = Hexapod::new(vec![floor()]);
    let margin_m = Config::default().com_margin_m;
    // The other feet, at the same places, touch and bear nothing.
    let feet = (0..6).map(|i| hexapod.fixed(FEET[i]).loaded(i < 3));
    let contacts: Vec<Contact> = feet.collect();
    // Free to lean, it brings its weight just between the three, and no margin inside.
    let refused = hexapod.solve(&contacts, None, margin_m, &hexapod.q);
    assert!(refused.violation().is_some(), "{refused:?}");
    let leaning = hexapod.solve(&contacts, None, 0.0, &hexapod.q);
    let posture = leaning.posture().expect("it leans");
    let edge = posture.contacts[0].vertices_W[0].y;
    assert!(edge > 0.1, "front and rear left stand at y = {edge}");
    assert!(posture.com_W.y > edge - 1e-3, "CoM at {}", posture.com_W);

    let middle = BaseGoal {
        position_m: [Some(0.0), Some(0.0), None],
        tolerance_m: 0.05,
        ..BaseGoal::default()
    };
    let outcome = hexapod.solve(&contacts, Some(middle), margin_m, &hexapod.q);
    let violation = outcome.violation().expect("with its middle kept it falls");
    assert!(violation.amount > 1e-3, "{violation:?}");

    // No place of the centre of mass is held by a foot on a wall.
    let mut wall = hexapod.fixed(FEET[0]);
    wall.X_WC.rotation = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 1.4);
    let outcome = hexapod.solve(&[wall], None, margin_m, &hexapod.q);
    let Outcome::Infeasible(violation) = &outcome else {
        panic!("{outcome:?}");
    };
    let unheld = [Constraint::Balance, Constraint::Equilibrium];
    assert!(unheld.contains(&violation.constraint), "{violation:?}");
}

#[test]
fn a_ball_out_of_reach_is_said_to_be_out_of_reach() {
    let shelf = square("shelf", [0.8, 0.5, 3.0], 0.0, 0.3);
    let hexapod = Hexapod::new(vec![floor(), shelf]);
    let mut contacts = FEET.map(|foot| hexapod.fixed(foot));
    contacts[0] = hexapod.on(FEET[0], "shelf");
    let margin_m = Config::default().com_margin_m;
    let outcome = hexapod.solve(&contacts, None, margin_m, &hexapod.q);
    let violation = outcome.violation().expect("a foot at 3 m is not possible");
    assert!(violation.amount > 0.01, "{violation:?}");
}

/// A robot without shapes, `k` times as large and no heavier.
fn resized(robot: &Robot, k: f64) -> Robot {
    let mut bodies = robot.bodies.clone();
    for body in &mut bodies {
        body.X_PJ.translation.vector *= k;
        body.com_B *= k;
        body.effort *= k;
    }
    let mut other = Robot::new(
        robot.name.clone(),
        bodies,
        Vec::new(),
        CollisionModel::default(),
    )
    .unwrap();
    other.patches.clone_from(&robot.patches);
    for patch in &mut other.patches {
        patch.X_BC.translation.vector *= k;
        if let PatchKind::Point { radius_m } = &mut patch.kind {
            *radius_m *= k;
        }
    }
    other
}

#[test]
fn a_small_robot_steps_as_far_for_its_size_as_a_large_one() {
    let steps = |k: f64| {
        let mut hexapod = Hexapod::new(vec![floor()]);
        hexapod.robot = resized(&hexapod.robot, k);
        hexapod.q.p_WB *= k;
        let ahead = Vector3::x() * 0.2 * k;
        let stood = hexapod.centre("front_left");
        let mut foot = hexapod.on("front_left", "floor").loaded(false);
        if let Freedom::Within(area) = &mut foot.freedom {
            area.toward = Some(Point3::from(stood + ahead));
        }
        let mut contacts: Vec<Contact> = FEET[1..].iter().map(|f| hexapod.fixed(f)).collect();
        contacts.push(foot);
        let outcome = hexapod.solve(&contacts, None, 0.0, &hexapod.q);
        let posture = outcome.posture().unwrap();
        let now = posture.contacts[5].X_WC.translation.vector;
        (now - stood).x / k
    };
    let (large, small) = (steps(1.0), steps(0.2));
    assert!(large > 0.12, "{large} m of 0.2 m");
    assert!((small / large - 1.0).abs() < 0.05, "{small} for {large}");
}

/// Between two triangles of a rough mesh: a face narrower than its ball, beside one that rises.
#[test]
fn a_ball_stands_on_a_narrow_face_beside_ground_that_rises_gently() {
    let stands = |tilt_rad: f64| {
        let (edge_m, half_m) = (0.015, 0.15);
        let foot = Hexapod::new(vec![floor()]).centre(FEET[0]);
        let (sin, cos) = tilt_rad.sin_cos();
        let rises = [foot.x + edge_m + half_m * cos, foot.y, half_m * sin];
        let hexapod = Hexapod::new(vec![
            floor(),
            square("narrow", [foot.x, foot.y, 0.0], 0.0, edge_m),
            square("rises", rises, -tilt_rad, half_m),
        ]);
        let others = FEET[1..].iter().map(|foot| hexapod.fixed(foot));
        let contacts: Vec<Contact> = [hexapod.on(FEET[0], "narrow")]
            .into_iter()
            .chain(others)
            .collect();
        let outcome = hexapod.solve(&contacts, None, 0.0, &hexapod.q);
        outcome.posture().is_some()
    };
    assert!(stands(0.0) && stands(0.25));
    // A thing from which it keeps its clearance.
    assert!(!stands(0.9));
}
