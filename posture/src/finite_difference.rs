//! The tester that every constraint and the cost run through: derivatives against differences.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, Robot};
use surfaces::{Face, Terrain};

use crate::constraint::{self, Scratch};
use crate::contact::{Contact, Freedom};
use crate::environment::Environment;
use crate::iterate::{Context, Iterate, Relaxed};
use crate::problem::{BaseGoal, Problem};
use crate::rows::{Rows, Tag};
use crate::seeding::Random;
use crate::{Config, Solver, Upright, cost};

/// A robot that ships, read from its files.
pub(crate) fn shipped(name: &str) -> Robot {
    scenes::robot(name).unwrap()
}

/// The humanoid that ships.
pub(crate) fn humanoid() -> Robot {
    shipped("hrp2")
}

/// A square surface of half width `half` at a pose.
pub(crate) fn square(id: &str, X_WF: Isometry3<f64>, half: f64) -> Face {
    Face::rectangle(id, X_WF, [2.0 * half; 2]).unwrap()
}

/// Numbers between −1 and 1.
impl Random {
    pub fn next(&mut self) -> f64 {
        self.between(-1.0, 1.0)
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }
}

/// A configuration with every joint well inside its limits.
fn random_configuration(robot: &Robot, random: &mut Random) -> Configuration {
    let mut q = Configuration::zero(robot.nj());
    q.p_WB = Vector3::new(0.0, 0.0, 0.7) + 0.1 * random.vector();
    q.R_WB = UnitQuaternion::new(0.3 * random.vector());
    for (joint, body) in q.joints.iter_mut().zip(robot.joint_bodies()) {
        let middle = 0.5 * (body.lower + body.upper);
        let half = 0.5 * (body.upper - body.lower);
        *joint = middle + 0.6 * half * random.next();
    }
    q
}

/// Two patches at fixed places, turned by up to `turn_rad` about every axis, the second free to turn (balls roll), and
/// two on surfaces, between them.
fn check(seed: u64, robot: &Robot, names: [&str; 4], turn_rad: f64) {
    let mut random = Random(seed);
    let tilt = |random: &mut Random| UnitQuaternion::new(0.3 * random.vector());
    let environment = {
        let mut at = |p: [f64; 3], id: &str| {
            let pose = Isometry3::from_parts(Translation3::from(p), tilt(&mut random));
            square(id, pose, 0.25)
        };
        let faces = vec![at([0.2, -0.1, 0.1], "a"), at([0.4, 0.4, 0.6], "b")];
        let terrain = Terrain::new(faces, Vec::new()).unwrap();
        Environment::new(terrain, 0.05, 2.0).unwrap()
    };
    let q = random_configuration(robot, &mut random);
    let patch = |name: &str| robot.patch_id(name).unwrap();
    let fixed = |name: &str, freedom: Freedom, random: &mut Random| {
        let pose = Isometry3::from_parts(
            Translation3::from(0.3 * random.vector()),
            UnitQuaternion::new(turn_rad * random.vector()),
        );
        Contact {
            freedom,
            // A ball rolls.
            stood_WB: Some(tilt(random)),
            ..Contact::at(robot, patch(name), pose)
        }
    };
    let on = |name: &str, face: &str, random: &mut Random| {
        let face = environment.face(face).unwrap();
        let mut contact = Contact::anywhere_on(&environment, face, robot, patch(name)).unwrap();
        if let Freedom::Within(area) = &mut contact.freedom {
            area.toward = Some(Point3::from(random.vector()));
            area.yaw_rad = Some(random.next());
        }
        contact
    };
    let mut contacts = vec![
        fixed(names[0], Freedom::Fixed, &mut random),
        on(names[1], "a", &mut random),
        on(names[2], "b", &mut random),
        fixed(names[3], Freedom::Yaw, &mut random),
    ];
    for contact in &mut contacts {
        contact.friction = 0.7;
    }
    let reference = random_configuration(robot, &mut random);
    let problem = Problem {
        robot,
        environment: &environment,
        contacts,
        base_goal: Some(BaseGoal {
            position_m: [Some(0.3), None, Some(0.1)],
            tolerance_m: 0.1,
            yaw_rad: Some(0.4),
            yaw_tolerance_rad: 0.1,
        }),
        joint_goal: None,
        reference: &reference,
        guess: &q,
    };
    let config = Config {
        solver: Solver {
            upright: Some(Upright {
                z_W: reference.R_WB * Vector3::z(),
                tilt_max_rad: 0.1,
            }),
            ..Solver::default()
        },
        ..Config::default()
    };
    let ctx = Context::new(&problem, &config, Relaxed::default());
    let mut it = ctx.start(&q);
    for f in &mut it.force {
        *f += 0.2 * random.next();
    }

    let n = ctx.layout.n;
    let mut scratch = Scratch::default();
    let mut rows = Rows::new(n);
    constraint::all(&ctx, &it, &mut scratch, &mut rows);
    let mut gradient = vec![0.0; n];
    let mut hessian = DMatrix::zeros(n, n);
    cost::quadratic(&ctx, &it, &mut gradient, &mut hessian);

    const H: f64 = 1e-6;
    let mut kinds = std::collections::HashSet::new();
    for (k, &derivative) in gradient.iter().enumerate() {
        let mut moved = |sign: f64| -> (Rows, f64, Iterate) {
            let delta = DVector::from_fn(n, |i, _| if i == k { sign * H } else { 0.0 });
            let mut to = it.clone();
            ctx.step(&it, delta.as_slice(), &mut to);
            let mut rows = Rows::new(n);
            rows.with_jacobian = false;
            constraint::all(&ctx, &to, &mut scratch, &mut rows);
            let cost = cost::value(&ctx, &to);
            (rows, cost, to)
        };
        let (plus, cost_plus, _) = moved(1.0);
        let (minus, cost_minus, _) = moved(-1.0);
        let slope = (cost_plus - cost_minus) / (2.0 * H);
        let off = (slope - derivative).abs();
        assert!(off < 1e-5, "cost, column {k}: {slope} {derivative}");
        assert_eq!(plus.tag, rows.tag, "a row came or went within {H}");
        assert_eq!(minus.tag, rows.tag, "a row came or went within {H}");
        assert_eq!((&plus.lower, &plus.upper), (&rows.lower, &rows.upper));
        for i in 0..rows.len() {
            let slope = (plus.value[i] - minus.value[i]) / (2.0 * H);
            let given = rows.row(i)[k];
            // Distances come from an iteration that ends some 1e-8 m early on curved shapes, which
            // a difference over 2e-6 m turns into 1 %; everything else is in closed form.
            let tolerance = match rows.tag[i] {
                Tag::Clearance(..) | Tag::SelfClearance(..) => 2e-2,
                _ => 1e-6,
            } * (1.0 + slope.abs());
            let (tag, off) = (&rows.tag[i], (slope - given).abs());
            assert!(off < tolerance, "{tag:?}, column {k}: {slope}, not {given}");
            kinds.insert(std::mem::discriminant(tag));
        }
    }
    let kinds = kinds.len();
    assert!(kinds >= 8, "only {kinds} kinds of constraint had rows");
}

#[test]
fn derivatives_agree_with_differences() {
    let robot = humanoid();
    let ends = ["left_foot", "right_foot", "left_hand", "right_hand"];
    for seed in 1..=8 {
        check(seed, &robot, ends, 1.0);
    }
}

#[test]
fn derivatives_agree_with_differences_where_balls_touch() {
    let robot = shipped("hexapod");
    let feet = ["front_left", "middle_right", "rear_left", "front_right"];
    for seed in 1..=8 {
        check(seed, &robot, feet, 1.0);
        // On faces that are not steep the load that they spare moves with them.
        check(seed, &robot, feet, 0.3);
    }
}
