//! What is wrong with a robot's files is said with file, line or name, and cause.
#![allow(clippy::unwrap_used)] // A failure's place is all that a test need say.

mod support;

use robot_model::load::no_meshes;
use robot_model::{Config, Error, PatchKind, Robot, RobotFiles, load, load_from_strings};

fn tree() -> String {
    std::fs::read_to_string(support::golden("test_tree.urdf")).unwrap()
}

fn read(urdf: &str, srdf: Option<&str>, contacts: Option<&str>) -> Result<Robot, Error> {
    load_from_strings(urdf, srdf, contacts, "test", &no_meshes, &Config::default())
}

/// What is said of the test tree with each of `edits` made to its text.
fn complaint(edits: &[(&str, &str)]) -> String {
    let mut text = tree();
    for (from, to) in edits {
        assert!(text.contains(from), "the test tree has no {from}");
        text = text.replacen(from, to, 1);
    }
    match read(&text, None, None) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

/// Edits to the test tree, and what the complaint must say.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a [&'a str]);

#[test]
fn urdfs_that_make_no_robot_are_refused() {
    let hip_limit = r#"<limit lower="-1.5" upper="2.0" effort="120" velocity="8"/>"#;
    let tooth_mass = r#"<mass value="0.1"/>"#;
    let cases: &[Case] = &[
        (&[("</robot>", "")], &["test.urdf", "no XML"]),
        (
            &[("<robot ", "<sdf "), ("</robot>", "</sdf>")],
            &["line 3", "<robot> is wanted"],
        ),
        // Trees that are none.
        (
            &[(r#"<parent link="root"/>"#, r#"<parent link="sole"/>"#)],
            &["loop", "trunk"],
        ),
        (
            &[(
                r#"<link name="sole"/>"#,
                r#"<link name="sole"/><link name="stray"/>"#,
            )],
            &["2 root links", "\"root\"", "\"stray\""],
        ),
        (
            &[(r#"<child link="sole"/>"#, r#"<child link="cover"/>"#)],
            &[
                "\"cover\" is the child of two joints",
                "\"shank_to_sole\"",
                "\"shank_to_cover\"",
            ],
        ),
        (
            &[(
                r#"<parent link="shank"/><child link="sole"/>"#,
                r#"<parent link="shanks"/><child link="sole"/>"#,
            )],
            &[
                "parent of joint \"shank_to_sole\"",
                "unknown link \"shanks\"",
                "candidates: shank",
            ],
        ),
        (
            &[(r#"<link name="wheel">"#, r#"<link name="shank">"#)],
            &["two links", "\"shank\""],
        ),
        (
            &[(r#"name="spin""#, r#"name="hip""#)],
            &["two joints", "\"hip\""],
        ),
        // Joints that cannot be.
        (&[(hip_limit, "")], &["joint \"hip\"", "no <limit>"]),
        (
            &[(
                hip_limit,
                r#"<limit lower="2" upper="-2" effort="1" velocity="1"/>"#,
            )],
            &["joint \"hip\"", "lower limit 2 is above its upper limit -2"],
        ),
        (
            &[(
                hip_limit,
                r#"<limit lower="-1" upper="1" effort="-5" velocity="1"/>"#,
            )],
            &["joint \"hip\"", "negative"],
        ),
        (
            &[(r#"<axis xyz="0.3 -1.0 0.2"/>"#, r#"<axis xyz="0 0 0"/>"#)],
            &["joint \"hip\"", "axis is zero"],
        ),
        (
            &[(
                r#"name="hip" type="revolute""#,
                r#"name="hip" type="planar""#,
            )],
            &["line", "\"planar\" are not supported"],
        ),
        (
            &[(
                r#"name="hip" type="revolute""#,
                r#"name="hip" type="floating""#,
            )],
            &["joint \"hip\"", "dummy root"],
        ),
        (
            &[(
                r#"<axis xyz="0.3 -1.0 0.2"/>"#,
                r#"<axis xyz="0.3 -1.0 x 0.2"/>"#,
            )],
            &["not three numbers"],
        ),
        // Masses that cannot be.
        (
            &[(tooth_mass, r#"<mass value="0"/>"#)],
            &["link \"tooth\"", "massless", "\"wobble\""],
        ),
        (
            &[(tooth_mass, r#"<mass value="-0.1"/>"#)],
            &["link \"tooth\"", "-0.1 kg"],
        ),
        (
            &[(tooth_mass, r#"<mass value="NaN"/>"#)],
            &["line", "not a number"],
        ),
        (&[(tooth_mass, "")], &["line", "no <mass>"]),
        (
            &[(r#"ixx="0.00001" ixy="0""#, r#"ixx="-0.1" ixy="0""#)],
            &["link \"tooth\"", "principal moments"],
        ),
        // Shapes that cannot be.
        (
            &[(r#"<box size="0.3 0.2 0.3"/>"#, r#"<box size="0.3 0 0.3"/>"#)],
            &["link \"trunk\"", "box", "not a positive length"],
        ),
        (
            &[(r#"<sphere radius="0.03"/>"#, r#"<sphere radius="-1"/>"#)],
            &["link \"shank\"", "sphere", "radius is -1"],
        ),
        (
            &[(r#"<sphere radius="0.03"/>"#, r#"<torus radius="0.03"/>"#)],
            &["unknown geometry <torus>"],
        ),
        (
            &[(
                r#"<sphere radius="0.03"/>"#,
                r#"<mesh filename="package://a/b.stl"/>"#,
            )],
            &["link \"shank\"", "package://a/b.stl", "no mesh files"],
        ),
    ];
    for (edits, wanted) in cases {
        let complaint = complaint(edits);
        assert!(
            complaint.starts_with("test.urdf: "),
            "{edits:?}: {complaint}"
        );
        for part in *wanted {
            assert!(
                complaint.contains(part),
                "{edits:?}: {complaint} lacks {part}"
            );
        }
    }
}

#[test]
fn lenient_reading_notes_what_it_would_have_refused() {
    let text = tree().replacen(r#"<mass value="0.1"/>"#, r#"<mass value="0"/>"#, 1);
    let lenient = Config {
        lenient: true,
        ..Config::default()
    };
    let robot = load_from_strings(&text, None, None, "test", &no_meshes, &lenient).unwrap();
    assert!(
        robot
            .notes
            .iter()
            .any(|n| n.contains("tooth") && n.contains("massless"))
    );
}

#[test]
fn missing_meshes_are_named_with_the_places_looked_at() {
    let dir = tempfile::tempdir().unwrap();
    let urdf = dir.path().join("urdf/robot.urdf");
    std::fs::create_dir_all(urdf.parent().unwrap()).unwrap();
    let mesh = r#"<mesh filename="package://pack/meshes/toe.stl"/>"#;
    let text = tree().replace(r#"<sphere radius="0.03"/>"#, mesh);
    std::fs::write(&urdf, text).unwrap();
    let complaint = load(&RobotFiles::new(&urdf)).unwrap_err().to_string();
    let looked = dir.path().join("pack/meshes/toe.stl").display().to_string();
    for part in [
        "robot.urdf",
        "link \"shank\"",
        "package://pack/meshes/toe.stl",
        &looked,
    ] {
        assert!(complaint.contains(part), "{complaint} lacks {part}");
    }
    // There, but cut off; then flat.
    std::fs::create_dir_all(dir.path().join("pack/meshes")).unwrap();
    std::fs::write(&looked, [0; 100]).unwrap();
    let ascii = "solid a\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendsolid";
    for (bytes, cause) in [
        ([0xff; 100].as_slice(), "announces"),
        (ascii.as_bytes(), "span no volume"),
    ] {
        std::fs::write(&looked, bytes).unwrap();
        let complaint = load(&RobotFiles::new(&urdf)).unwrap_err().to_string();
        for part in ["link \"shank\"", "toe.stl", cause] {
            assert!(complaint.contains(part), "{complaint} lacks {part}");
        }
    }
    let absent = dir.path().join("none.urdf");
    let complaint = load(&RobotFiles::new(&absent)).unwrap_err().to_string();
    assert!(complaint.contains("none.urdf"), "{complaint}");
}

#[test]
fn srdf_postures_are_read_and_its_slips_are_noted() {
    let srdf = r#"<robot name="test_tree">
      <group_state name="crouch" group="legs">
        <joint name="root_joint" value="0 0 0.5 0 0 0 1"/>
        <joint name="hip" value="0.5"/><joint name="bite" value="0.1"/>
        <joint name="slide" value="0.3"/><joint name="spin" value="1 0"/>
      </group_state>
      <group_state name="crouch" group="rest"><joint name="wobble" value="-0.2"/></group_state>
      <disable_collisions link1="shank" link2="trunk" reason="Never"/>
      <disable_colisions link1="shank" link2="thigh"/>
    </robot>"#;
    let robot = read(&tree(), Some(srdf), None).unwrap();
    let joints: Vec<_> = robot.joint_names().zip(&robot.postures["crouch"]).collect();
    assert_eq!(
        joints,
        [
            ("hip", &0.5),
            ("slide", &0.3),
            ("spin", &0.0),
            ("wobble", &-0.2)
        ]
    );
    let crouch = robot.posture("crouch").unwrap();
    assert_eq!((crouch.p_WB.z, crouch.joints[0]), (0.5, 0.5));
    let notes = robot.notes.join("\n");
    for part in [
        "lacks: bite",
        "outside the limits of slide",
        "\"spin\" has 2 values",
        "<disable_colisions>",
    ] {
        assert!(notes.contains(part), "{notes} lacks {part}");
    }
    let without = read(&tree(), None, None).unwrap();
    // Trunk × (cylinder, sphere) of the shank is all that is not next to each other.
    assert_eq!(
        (
            without.collision.pairs().len(),
            robot.collision.pairs().len()
        ),
        (2, 0)
    );
}

#[test]
fn unknown_srdf_links_are_refused_with_candidates() {
    let srdf = r#"<robot name="r">
      <disable_collisions link1="shenk" link2="trunk" reason="Never"/></robot>"#;
    let complaint = read(&tree(), Some(srdf), None).unwrap_err().to_string();
    for part in [
        "test.srdf: line 2",
        "unknown link \"shenk\"",
        "candidates: shank",
    ] {
        assert!(complaint.contains(part), "{complaint} lacks {part}");
    }
    let lenient = Config {
        lenient: true,
        ..Config::default()
    };
    let robot = load_from_strings(&tree(), Some(srdf), None, "test", &no_meshes, &lenient);
    assert!(
        robot
            .unwrap()
            .notes
            .iter()
            .any(|note| note.contains("shenk"))
    );
}

#[test]
#[allow(non_snake_case)]
fn contacts_are_read_or_refused_by_name() {
    let good = r#"
      [[patch]]
      name = "foot"
      link = "sole"
      position_m = [0.0, 0.0, -0.01]
      rpy_rad = [0.0, 0.0, 1.5707963267948966]
      polygon_m = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]
      roles = ["foot"]
      friction = 0.6
    "#;
    let robot = read(&tree(), None, Some(good)).unwrap();
    let patch = robot.patch("foot").unwrap();
    let sole = robot.frame("sole").unwrap();
    assert_eq!(patch.body, sole.body);
    let X_LC = sole.X_BL.inv_mul(&patch.X_BC);
    assert!((X_LC.translation.z + 0.01).abs() < 1e-15);
    assert!((X_LC.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!(patch.has_role("foot") && !patch.has_role("hand"));
    assert!(
        robot
            .patch("hand")
            .unwrap_err()
            .to_string()
            .contains("candidates: foot")
    );
    let ball = r#"
      [[patch]]
      name = "toe"
      link = "sole"
      kind = "point"
      radius_m = 0.02
      friction = 0.6
    "#;
    let robot = read(&tree(), None, Some(ball)).unwrap();
    let toe = robot.patch("toe").unwrap();
    assert_eq!(toe.kind, PatchKind::Point { radius_m: 0.02 });
    assert_eq!(toe.polygon, [nalgebra::Point2::origin()]);
    let X_WC = toe.touching(&nalgebra::Isometry3::rotation(
        nalgebra::Vector3::x() * std::f64::consts::FRAC_PI_2,
    ));
    let centre = nalgebra::Vector3::new(0.0, -0.02, 0.0);
    assert!((X_WC.translation.vector - centre).norm() < 1e-15);
    for (from, to, wanted) in [
        ("0.02", "-0.02", "radius_m -0.02"),
        ("0.02", "nan", "radius_m NaN"),
        ("radius_m = 0.02", "", "needs radius_m"),
        ("kind = \"point\"", "", "needs polygon_m"),
        ("\"point\"", "\"ball\"", "ball"),
        (
            "radius_m = 0.02",
            "radius_m = 0.02\npolygon_m = [[0.0, 0.0]]",
            "no polygon_m",
        ),
    ] {
        let text = ball.replace(from, to);
        let error = read(&tree(), None, Some(&text)).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
    }
    let corners = "[[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]";
    for (from, to, wanted) in [
        ("link = \"sole\"", "link = \"soul\"", "candidates: sole"),
        (
            corners,
            "[[-0.1, 0.05], [0.1, 0.05], [0.1, -0.05], [-0.1, -0.05]]",
            "clockwise",
        ),
        (corners, "[[-0.1, 0.0], [0.1, 0.0]]", "2 vertices"),
        (corners, "[[0, 0], [1, 0], [1, 0], [0, 1]]", "the same"),
        (corners, "[[0, 0], [1, 0], [1, inf], [0, 1]]", "not finite"),
        ("friction = 0.6", "friction = 0.0", "not positive"),
        ("friction = 0.6", "", "missing field `friction`"),
        ("roles =", "rules =", "unknown field `rules`"),
        ("[[patch]]", "[[patch]", "line 2"),
    ] {
        assert!(good.contains(from), "{from}");
        let complaint = read(&tree(), None, Some(&good.replace(from, to)))
            .unwrap_err()
            .to_string();
        assert!(
            complaint.contains(wanted) && complaint.starts_with("test contacts: "),
            "{complaint}"
        );
    }
    let twice = format!("{good}{good}");
    assert!(
        read(&tree(), None, Some(&twice))
            .unwrap_err()
            .to_string()
            .contains("given twice")
    );
}

#[test]
fn what_was_assumed_is_noted() {
    let notes = support::test_tree().notes.join("\n");
    for part in [
        "\"bite\" at 0.25 (mimics \"hip\")",
        "continuous joints are limited to ±2π rad: spin",
    ] {
        assert!(notes.contains(part), "{notes} lacks {part}");
    }
    let text = tree()
        .replace(r#"effort="120""#, r#"effort="0""#)
        .replace(r#"lower="-0.5" upper="0.5""#, r#"lower="0.1" upper="0.1""#);
    let robot = read(&text, None, None).unwrap();
    let notes = robot.notes.join("\n");
    for part in [
        "no effort limit is stated, none is used: hip",
        "without a range are locked: \"wobble\" at 0.1",
    ] {
        assert!(notes.contains(part), "{notes} lacks {part}");
    }
    assert_eq!((robot.nj(), robot.bodies[1].effort), (3, f64::INFINITY));
}

#[test]
fn unknown_names_list_candidates() {
    let robot = support::test_tree();
    assert_eq!(robot.joint_index("slide").unwrap(), 1);
    let complaint = robot.joint_index("hips").unwrap_err().to_string();
    assert!(
        complaint.contains("unknown joint \"hips\"; candidates: hip"),
        "{complaint}"
    );
    let complaint = robot.posture("standing").unwrap_err().to_string();
    assert!(
        complaint.contains("there is none to choose from"),
        "{complaint}"
    );
}
