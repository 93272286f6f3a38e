//! Proofs against what is solved, and what nothing else proves.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use robot_model::Robot;
use scenes::contact_sets::{self, Family, Margins, ProblemRecord};

use super::{Answer, after_all, infeasible};
use crate::finite_difference::humanoid;
use crate::iterate::{Context, Relaxed};
use crate::{Config, Constraint, Contact, Environment, Outcome, Problem, solve, stand};

/// Problems a family.
const COUNT: usize = 10;

fn drawn(robot: &Robot, family: Family, count: usize, seed: u64) -> Vec<ProblemRecord> {
    let config = Config::default();
    let margins = Margins {
        friction_use: config.friction_use,
        torque_use: config.torque_use,
        joint_margin_rad: config.joint_margin_rad,
        self_clearance_m: config.self_clearance_m,
        clearance_m: config.clearance_m,
        com_margin_m: config.com_margin_m,
    };
    let set = contact_sets::generate(robot, &[family], &margins, count, seed);
    set.unwrap().problems
}

fn contacts(robot: &Robot, record: &ProblemRecord) -> Vec<Contact> {
    let contact = |c: &contact_sets::ContactRecord| {
        let rows = c.R.unwrap();
        let R = Rotation3::from_matrix(&Matrix3::from_fn(|i, j| rows[i][j]));
        let R = UnitQuaternion::from_rotation_matrix(&R);
        let at = Isometry3::from_parts(Translation3::from(c.p.unwrap()), R);
        let patch = robot.patch_id(c.patch.as_ref().unwrap()).unwrap();
        Contact {
            friction: record.mu,
            ..Contact::at(robot, patch, at)
        }
    };
    record.contacts.iter().map(contact).collect()
}

fn with<T>(robot: &Robot, contacts: Vec<Contact>, then: impl Fn(&Problem, &Config) -> T) -> T {
    let guess = stand::over_contacts(robot, &robot.resting(), &contacts);
    let environment = Environment::default();
    let problem = Problem::new(robot, &environment, contacts, &guess);
    let mut config = Config::default();
    config.solver.thorough = true;
    then(&problem, &config)
}

#[test]
fn what_has_a_posture_is_not_refuted() {
    let robot = humanoid();
    let mut solved = 0;
    for family in Family::HARD {
        for record in drawn(&robot, family, COUNT, 11) {
            solved += with(&robot, contacts(&robot, &record), |problem, config| {
                let found = solve(problem, config).unwrap();
                if found.posture().is_none() {
                    return 0;
                }
                let ctx = Context::new(problem, config, Relaxed::default());
                assert_eq!(infeasible(&ctx), None, "{}", record.id);
                if let Some(Answer::Refuted(violation)) = after_all(&ctx) {
                    panic!("{}: {violation:?}", record.id);
                }
                1
            });
        }
    }
    assert!(solved >= 3 * COUNT, "{solved}");
}

#[test]
fn hands_that_reach_their_places_only_out_of_balance_are_a_proof() {
    let robot = humanoid();
    let record = drawn(&robot, Family::OneFoot, 40, 7001).pop().unwrap();
    with(&robot, contacts(&robot, &record), |problem, config| {
        let ctx = Context::new(problem, config, Relaxed::default());
        assert_eq!(infeasible(&ctx), None);
        let outcome = solve(problem, config).unwrap();
        assert!(matches!(outcome, Outcome::Infeasible(_)), "{outcome:?}");
    });
}

#[test]
fn soles_in_each_other_are_a_proof() {
    let robot = humanoid();
    let at = |foot: &str, y: f64| {
        let patch = robot.patch_id(foot).unwrap();
        Contact::at(&robot, patch, Isometry3::translation(0.0, y, 0.0))
    };
    let feet = vec![at("left_foot", 0.03), at("right_foot", -0.03)];
    with(&robot, feet, |problem, config| {
        let outcome = solve(problem, config).unwrap();
        let Outcome::Infeasible(violation) = outcome else {
            panic!("{outcome:?}");
        };
        assert!(matches!(
            violation.constraint,
            Constraint::SelfClearance(..)
        ));
    });
}
