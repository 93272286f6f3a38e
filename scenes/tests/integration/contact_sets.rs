//! The drawn posture problems are what their families say.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};
use robot_model::{Kinematics, Robot};
use scenes::contact_sets::{
    ContactRecord, Expected, FORMAT, Family, ProblemRecord, ProblemSet, generate,
};

use crate::robots::shipped;

fn hrp2() -> Robot {
    shipped("hrp2")
}

fn rotation(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn tilt_deg(contact: &ContactRecord) -> f64 {
    let R = rotation(&contact.R.expect("a fixed contact"));
    R.column(2).angle(&Vector3::z()).to_degrees()
}

fn is_foot(contact: &ContactRecord) -> bool {
    contact
        .patch
        .as_deref()
        .is_some_and(|p| p.ends_with("foot"))
}

/// Angles of the perturbed families differ from their ranges by up to 0.05 rad.
const TURNED_DEG: f64 = 2.9;

#[test]
fn a_problem_depends_on_seed_and_number_alone() {
    let robot = hrp2();
    for family in Family::ALL {
        let few = generate(&robot, &[family], 2, 7).expect("problems");
        let more = generate(&robot, &[family], 4, 7).expect("problems");
        assert_eq!(few.problems[..], more.problems[..2], "{}", family.name());
        let other = generate(&robot, &[family], 2, 8).expect("problems");
        assert_ne!(few.problems[0], other.problems[0]);
        assert_ne!(more.problems[0].mu, more.problems[1].mu);
    }
}

#[test]
fn files_are_read_back_as_they_were() {
    let set = generate(&hrp2(), &Family::ALL, 14, 3).expect("problems");
    assert_eq!(set.format, FORMAT);
    let text = serde_json::to_string(&set).expect("JSON");
    let read: ProblemSet = serde_json::from_str(&text).expect("what was written");
    assert_eq!(read, set);
    // A slip of the pen is refused.
    let text = text.replacen("\"mu\"", "\"mus\"", 1);
    let error = serde_json::from_str::<ProblemSet>(&text).expect_err("an unknown field");
    assert!(error.to_string().contains("mus"), "{error}");
}

#[test]
fn witnesses_are_where_the_contacts_are() {
    let robot = hrp2();
    for family in [Family::Easy, Family::Free] {
        for problem in generate(&robot, &[family], 20, 1)
            .expect("problems")
            .problems
        {
            assert_eq!(problem.expected, Some(Expected::Solvable));
            let q = robot
                .configuration(problem.witness.as_deref().expect("a witness"))
                .expect("a configuration");
            robot
                .check_joints(q.joints.as_slice(), -0.03)
                .expect("inside the limits by a planner's margin");
            let kinematics = Kinematics::new(&robot, &q);
            for contact in &problem.contacts {
                let patch = robot
                    .patch(contact.patch.as_deref().expect("a name"))
                    .expect("a patch");
                let X_WC = kinematics.X_WC(patch);
                let z_C = X_WC.rotation * Vector3::z();
                assert!(z_C.angle(&Vector3::z()).to_degrees() <= 20.0 + 1e-9);
                match (&contact.p, &contact.surface) {
                    (Some(p), None) => {
                        let apart = (X_WC.translation.vector - Vector3::from(*p)).norm();
                        assert!(apart < 1e-12, "{apart}");
                    }
                    (None, Some(id)) => inside(&problem, id, &X_WC, patch),
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

/// The patch lies in the surface's plane and in its polygon.
fn inside(
    problem: &ProblemRecord,
    id: &str,
    X_WC: &nalgebra::Isometry3<f64>,
    patch: &robot_model::ContactPatch,
) {
    let surface = problem
        .surfaces
        .iter()
        .find(|s| s.id == id)
        .expect("it is there");
    let R = rotation(&surface.R);
    for v in &patch.polygon {
        let p_W = (X_WC * nalgebra::Point3::new(v.x, v.y, 0.0)).coords;
        let p = R.transpose() * (p_W - Vector3::from(surface.p));
        assert!(p.z.abs() < 1e-12, "{} above the plane", p.z);
        let n = surface.polygon_m.len();
        for i in 0..n {
            let [a, b] = [surface.polygon_m[i], surface.polygon_m[(i + 1) % n]];
            let e = nalgebra::Vector2::new(b[0] - a[0], b[1] - a[1]);
            let left = e.perp(&nalgebra::Vector2::new(p.x - a[0], p.y - a[1])) / e.norm();
            assert!(left > 0.009, "{left} m inside edge {i} of {id}");
        }
    }
}

#[test]
fn families_are_what_they_say() {
    let robot = hrp2();
    let draw = |family| {
        generate(&robot, &[family], 20, 5)
            .expect("problems")
            .problems
    };
    let feet = |p: &ProblemRecord| p.contacts.iter().filter(|c| is_foot(c)).count();
    for problem in draw(Family::Steep) {
        assert_eq!((feet(&problem), problem.contacts.len()), (2, 3));
        for foot in problem.contacts.iter().filter(|c| is_foot(c)) {
            let tilt = tilt_deg(foot);
            assert!(
                (20.0 - TURNED_DEG..=40.0 + TURNED_DEG).contains(&tilt),
                "{tilt}"
            );
        }
    }
    for problem in draw(Family::OneFoot) {
        assert_eq!((feet(&problem), problem.contacts.len()), (1, 3));
    }
    for problem in draw(Family::Chimney) {
        let normals: Vec<Vector3<f64>> = problem
            .contacts
            .iter()
            .filter(|c| is_foot(c))
            .map(|c| rotation(&c.R.expect("fixed")).column(2).into_owned())
            .collect();
        // The walls under the feet look at each other.
        assert!(normals[0].xy().dot(&normals[1].xy()) < 0.0, "{normals:?}");
    }
    for problem in draw(Family::Spread) {
        let p: Vec<Vector3<f64>> = problem
            .contacts
            .iter()
            .filter(|c| is_foot(c))
            .map(|c| c.p.expect("fixed").into())
            .collect();
        let apart = (p[0] - p[1]).norm();
        assert!(
            apart > 0.2 && problem.mu <= 0.3,
            "{apart} m, friction {}",
            problem.mu
        );
    }
    let reasons: Vec<String> = draw(Family::Infeasible)
        .into_iter()
        .filter_map(|p| p.reason)
        .take(3)
        .collect();
    assert_eq!(reasons, ["out_of_reach", "no_equilibrium", "friction"]);
}

#[test]
fn robots_without_the_limbs_are_told() {
    let mut robot = hrp2();
    robot.patches.retain(|p| !p.has_role("hand"));
    let error = generate(&robot, &[Family::OneFoot], 1, 0).expect_err("no hands");
    assert!(error.to_string().contains("one-foot"), "{error}");
    // The other hard families go on without hands.
    let set = generate(&robot, &Family::HARD, 6, 0).expect("problems");
    assert_eq!(set.family, "steep chimney spread");
    robot.patches.clear();
    assert!(generate(&robot, &Family::ALL, 1, 0).is_err());
}

#[test]
fn ball_feet_get_surfaces_to_stand_on() {
    let robot = shipped("hexapod");
    for family in Family::ALL.into_iter().filter(|f| f.suits(&robot)) {
        for problem in generate(&robot, &[family], 6, 2)
            .expect("problems")
            .problems
        {
            assert!(problem.contacts.len() >= 3, "{}", problem.id);
            let Some(witness) = &problem.witness else {
                continue;
            };
            let q = robot.configuration(witness).expect("a configuration");
            let kinematics = Kinematics::new(&robot, &q);
            for contact in problem.contacts.iter().filter(|c| c.p.is_some()) {
                let patch = robot
                    .patch(contact.patch.as_deref().expect("a name"))
                    .expect("a patch");
                let n = rotation(&contact.R.expect("fixed")).column(2).into_owned();
                let radius = patch.point_radius_m().expect("a ball");
                let touched = kinematics.X_WC(patch).translation.vector - radius * n;
                let apart = (touched - Vector3::from(contact.p.expect("fixed"))).norm();
                assert!(apart < 1e-12, "{apart}");
            }
        }
    }
}
