//! The drawn posture problems are what their families say.

use nalgebra::{Isometry3, Matrix3, Point3, Vector2, Vector3};
use robot_model::{ContactPatch, Kinematics, Robot};
use scenes::contact_sets::{
    ContactRecord, Expected, FORMAT, Family, Margins, ProblemRecord, ProblemSet, generate,
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
    let patch = contact.patch.as_deref();
    patch.is_some_and(|p| p.ends_with("foot"))
}

/// Those of the posture generator by default.
const MARGINS: Margins = Margins {
    friction_use: 0.8,
    torque_use: 0.8,
    joint_margin_rad: 0.03,
    self_clearance_m: 0.005,
    clearance_m: 0.02,
    com_margin_m: 0.04,
};

/// Problems of a family.
fn draw(robot: &Robot, family: Family, count: usize, seed: u64) -> Vec<ProblemRecord> {
    let set = generate(robot, &[family], &MARGINS, count, seed);
    set.expect("problems").problems
}

fn patch<'a>(robot: &'a Robot, contact: &ContactRecord) -> &'a ContactPatch {
    let name = contact.patch.as_deref().expect("a name");
    robot.patch(name).expect("a patch")
}

/// Angles of the perturbed families differ from their ranges by up to 0.05 rad.
const TURNED_DEG: f64 = 2.9;

#[test]
fn a_problem_depends_on_seed_and_number_alone() {
    let robot = hrp2();
    for family in Family::ALL {
        let (few, more) = (draw(&robot, family, 2, 7), draw(&robot, family, 4, 7));
        assert_eq!(few[..], more[..2], "{}", family.name());
        assert_ne!(few[0], draw(&robot, family, 2, 8)[0]);
        assert_ne!(more[0].mu, more[1].mu);
    }
}

#[test]
fn files_are_read_back_as_they_were() {
    let set = generate(&hrp2(), &Family::ALL, &MARGINS, 14, 3).expect("problems");
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
        for problem in draw(&robot, family, 20, 1) {
            assert_eq!(problem.expected, Some(Expected::Solvable));
            let witness = problem.witness.as_deref().expect("a witness");
            let q = robot.configuration(witness).expect("a configuration");
            // Inside the limits by a planner's margin.
            let kept = robot.check_joints(q.joints.as_slice(), -0.03);
            kept.expect("inside the limits");
            let kinematics = Kinematics::new(&robot, &q);
            for contact in &problem.contacts {
                let patch = patch(&robot, contact);
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
fn inside(problem: &ProblemRecord, id: &str, X_WC: &Isometry3<f64>, patch: &ContactPatch) {
    let surface = problem.surfaces.iter().find(|s| s.id == id);
    let surface = surface.expect("it is there");
    let R = rotation(&surface.R);
    for v in &patch.polygon {
        let p_W = (X_WC * Point3::new(v.x, v.y, 0.0)).coords;
        let p = R.transpose() * (p_W - Vector3::from(surface.p));
        assert!(p.z.abs() < 1e-12, "{} above the plane", p.z);
        let n = surface.polygon_m.len();
        for i in 0..n {
            let [a, b] = [surface.polygon_m[i], surface.polygon_m[(i + 1) % n]];
            let e = Vector2::new(b[0] - a[0], b[1] - a[1]);
            let left = e.perp(&Vector2::new(p.x - a[0], p.y - a[1])) / e.norm();
            assert!(left > 0.009, "{left} m inside edge {i} of {id}");
        }
    }
}

#[test]
fn families_are_what_they_say() {
    let robot = hrp2();
    let draw = |family| draw(&robot, family, 20, 5);
    let feet = |p: &ProblemRecord| -> Vec<ContactRecord> {
        let feet = p.contacts.iter().filter(|c| is_foot(c));
        feet.cloned().collect()
    };
    for problem in draw(Family::Steep) {
        assert_eq!((feet(&problem).len(), problem.contacts.len()), (2, 3));
        for tilt in feet(&problem).iter().map(tilt_deg) {
            let range = 20.0 - TURNED_DEG..=40.0 + TURNED_DEG;
            assert!(range.contains(&tilt), "{tilt}");
        }
    }
    for problem in draw(Family::OneFoot) {
        assert_eq!((feet(&problem).len(), problem.contacts.len()), (1, 3));
    }
    for problem in draw(Family::Chimney) {
        // The walls under the feet look at each other.
        let normal = |c: &ContactRecord| rotation(&c.R.expect("fixed")).column(2).xy();
        let [a, b] = [0, 1].map(|i| normal(&feet(&problem)[i]));
        assert!(a.dot(&b) < 0.0, "{a} {b}");
    }
    for problem in draw(Family::Spread) {
        let place = |c: &ContactRecord| Vector3::from(c.p.expect("fixed"));
        let [a, b] = [0, 1].map(|i| place(&feet(&problem)[i]));
        let (apart, mu) = ((a - b).norm(), problem.mu);
        assert!(apart > 0.2 && mu <= 0.3, "{apart} m, friction {mu}");
    }
    let reasons = draw(Family::Infeasible)
        .into_iter()
        .filter_map(|p| p.reason);
    let reasons: Vec<String> = reasons.take(3).collect();
    assert_eq!(reasons, ["out_of_reach", "no_equilibrium", "friction"]);
}

#[test]
fn robots_without_the_limbs_are_told() {
    let mut robot = hrp2();
    robot.patches.retain(|p| !p.has_role("hand"));
    let error = generate(&robot, &[Family::OneFoot], &MARGINS, 1, 0).expect_err("no hands");
    assert!(error.to_string().contains("one-foot"), "{error}");
    // The other hard families go on without hands.
    let set = generate(&robot, &Family::HARD, &MARGINS, 6, 0).expect("problems");
    assert_eq!(set.family, "steep chimney spread");
    robot.patches.clear();
    assert!(generate(&robot, &Family::ALL, &MARGINS, 1, 0).is_err());
}

#[test]
fn ball_feet_get_surfaces_to_stand_on() {
    let robot = shipped("hexapod");
    for family in Family::ALL.into_iter().filter(|f| f.suits(&robot)) {
        for problem in draw(&robot, family, 6, 2) {
            assert!(problem.contacts.len() >= 3, "{}", problem.id);
            let Some(witness) = &problem.witness else {
                continue;
            };
            let q = robot.configuration(witness).expect("a configuration");
            let kinematics = Kinematics::new(&robot, &q);
            for contact in problem.contacts.iter().filter(|c| c.p.is_some()) {
                let patch = patch(&robot, contact);
                let n = rotation(&contact.R.expect("fixed")).column(2).into_owned();
                let radius = patch.point_radius_m().expect("a ball");
                let touched = kinematics.X_WC(patch).translation.vector - radius * n;
                let apart = (touched - Vector3::from(contact.p.expect("fixed"))).norm();
                assert!(apart < 1e-12, "{apart}");
            }
        }
    }
}
