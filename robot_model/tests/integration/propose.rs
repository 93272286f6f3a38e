//! What is proposed for a robot, against what was written by hand.

use std::path::Path;

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use robot_model::propose::{
    Kinds, LimbKind, Proposed, Reason, Tip, deepest, drawn, excepted, limbs, patches, surfaces,
};
use robot_model::{ContactPatch, Kinematics, Robot, RobotFiles, load};

use crate::support::{robot_data, shared};

/// How far a proposed patch may be from the one written by hand, m, and how their normals may differ.
const OFF_M: f64 = 0.005;
const TURNED_RAD: f64 = 0.01;
/// Where an outline differs by more, the corner written by hand is this far outside the robot's own shape,
/// and the one that was found lies on it to this, m: soles are bevelled, and were drawn as rectangles.
const OUTSIDE_M: f64 = 0.001;
const ON_SHAPE_M: f64 = 0.002;

fn proposed(robot: &Robot) -> Vec<Proposed> {
    let limbs = limbs(robot);
    patches(robot, &limbs, &robot.neutral(), &[], Kinds::default()).0
}

/// How far a point is outside a counter-clockwise polygon, m.
fn outside_m(polygon: &[Point2<f64>], p: &Point2<f64>) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let edges = polygon.iter().zip(next);
    let off = edges.map(|(a, b)| (p - a).perp(&(b - a)) / (b - a).norm());
    off.fold(f64::NEG_INFINITY, f64::max)
}

/// How far outside a body's shapes a point of W surely is, m: along the direction in which that shows most.
fn outside_shapes_m(robot: &Robot, kinematics: &Kinematics, body: usize, p: &Point3<f64>) -> f64 {
    let of = robot.collision.shapes().iter().filter(|s| s.body == body);
    let placed: Vec<_> = of.map(|s| (kinematics.X_WB[body] * s.X_BG, s)).collect();
    let beyond = |d: Vector3<f64>| {
        let support = |(X_WG, s): &(Isometry3<f64>, &robot_model::collision::Shape)| {
            (X_WG * s.geometry.support(&(X_WG.rotation.inverse() * d))).coords
        };
        let off = placed
            .iter()
            .map(|shape| (p.coords - support(shape)).dot(&d));
        off.fold(f64::INFINITY, f64::min)
    };
    // Directions spread over the sphere.
    let directions = (0..4000).map(|k| {
        let z: f64 = 1.0 - (2.0 * f64::from(k) + 1.0) / 4000.0;
        let (s, c) = (f64::from(k) * 2.399_963).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * c, r * s, z)
    });
    directions.map(beyond).fold(f64::NEG_INFINITY, f64::max)
}

/// Asserts that a proposed patch lies in the plane of the other and reaches as far and, of soles, no
/// farther, but where the robot's own shape shows that it does.
fn assert_agree(
    robot: &Robot,
    found: &ContactPatch,
    body: usize,
    X_BC: &Isometry3<f64>,
    polygon: &[Point2<f64>],
) {
    let kinematics = Kinematics::new(robot, &robot.neutral());
    let (X_WF, X_WG) = (
        kinematics.X_WB[found.body] * found.X_BC,
        kinematics.X_WB[body] * X_BC,
    );
    let normal = |X: &Isometry3<f64>| X.rotation * Vector3::z();
    let name = &found.name;
    assert!(
        normal(&X_WF).angle(&normal(&X_WG)) < TURNED_RAD,
        "{name}: {X_WF} {X_WG}"
    );
    let vertices =
        |X: &Isometry3<f64>, p: &[Point2<f64>], other: &Isometry3<f64>| -> Vec<Point3<f64>> {
            let to =
                |v: &Point2<f64>| other.inverse_transform_point(&(X * Point3::new(v.x, v.y, 0.0)));
            p.iter().map(to).collect()
        };
    for v in vertices(&X_WG, polygon, &X_WF) {
        assert!(v.z.abs() < OFF_M, "{name}: off the plane by {}", v.z);
        let off = outside_m(&found.polygon, &v.xy());
        let outside = || outside_shapes_m(robot, &kinematics, found.body, &(X_WF * v));
        assert!(
            off < OFF_M || outside() > OUTSIDE_M,
            "{name}: short of {v} by {off}, {} outside the shapes",
            outside()
        );
    }
    for v in vertices(&X_WF, &found.polygon, &X_WG)
        .iter()
        .filter(|_| found.has_role("foot"))
    {
        let off = outside_m(polygon, &v.xy());
        let outside = || outside_shapes_m(robot, &kinematics, found.body, &(X_WG * v));
        assert!(
            off < OFF_M || outside() < ON_SHAPE_M,
            "{name}: beyond by {off} at {v}, {} outside the shapes",
            outside()
        );
    }
}

fn assert_as_by_hand(robot: &Robot) {
    let found = proposed(robot);
    assert_eq!(found.len(), robot.patches.len());
    for by_hand in &robot.patches {
        let mut patches = found.iter().map(|p| &p.patch);
        let patch = patches.find(|p| p.name == by_hand.name).unwrap();
        assert!(by_hand.has_role(&patch.roles[0]));
        let (body, X_BC) = (by_hand.body, &by_hand.X_BC);
        assert_agree(robot, patch, body, X_BC, &by_hand.polygon);
    }
}

fn by_hand(urdf: &Path, contacts: &Path) -> Robot {
    let mut files = RobotFiles::new(urdf);
    files.contacts = Some(contacts.to_owned());
    load(&files).unwrap()
}

fn scenes() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/robots")
}

#[test]
fn hrp2_has_the_patches_that_were_written_by_hand() {
    let hrp2 = scenes().join("hrp2");
    let robot = by_hand(&hrp2.join("hrp2.urdf"), &hrp2.join("contacts.toml"));
    assert_as_by_hand(&robot);
}

#[test]
fn talos_has_the_patches_that_were_written_by_hand() {
    let Some(data) = robot_data() else { return };
    let urdf = data.join("talos_data/robots/talos_reduced.urdf");
    assert_as_by_hand(&by_hand(&urdf, &scenes().join("talos/contacts.toml")));
}

#[test]
fn jvrc1_has_the_soles_that_its_rsdf_states() {
    let Some(folder) = shared("robots/jvrc1") else {
        return;
    };
    let robot = load(&RobotFiles::new(folder.join("jvrc1.urdf"))).unwrap();
    let found = proposed(&robot);
    for (file, name) in [("L_ANKLE_P_S", "left_foot"), ("R_ANKLE_P_S", "right_foot")] {
        let path = folder.join("rsdf").join(file).with_extension("rsdf");
        let text = std::fs::read_to_string(&path).unwrap();
        let stated = &surfaces(file, &text).unwrap()[0];
        let frame = robot.frame(&stated.link).unwrap();
        let patch = &found.iter().find(|p| p.patch.name == name).unwrap().patch;
        let X_BC = frame.X_BL * stated.X_LC;
        let limbs = limbs(&robot);
        let kinds = Kinds::default();
        let stated_too = std::slice::from_ref(stated);
        let shipped = patches(&robot, &limbs, &robot.neutral(), stated_too, kinds).0;
        let shipped = shipped.iter().find(|p| p.patch.name == name).unwrap();
        assert_eq!(shipped.patch.polygon, stated.polygon);
        assert!((shipped.X_LC.translation.vector - stated.X_LC.translation.vector).norm() < 1e-9);
        assert_agree(&robot, patch, frame.body, &X_BC, &stated.polygon);
    }
}

#[test]
fn hands_are_the_same_however_the_arms_are_held() {
    let robot = load(&RobotFiles::new(scenes().join("hrp2/hrp2.urdf"))).unwrap();
    let neutral = proposed(&robot);
    let limbs = limbs(&robot);
    for number in 1..6 {
        let mut at = robot.neutral();
        let held = drawn(&robot, number);
        for limb in limbs.iter().filter(|l| l.kind == LimbKind::Arm) {
            let joints = limb.bodies.iter().map(|b| b - 1);
            joints.for_each(|j| at.joints[j] = held.joints[j]);
        }
        let found = patches(&robot, &limbs, &at, &[], Kinds::default()).0;
        for (a, b) in neutral.iter().zip(&found) {
            assert_eq!(a.patch.link, b.patch.link);
            assert_eq!(a.patch.polygon, b.patch.polygon);
            assert!((a.X_LC.translation.vector - b.X_LC.translation.vector).norm() < 1e-9);
        }
    }
}

#[test]
fn balls_at_the_ends_of_legs_are_found_as_they_are() {
    for name in ["hexapod", "quadruped"] {
        let folder = scenes().join(name);
        let robot = by_hand(
            &folder.join(format!("{name}.urdf")),
            &folder.join("contacts.toml"),
        );
        // Legs hanging.
        let (limbs, mut at) = (limbs(&robot), robot.neutral());
        for limb in &limbs {
            let hangs = deepest(&robot, limb, &Tip::of(&robot, limb)).0;
            let joints = limb.bodies.iter().map(|b| b - 1);
            joints.for_each(|j| at.joints[j] = hangs.joints[j]);
        }
        let found = patches(&robot, &limbs, &at, &[], Kinds::default()).0;
        assert_eq!(found.len(), robot.patches.len());
        for Proposed { patch, .. } in &found {
            let near = |p: &&ContactPatch| p.body == patch.body;
            let by_hand = robot.patches.iter().find(near).unwrap();
            let off = (by_hand.X_BC.translation.vector - patch.X_BC.translation.vector).norm();
            assert!(off < 1e-4, "{}: {off}", patch.name);
            assert_eq!(patch.kind, by_hand.kind);
        }
    }
}

#[test]
fn pairs_are_excepted_with_a_reason_that_holds() {
    let robot = load(&RobotFiles::new(scenes().join("hrp2/hrp2.urdf"))).unwrap();
    let pairs = excepted(&robot, &robot.neutral());
    let reason = |a: &str, b: &str| {
        let is = |p: &&robot_model::propose::Excepted| p.link_a == a && p.link_b == b;
        pairs.iter().find(is).map(|p| p.reason)
    };
    assert_eq!(reason("LLEG_LINK2", "LLEG_LINK3"), Some(Reason::Adjacent));
    // A hand comes to the other one and to a knee, whatever was drawn.
    assert_eq!(reason("LARM_LINK5", "RARM_LINK5"), None);
    assert_eq!(reason("LARM_LINK5", "LLEG_LINK3"), None);
    // What is said never to meet does not in postures that were not drawn for it.
    let never: Vec<_> = pairs.iter().filter(|p| p.reason == Reason::Never).collect();
    let meeting = (1000..3000).flat_map(|k| robot.colliding_pairs(&drawn(&robot, k)));
    let met = meeting.filter(|m| never.iter().any(|p| m.is_of(&p.link_a, &p.link_b)));
    assert_eq!((never.is_empty(), met.count()), (false, 0));
}

/// Arms whose hands end in fingers, and single arms: what a hand touches with is on its shapes, nothing that is held beyond
/// it stands out of it, and both sides' are about as large.
#[test]
fn hands_with_fingers_and_single_arms_have_a_side_to_touch_with() {
    let Some(data) = robot_data() else { return };
    let named = [
        "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
        "romeo_description/urdf/romeo_small.urdf",
        "b1_description/urdf/b1-z1.urdf",
        "anymal_b_simple_description/robots/anymal-kinova.urdf",
    ];
    for urdf in named.map(|name| data.join(name)) {
        let robot = load(&RobotFiles::new(&urdf)).unwrap();
        let found = proposed(&robot);
        let hands = found.iter().filter(|p| p.patch.has_role("hand"));
        let mut areas = Vec::new();
        for Proposed { patch, held, .. } in hands {
            let mut at = robot.neutral();
            for (joint, value) in held {
                at.joints[robot.joint_index(joint).unwrap()] = *value;
            }
            let kinematics = Kinematics::new(&robot, &at);
            let X_WC = kinematics.X_WC(patch);
            let out = X_WC.rotation * -Vector3::z();
            // 1. It is as far out as anything of the body that bears it, and of its fingers.
            for shape in robot.collision.shapes() {
                if robot.subtree(patch.body).contains(&shape.body) {
                    let X_WG = kinematics.X_WB[shape.body] * shape.X_BG;
                    let p = X_WG * shape.geometry.support(&(X_WG.rotation.inverse() * out));
                    let beyond = (p.coords - X_WC.translation.vector).dot(&out);
                    assert!(
                        beyond < 0.0011,
                        "{}: {} by {beyond}",
                        patch.name,
                        shape.link
                    );
                }
            }
            // 2. Its outline is on the robot.
            for v in &patch.polygon {
                let p = X_WC * Point3::new(v.x, v.y, 0.0);
                let bodies = 0..robot.bodies.len();
                let off = bodies.map(|b| outside_shapes_m(&robot, &kinematics, b, &p));
                let off = off.fold(f64::INFINITY, f64::min);
                assert!(off < ON_SHAPE_M + 5e-4, "{}: {off}", patch.name);
            }
            let n = patch.polygon.len();
            let part = |i: usize| {
                patch.polygon[i]
                    .coords
                    .perp(&patch.polygon[(i + 1) % n].coords)
            };
            areas.push(0.5 * (0..n).map(part).sum::<f64>());
        }
        let urdf = urdf.display();
        assert!(!areas.is_empty(), "{urdf}: no hands");
        let least = areas.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(least > 5e-4, "{urdf}: {areas:?}");
        assert!(areas.iter().all(|a| *a < 2.0 * least), "{urdf}: {areas:?}");
    }
}

/// A wheel stands on the line of its rim that is below, not on a ball that is 22 mm off it.
#[test]
fn wheels_stand_on_their_rims() {
    let Some(data) = robot_data() else { return };
    let urdf = data.join("centauro_description/urdf/centauro.urdf");
    let robot = load(&RobotFiles::new(urdf)).unwrap();
    let found = proposed(&robot);
    let feet = found.iter().filter(|p| p.patch.has_role("foot"));
    let mut count = 0;
    for Proposed { patch, X_LC, .. } in feet {
        assert!(
            (X_LC.translation.vector.norm() - 0.124).abs() < 1e-6,
            "{}",
            patch.name
        );
        let wide = patch.polygon.iter().map(|v| v.y.abs()).fold(0.0, f64::max);
        assert!((wide - 0.015).abs() < 1e-6, "{}: {wide}", patch.name);
        count += 1;
    }
    assert_eq!(count, 4);
}

/// A joint that the contacts file holds moves nothing; where it does not come to it is refused, and so is one that is not there.
#[test]
fn joints_are_held_where_the_contacts_file_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let hrp2 = scenes().join("hrp2/hrp2.urdf");
    let with = |held: &str| {
        let path = folder.path().join("contacts.toml");
        std::fs::write(&path, format!("[held]\n{held}\n")).unwrap();
        let mut files = RobotFiles::new(&hrp2);
        files.contacts = Some(path);
        load(&files)
    };
    let free = load(&RobotFiles::new(&hrp2)).unwrap();
    let held = with("LARM_JOINT5 = 0.2").unwrap();
    assert_eq!(held.nj() + 1, free.nj());
    let mut at = free.neutral();
    at.joints[free.joint_index("LARM_JOINT5").unwrap()] = 0.2;
    let (a, b) = (
        Kinematics::new(&free, &at),
        Kinematics::new(&held, &held.neutral()),
    );
    let place = |robot: &Robot, k: &Kinematics| {
        let frame = robot.frame("LARM_LINK5").unwrap();
        k.X_WB[frame.body] * frame.X_BL
    };
    let off = place(&free, &a).inverse() * place(&held, &b);
    assert!(off.translation.vector.norm() + off.rotation.angle() < 1e-9);
    assert!((a.com_W - b.com_W).norm() < 1e-9);
    let refused = with("LARM_JOINT5 = 9.0").unwrap_err().to_string();
    assert!(refused.contains("cannot be held at 9"), "{refused}");
    let refused = with("LARM_JOINT55 = 0.0").unwrap_err().to_string();
    assert!(refused.contains("LARM_JOINT5"), "{refused}");
}
