//! The files of hrp2: made by the generator, and physically possible.

#![allow(clippy::unwrap_used)]

#[path = "../examples/make_hrp2/facts.rs"]
mod facts;
#[path = "../examples/make_hrp2/files.rs"]
mod files;
#[path = "../examples/make_hrp2/shapes.rs"]
mod shapes;

use std::collections::BTreeSet;

fn rows() -> Vec<facts::Row> {
    facts::read(include_str!("../robots/hrp2/joints.csv")).unwrap()
}

#[test]
fn files_are_what_the_generator_writes_now() {
    let robot = scenes::builtin_robot("hrp2").unwrap();
    let shipped = [robot.urdf, robot.srdf, robot.contacts];
    for ((name, text), shipped) in files::all(&rows()).iter().zip(shipped) {
        assert!(
            text == shipped,
            "{name} differs from its generator; run make_hrp2"
        );
    }
}

#[test]
fn masses_sum_to_the_quoted_58_kg_and_inertias_are_possible() {
    let urdf = scenes::builtin_robot("hrp2").unwrap().urdf;
    let document = roxmltree::Document::parse(urdf).unwrap();
    let number = |node: roxmltree::Node, name: &str| -> f64 {
        node.attribute(name).unwrap().parse().unwrap()
    };
    let mut total = 0.0;
    for inertial in document
        .descendants()
        .filter(|n| n.has_tag_name("inertial"))
    {
        let child = |tag: &str| inertial.children().find(|c| c.has_tag_name(tag)).unwrap();
        total += number(child("mass"), "value");
        let i = child("inertia");
        let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|name| number(i, name));
        let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|name| number(i, name));
        let matrix = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let moments = matrix.symmetric_eigenvalues();
        let greatest = moments.max();
        assert!(moments.min() > 0.0, "not positive definite: {moments}");
        assert!(
            moments.sum() - 2.0 * greatest > 0.0,
            "triangle inequality: {moments}"
        );
    }
    assert!((total - 58.0).abs() < 1e-6, "{total} kg");
}

#[test]
fn every_named_link_and_joint_exists_and_the_posture_is_within_the_limits() {
    let robot = scenes::builtin_robot("hrp2").unwrap();
    let urdf = roxmltree::Document::parse(robot.urdf).unwrap();
    let srdf = roxmltree::Document::parse(robot.srdf).unwrap();
    let names = |tag: &str| -> BTreeSet<&str> {
        let top = urdf.root_element();
        top.children()
            .filter(|n| n.has_tag_name(tag))
            .filter_map(|n| n.attribute("name"))
            .collect()
    };
    let (links, joints) = (names("link"), names("joint"));
    assert_eq!(rows().len(), 30);
    for pair in srdf
        .descendants()
        .filter(|n| n.has_tag_name("disable_collisions"))
    {
        for side in ["link1", "link2"] {
            assert!(links.contains(pair.attribute(side).unwrap()));
        }
    }
    let contacts: toml::Table = robot.contacts.parse().unwrap();
    for patch in contacts["patch"].as_array().unwrap() {
        assert!(links.contains(patch["link"].as_str().unwrap()));
    }
    for row in rows() {
        assert!(joints.contains(row.joint.as_str()));
        let value = facts::half_sitting_rad(&row.joint);
        assert!(
            row.lower_rad <= value && value <= row.upper_rad,
            "{}",
            row.joint
        );
    }
    assert_eq!(
        srdf.descendants()
            .filter(|n| n.has_attribute("value"))
            .count(),
        30
    );
}
