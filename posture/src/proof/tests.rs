//! Proofs against what is solved, and what nothing else proves.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};
use robot_model::Robot;
use scenes::contact_sets::{self, Family, Margins, ProblemRecord};

use plan::{Multipliers, Near, Proof, Refutation};

use super::{Answer, after_all, infeasible, refutation};
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

fn multipliers(written: &mut Refutation) -> &mut Multipliers {
    match &mut written.proof {
        Proof::Multipliers(multipliers) => multipliers,
        Proof::Colliding { .. } => panic!("these are no multipliers"),
    }
}

fn scaled(multipliers: &mut Multipliers, by: f64) {
    let vectors = [&mut multipliers.force, &mut multipliers.moment];
    let places = multipliers.places.iter_mut().chain(vectors).flatten();
    let turns = multipliers.turns.iter_mut().flatten().flatten();
    for x in places.chain(turns).chain(&mut multipliers.torques) {
        *x *= by;
    }
}

/// The proof that a problem has no posture, which holds.
fn proof(robot: &Robot, contacts: Vec<Contact>) -> Refutation {
    with(robot, contacts, |problem, config| {
        let outcome = solve(problem, config).unwrap();
        assert!(matches!(outcome, Outcome::Infeasible(_)), "{outcome:?}");
        let written = refutation(problem, config).unwrap();
        verify::refuted(&written, robot).unwrap();
        written
    })
}

/// Feet side by side, so far from the middle.
fn feet(robot: &Robot, y: f64) -> Vec<Contact> {
    let at = |foot: &str, y: f64| {
        let patch = robot.patch_id(foot).unwrap();
        Contact::at(robot, patch, Isometry3::translation(0.0, y, 0.0))
    };
    vec![at("left_foot", y), at("right_foot", -y)]
}

#[test]
fn balls_in_a_line_keep_no_margin_and_that_is_written_down() {
    let robot = scenes::robot("quadruped").unwrap();
    let ball = |patch: &str, x: f64, y: f64| {
        let radius_m = robot.patches[0].point_radius_m().unwrap();
        let at = Isometry3::translation(x, y, radius_m);
        Contact::at(&robot, robot.patch_id(patch).unwrap(), at)
    };
    let names: Vec<&str> = robot.patches.iter().map(|p| p.name.as_str()).collect();
    let two = vec![ball(names[0], 0.2, 0.2), ball(names[3], -0.2, -0.2)];
    let proof = proof(&robot, two);
    falsified(&robot, &proof, "no margin", |p| p.required.com_m = 0.0);
    falsified(&robot, &proof, "four", |p| {
        let all = [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)];
        let more = all.iter().zip(&names).map(|(at, name)| {
            let mut contact = p.contacts[0].clone();
            contact.patch = (*name).to_owned();
            (contact.X_WC.p[0], contact.X_WC.p[1]) = *at;
            contact
        });
        p.contacts = more.collect();
        let places = vec![[0.0; 3]; 4];
        multipliers(p).places = places;
    });
}

/// A proof of which some part is not as it was.
fn falsified(robot: &Robot, proof: &Refutation, how: &str, change: impl Fn(&mut Refutation)) {
    let mut false_one = proof.clone();
    change(&mut false_one);
    assert!(verify::refuted(&false_one, robot).is_err(), "{how}");
}

#[test]
fn a_proof_by_multipliers_that_is_falsified_does_not_hold() {
    let robot = humanoid();
    let one_foot = drawn(&robot, Family::OneFoot, 40, 7001).pop().unwrap();
    let far = proof(&robot, feet(&robot, 2.0));
    let steep = {
        let mut feet = feet(&robot, 0.1);
        feet.truncate(1);
        feet[0].X_WC.rotation = UnitQuaternion::from_euler_angles(0.9, 0.0, 0.0);
        proof(&robot, feet)
    };
    let cones = proof(&robot, contacts(&robot, &one_foot));
    let standing = with(&robot, feet(&robot, 0.1), |problem, config| {
        refutation(problem, config).unwrap().contacts
    });
    let all: [(&Refutation, &str); 3] = [(&far, "far"), (&steep, "steep"), (&cones, "cones")];
    for (proof, name) in all {
        let wrong = |how: &str, change: &dyn Fn(&mut Refutation)| {
            falsified(&robot, proof, &format!("{name}: {how}"), change);
        };
        wrong("the other way", &|p| scaled(multipliers(p), -1.0));
        wrong("nothing", &|p| scaled(multipliers(p), 0.0));
        wrong("no number", &|p| multipliers(p).force[0] = f64::NAN);
        wrong("infinite", &|p| {
            multipliers(p).turns[3][0][0] = f64::INFINITY
        });
        wrong("one too few", &|p| multipliers(p).turns.truncate(1));
        wrong("no such patch", &|p| p.contacts[0].patch = "tail".into());
        wrong("turned", &|p| multipliers(p).turns[0][0][0] += 1.0);
        wrong("borne by a joint", &|p| multipliers(p).torques.fill(1.0));
        wrong("no margin", &|p| p.required.friction_use = f64::NAN);
        wrong("endless", &|p| p.required.joint_rad = -f64::MAX);
        wrong("less than no torque", &|p| p.required.torque_use = -1.0);
        wrong("elsewhere", &|p| {
            p.contacts
                .iter_mut()
                .for_each(|c| c.freedom = plan::PlaceFreedom::Elsewhere);
        });
        // Places that have a posture.
        wrong("standing", &|p| {
            let count = p.contacts.len();
            p.contacts = standing.iter().cycle().take(count).cloned().collect();
        });
    }
    falsified(&robot, &steep, "rough", |p| p.contacts[0].friction = 3.0);
    falsified(&robot, &steep, "wholly used", |p| {
        p.required.friction_use = 3.0;
    });
    falsified(&robot, &cones, "no form", |p| {
        multipliers(p).turns.fill([[0.0; 3]; 3])
    });
}

#[test]
fn a_proof_of_a_collision_that_is_falsified_does_not_hold() {
    let robot = humanoid();
    let proof = proof(&robot, feet(&robot, 0.03));
    assert!(matches!(proof.proof, Proof::Colliding { .. }));
    let named = |link: &str, other: Near| {
        let link = link.to_owned();
        move |p: &mut Refutation| {
            let (link, other) = (link.clone(), other.clone());
            p.proof = Proof::Colliding { link, other };
        }
    };
    let foot = robot.patches[0].link.clone();
    let body = |z: f64| {
        let corners = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]].map(|[x, y]| [x, y, z]);
        let points_W = [&corners[..], &[[0.0, 0.0, z - 0.1]]].concat();
        let id = "block".to_owned();
        Near::Body { id, points_W }
    };
    // A block in the foot holds, one under the sole may be touched, one overhead is far.
    let mut held = proof.clone();
    named(&foot, body(0.05))(&mut held);
    verify::refuted(&held, &robot).unwrap();
    falsified(&robot, &proof, "the ground", named(&foot, body(0.0)));
    falsified(&robot, &proof, "overhead", named(&foot, body(2.0)));
    falsified(
        &robot,
        &proof,
        "no such link",
        named("tail", Near::Link(foot.clone())),
    );
    falsified(
        &robot,
        &proof,
        "itself",
        named(&foot, Near::Link(foot.clone())),
    );
    falsified(&robot, &proof, "apart", |p| p.contacts[0].X_WC.p[1] += 0.2);
    falsified(&robot, &proof, "turning", |p| {
        p.contacts[0].freedom = plan::PlaceFreedom::Yaw
    });
    falsified(&robot, &proof, "near enough", |p| {
        p.required.self_clearance_m = -1.0
    });
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
                // Nor whatever multiplies its constraints.
                let mut written = refutation(problem, config).unwrap();
                for scale in [1.0, -1.0, 1e5] {
                    scaled(multipliers(&mut written), scale);
                    verify::refuted(&written, &robot).unwrap_err();
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
fn what_lacks_a_hair_more_than_rounding_is_a_proof() {
    let robot = humanoid();
    // What is left is .2 and .1 mm in the program, .5 and .3 mm in the proof as it is recomputed.
    for (family, seed, index) in [(Family::Chimney, 8275, 28), (Family::Chimney, 8282, 11)] {
        let record = drawn(&robot, family, index + 1, seed).remove(index);
        proof(&robot, contacts(&robot, &record));
    }
}

#[test]
fn soles_in_each_other_are_a_proof() {
    let robot = humanoid();
    with(&robot, feet(&robot, 0.03), |problem, config| {
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

#[test]
fn where_attempts_came_near_a_posture_is_found() {
    let robot = humanoid();
    for (seed, index) in [(7802, 21), (7805, 34)] {
        let record = drawn(&robot, Family::OneFoot, index + 1, seed).remove(index);
        with(&robot, contacts(&robot, &record), |problem, config| {
            let outcome = solve(problem, config).unwrap();
            assert!(outcome.posture().is_some(), "{seed} {index}: {outcome:?}");
        });
    }
}
