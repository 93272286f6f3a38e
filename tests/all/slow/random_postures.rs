//! Postures of drawn problems, solved by the generator, checked by the verifier.
//!
//! `SCANDENT_RANDOM_POSTURES=10000 cargo test --release --test all random_postures` for more of them.

use nalgebra::{Isometry3, Matrix3, Point2, Rotation3, UnitQuaternion};
use plan::{Change, Plan, RequiredMargins};
use planner::PathStance;
use posture::{Contact, Environment};
use robot_model::Robot;
use scandent::posture_problem::{self, Posed};
use scenes::contact_sets::{Expected, Family, ProblemRecord, generate};
use surfaces::{ConvexPolygon, Face, Region, Terrain};
use verify::{Check, verify_stances};

use crate::support::program;
use crate::support::record::record;

/// Problems of a family where the environment does not say how many in all.
const COUNT: usize = 22;

fn count() -> usize {
    std::env::var("SCANDENT_RANDOM_POSTURES").map_or(COUNT, |text| {
        let all: usize = text.parse().expect("SCANDENT_RANDOM_POSTURES is a number");
        all.div_ceil(Family::ALL.len())
    })
}

/// Half width of the surface under a ball, m.
const UNDER_BALL_M: f64 = 0.05;

/// The surfaces of a problem; under a fixed contact one of the patch's own size, and a small one
/// under a ball, which the solver does not know of.
fn faces(problem: &ProblemRecord, posed: &Posed, robot: &Robot) -> Vec<Face> {
    if !problem.surfaces.is_empty() {
        let environment = &posed.environment;
        return environment
            .faces()
            .map(|f| environment[f].clone())
            .collect();
    }
    problem
        .contacts
        .iter()
        .enumerate()
        .map(|(k, contact)| {
            let R = contact.R.expect("a fixed contact");
            let R = Matrix3::from_fn(|i, j| R[i][j]);
            let R = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R));
            let X_WF = Isometry3::from_parts(contact.p.expect("a fixed contact").into(), R);
            let patch = robot
                .patch(contact.patch.as_deref().expect("a name"))
                .expect("a patch");
            let vertices = match patch.point_radius_m() {
                None => patch.polygon.clone(),
                Some(_) => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                    .map(|(x, y)| Point2::new(UNDER_BALL_M * x, UNDER_BALL_M * y))
                    .to_vec(),
            };
            let polygon = ConvexPolygon::new(vertices).expect("a polygon");
            Face::new(format!("under {k}"), X_WF, Region::from(&polygon))
        })
        .collect()
}

/// A plan of one stance: the posture that was found.
fn plan(
    problem: &ProblemRecord,
    posed: &Posed,
    found: &posture::Posture,
    robot: &Robot,
    config: &posture::Config,
    body_m: f64,
) -> Plan {
    let faces = faces(problem, posed, robot);
    let terrain = Terrain::new(faces, Vec::new()).expect("faces");
    let environment = Environment::new(terrain.clone(), body_m, 0.0).expect("an environment");
    let on = |(k, contact): (usize, &Contact)| {
        let under = || environment.face(&format!("under {k}")).expect("a face");
        contact
            .clone()
            .on(contact.face.unwrap_or_else(under), &environment)
    };
    let path = [PathStance {
        change: Change::Start,
        contacts: posed.contacts.iter().enumerate().map(on).collect(),
        posture: std::sync::Arc::new(found.clone()),
    }];
    let stances = planner::record::stances(robot, &environment, &path);
    Plan {
        required: RequiredMargins::from(config),
        ..record(robot, terrain, body_m, stances)
    }
}

/// What the verifier finds wrong with the posture; bodies behind surfaces that the problem does
/// not have are no fault of it.
fn faults(plan: &Plan, robot: &Robot, problem: &ProblemRecord) -> Vec<Check> {
    let certificate = verify_stances(plan, robot);
    let mut failed = certificate.failed_checks();
    if problem.surfaces.is_empty() {
        failed.retain(|c| {
            !matches!(
                c,
                Check::Clearance | Check::ContactDepth | Check::StatedMargin
            )
        });
    }
    failed
}

#[test]
fn every_posture_that_is_found_passes_the_verifier() {
    check(&program::robot("hrp2"), &Family::ALL);
}

#[test]
fn so_does_every_posture_on_balls() {
    check(&program::robot("hexapod"), &[Family::Easy, Family::Free]);
}

/// Draws, solves and verifies problems of the families.
fn check(robot: &Robot, families: &[Family]) {
    let reference = robot.resting();
    let config = posture::Config::default();
    let margins = posture_problem::margins(&config);
    let (mut wrong, mut missed) = (Vec::new(), Vec::new());
    for &family in families {
        let set = generate(robot, &[family], &margins, count(), 11).expect("problems");
        let (mut solved, n) = (0, set.problems.len());
        for problem in &set.problems {
            let posed =
                posture_problem::pose(problem, robot, &reference, set.body_m).expect("a problem");
            let outcome = posture::solve(&posed.problem(robot), &config).expect("a problem");
            let Some(found) = outcome.posture() else {
                if problem.expected == Some(Expected::Solvable) {
                    missed.push(problem.id.clone());
                }
                continue;
            };
            solved += 1;
            if problem.expected == Some(Expected::Infeasible) {
                wrong.push(format!(
                    "{}: solved, though {:?}",
                    problem.id, problem.reason
                ));
            }
            let plan = plan(problem, &posed, found, robot, &config, set.body_m);
            let failed = faults(&plan, robot, problem);
            if !failed.is_empty() {
                wrong.push(format!("{}: {failed:?}", problem.id));
            }
            // The same posture with a joint next to a contact turned by a degree is wrong, and is
            // found to be.
            let mut bent = plan.clone();
            let body = robot.patches[posed.contacts[0].patch].body;
            bent.stances[0].q[6 + body] += 1f64.to_radians();
            let told = !faults(&bent, robot, problem).is_empty();
            assert!(told, "{}: a turned joint passes", problem.id);
        }
        if !matches!(family, Family::Infeasible) {
            // A generator that solves nothing passes no test: half of every family is solved.
            assert!(2 * solved > n, "{}: {solved} of {n}", family.name());
        }
        println!("{:<10} {solved:>5} of {n} solved", family.name());
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    println!("missed, though there is a witness: {missed:?}");
}
