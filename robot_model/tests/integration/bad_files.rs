//! What is wrong with a robot's files is said with file, line or name, and cause.

use nalgebra::{Isometry3, Point2, Vector3};
use robot_model::load::no_meshes;
use robot_model::{Config, Error, PatchKind, Robot, RobotFiles, load, load_from_strings};

use crate::support;

const LENIENT: Config = Config {
    lenient: true,
    disable_colliding_at_rest: false,
};

fn tree() -> String {
    std::fs::read_to_string(support::golden("test_tree.urdf")).unwrap()
}

fn read(urdf: &str, srdf: Option<&str>, contacts: Option<&str>) -> Result<Robot, Error> {
    load_from_strings(urdf, srdf, contacts, "test", &no_meshes, &Config::default())
}

fn assert_says(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{said}\nlacks: {part}");
    }
}

/// Reads `good` with each edit of a table made to it; the complaint must come from `file`.
///
/// A line of the table: text of `good` => what takes its place ! parts of the complaint, by commas.
fn assert_refuses(
    good: &str,
    table: &str,
    file: &str,
    read: impl Fn(&str) -> Result<Robot, Error>,
) {
    assert!(read(good).is_ok());
    for case in table.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (edit, parts) = case.split_once(" ! ").unwrap();
        let (from, to) = edit.split_once(" =>").unwrap();
        assert!(good.contains(from), "there is no {from}");
        let refused = read(&good.replacen(from, to.trim(), 1));
        let complaint = refused.expect_err(case).to_string();
        assert!(complaint.starts_with(file), "{case}: {complaint}");
        assert_says(&complaint, &parts.split(", ").collect::<Vec<_>>());
    }
}

#[test]
fn urdfs_that_make_no_robot_are_refused() {
    // Edits: XML; trees that are none; joints, masses and shapes that cannot be.
    let table = r#"
        </robot> => ! no XML
        <link name="sole"/> => <link name="sole"/><link name="stray"/> ! 2 root links, "root", "stray"
        <parent link="root"/> => <parent link="sole"/> ! loop, trunk
        <child link="sole"/> => <child link="cover"/> ! "cover" is the child of two joints, "shank_to_sole", "shank_to_cover"
        <parent link="shank"/><child link="sole"/> => <parent link="shanks"/><child link="sole"/> ! line, parent of joint "shank_to_sole", unknown link "shanks", candidates: shank
        <parent link="shank"/><child link="sole"/> => <child link="sole"/> ! line, <joint> has no <parent>
        <link name="wheel"> => <link name="shank"/><link name="wheel"> ! two links, "shank"
        name="spin" => name="hip" ! line, two joints, "hip"
        name="spin" => ! line, <joint> has no attribute "name"
        <limit lower="-1.5" upper="2.0" effort="120" velocity="8"/> => ! joint "hip", line, no <limit>
        lower="-1.5" upper="2.0" => lower="2" upper="-2" ! joint "hip", lower limit 2 is above its upper limit -2
        effort="120" => effort="-5" ! joint "hip", negative
        effort="120" => effort="much" ! line, effort="much" is not a number
        <axis xyz="0.3 -1.0 0.2"/> => <axis xyz="0 0 0"/> ! joint "hip", axis is zero
        <axis xyz="0.3 -1.0 0.2"/> => <axis xyz="0.3 -1.0 x 0.2"/> ! line, not three numbers
        name="hip" type="revolute" => name="hip" type="planar" ! line, "planar" are not supported
        name="hip" type="revolute" => name="hip" type="floating" ! joint "hip", dummy root
        <mass value="0.1"/> => <mass value="-0.1"/> ! link "tooth", -0.1 kg
        <mass value="0.1"/> => <mass value="NaN"/> ! line, not a number
        <mass value="0.1"/> => ! line, no <mass>
        ixx="0.00001" ixy="0" => ixx="-0.1" ixy="0" ! link "tooth", principal moments
        <box size="0.3 0.2 0.3"/> => <box size="0.3 0 0.3"/> ! link "trunk", box, not a positive length
        <box size="0.3 0.2 0.3"/> => ! line, <geometry> is empty
        <sphere radius="0.03"/> => <sphere radius="-1"/> ! link "shank", sphere, radius is -1
        <sphere radius="0.03"/> => <sphere/> ! line, <sphere> has no attribute "radius"
        <sphere radius="0.03"/> => <torus radius="0.03"/> ! line, unknown geometry <torus>
        <sphere radius="0.03"/> => <mesh filename="package://a/b.stl"/> ! link "shank", package://a/b.stl, no mesh files
    "#;
    assert_refuses(&tree(), table, "test.urdf: ", |urdf| read(urdf, None, None));
    let sdf = tree()
        .replace("<robot ", "<sdf ")
        .replace("</robot>", "</sdf>");
    let complaint = read(&sdf, None, None).unwrap_err().to_string();
    assert_says(&complaint, &["test.urdf: line 3", "<robot> is wanted"]);
}

#[test]
fn what_urdf_rs_would_refuse_or_guess_is_completed_first() {
    let limits = |robot: &Robot| {
        let body = &robot.joint_bodies()[robot.joint_index("hip").unwrap()];
        (body.upper, body.effort, body.velocity)
    };
    let limit = r#"<limit lower="-1.5" upper="2.0" effort="120" velocity="8"/>"#;
    let inf = f64::INFINITY;
    let (effort, velocity) = (r#"effort="120"/>"#, r#"velocity="8"/><limit/>"#);
    for (stated, wanted) in [(effort, (2.0, 120.0, inf)), (velocity, (2.0, inf, 8.0))] {
        let to = &format!(r#"<limit upper="2.0" {stated}"#);
        let robot = read(&tree().replace(limit, to), None, None).unwrap();
        assert_eq!(limits(&robot), wanted);
    }
    // A joint turns without end that states no angle.
    let robot = read(&tree().replace(limit, "<limit/>"), None, None).unwrap();
    assert_eq!(limits(&robot), (std::f64::consts::TAU, inf, inf));
    // Nobody asks for what a link looks like, but where no link has a shape.
    let shown = read(&tree().replace("collision", "visual"), None, None).unwrap();
    let shapes = |robot: &Robot| format!("{:?}", robot.collision.shapes());
    assert_eq!(shapes(&shown), shapes(&read(&tree(), None, None).unwrap()));
    assert_says(
        &shown.notes.join("\n"),
        &["what these show is taken for it: trunk, thigh, shank"],
    );
    let look = r#"<link name="sole"><visual><geometry/><material name="a&quot;&amp;"><texture/></material></visual></link>"#;
    let robot = read(&tree().replace(r#"<link name="sole"/>"#, look), None, None).unwrap();
    assert!(robot.frame("sole").is_ok());
    // Names pass through unchanged, whatever they hold.
    let odd = tree().replace("\"sole\"", "\"a&lt;b &quot;&amp;' /é\"");
    assert!(read(&odd, None, None).unwrap().frame("a<b \"&' /é").is_ok());
}

#[test]
fn what_does_no_harm_is_read_with_a_note() {
    let with = |from: &str, to: &str| read(&tree().replacen(from, to, 1), None, None).unwrap();
    for (from, to, says) in [
        (
            r#"<mass value="0.1"/>"#,
            r#"<mass value="0"/>"#,
            ["tooth", "weigh nothing"],
        ),
        (
            r#"<sphere radius="0.03"/>"#,
            r#"<sphere radius="0"/>"#,
            ["shank", "balls of 1 mm"],
        ),
        (
            r#"ixx="0.00001" ixy="0""#,
            r#"ixx="-0.0000001" ixy="0""#,
            ["tooth", "negative"],
        ),
    ] {
        assert_says(&with(from, to).notes.join("\n"), &says);
    }
}

#[test]
fn meshes_are_turned_upright_where_their_links_masses_are() {
    let dae = r##"<COLLADA><asset><up_axis>Y_UP</up_axis></asset><library_geometries><geometry><mesh>
        <source id="s"><float_array id="a" count="12">0 1 0 .1 0 0 -.1 0 .1 -.1 0 -.1</float_array>
        <technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3</p></triangles>
        </mesh></geometry></library_geometries></COLLADA>"##;
    for (com, top) in [("0 0 .4", [0.0, 0.0, 1.0]), ("0 .4 0", [0.0, 1.0, 0.0])] {
        let urdf = format!(
            r#"<robot name="r"><link name="l"><inertial><origin xyz="{com}"/><mass value="1"/><inertia
            ixx="1" iyy="1" izz="1"/></inertial><collision><geometry><mesh filename="m.dae"/></geometry>
            </collision></link></robot>"#
        );
        let meshes = |_: &str| Ok(dae.as_bytes().to_vec());
        let robot =
            load_from_strings(&urdf, None, None, "test", &meshes, &Config::default()).unwrap();
        let shape = &robot.collision.shapes()[0];
        let d = shape.X_BG.rotation.inverse() * Vector3::from(top);
        let foremost = shape.X_BG * shape.geometry.support(&d);
        assert!(
            (foremost.coords - Vector3::from(top)).norm() < 1e-12,
            "{foremost}"
        );
        let told = robot.notes.iter().any(|n| n.contains("up_axis"));
        assert_eq!(told, top[2] == 1.0, "{:?}", robot.notes);
    }
}

#[test]
fn lenient_reading_notes_what_it_would_have_refused() {
    let text = tree().replacen(r#"ixx="0.00001" ixy="0""#, r#"ixx="-0.1" ixy="0""#, 1);
    let robot = load_from_strings(&text, None, None, "test", &no_meshes, &LENIENT).unwrap();
    assert_says(&robot.notes.join("\n"), &["tooth", "principal moments"]);
}

#[test]
fn missing_meshes_are_named_with_the_places_looked_at() {
    let dir = tempfile::tempdir().unwrap();
    let urdf = dir.path().join("urdf/robot.urdf");
    std::fs::create_dir_all(urdf.parent().unwrap()).unwrap();
    let mesh = r#"<mesh filename="package://pack/meshes/toe.stl"/>"#;
    let text = tree().replace(r#"<sphere radius="0.03"/>"#, mesh);
    std::fs::write(&urdf, text).unwrap();
    let complaint = |urdf| load(&RobotFiles::new(urdf)).unwrap_err().to_string();
    let looked = dir.path().join("pack/meshes/toe.stl").display().to_string();
    let (link, toe) = ("link \"shank\"", "package://pack/meshes/toe.stl");
    assert_says(&complaint(&urdf), &["robot.urdf", link, toe, &looked]);
    // There, but cut off; then flat.
    std::fs::create_dir_all(dir.path().join("pack/meshes")).unwrap();
    std::fs::write(&looked, [0; 100]).unwrap();
    let ascii = "solid a\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendsolid";
    for (bytes, cause) in [
        ([0xff; 100].as_slice(), "announces"),
        (ascii.as_bytes(), "span no volume"),
    ] {
        std::fs::write(&looked, bytes).unwrap();
        assert_says(&complaint(&urdf), &[link, "toe.stl", cause]);
    }
    assert_says(&complaint(&dir.path().join("none.urdf")), &["none.urdf"]);
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
    let names: Vec<_> = robot.joint_names().collect();
    assert_eq!(names, ["hip", "slide", "spin", "wobble"]);
    let posture = &robot.postures["crouch"];
    assert_eq!(posture.joints, [0.5, 0.3, 0.0, -0.2]);
    assert_eq!(posture.is_stated, [true, true, false, true]);
    let crouch = robot.posture("crouch").unwrap();
    assert_eq!((crouch.p_WB.z, crouch.joints[0]), (0.5, 0.5));
    let notes = robot.notes.join("\n");
    assert_says(&notes, &["lacks: bite", "outside the limits of slide"]);
    assert_says(&notes, &["\"spin\" has 2 values", "<disable_colisions>"]);
    // Trunk × (cylinder, sphere) of the shank is all that is not next to each other.
    let without = read(&tree(), None, None).unwrap();
    let pairs = |robot: &Robot| robot.collision.pairs().len();
    assert_eq!((pairs(&without), pairs(&robot)), (2, 0));
}

#[test]
fn unknown_srdf_links_are_refused_with_candidates() {
    let srdf = r#"<robot name="r">
      <disable_collisions link1="shenk" link2="trunk" reason="Never"/></robot>"#;
    let complaint = read(&tree(), Some(srdf), None).unwrap_err().to_string();
    assert_says(&complaint, &["test.srdf: line 2", "candidates: shank"]);
    assert_says(&complaint, &["unknown link \"shenk\""]);
    let robot = load_from_strings(&tree(), Some(srdf), None, "test", &no_meshes, &LENIENT);
    assert_says(&robot.unwrap().notes.join("\n"), &["shenk"]);
}

const FOOT: &str = r#"
    [[patch]]
    name = "foot"
    link = "sole"
    position_m = [0.0, 0.0, -0.01]
    rpy_rad = [0.0, 0.0, 1.5707963267948966]
    polygon_m = [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]]
    roles = ["foot"]
    friction = 0.6
"#;

const TOE: &str = r#"
    [[patch]]
    name = "toe"
    link = "sole"
    kind = "point"
    radius_m = 0.02
    friction = 0.6
"#;

#[test]
fn contacts_are_read() {
    let robot = read(&tree(), None, Some(FOOT)).unwrap();
    let patch = robot.patch("foot").unwrap();
    let ids: Vec<_> = robot.patch_ids().collect();
    assert_eq!(ids, [robot.patch_id("foot").unwrap()]);
    assert_eq!(robot.patches[ids[0]].name, "foot");
    let sole = robot.frame("sole").unwrap();
    assert_eq!(patch.body, sole.body);
    let X_LC = sole.X_BL.inv_mul(&patch.X_BC);
    assert!((X_LC.translation.z + 0.01).abs() < 1e-15);
    assert!((X_LC.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!(patch.has_role("foot") && !patch.has_role("hand"));
    let unknown = robot.patch("hand").unwrap_err().to_string();
    assert_says(&unknown, &["candidates: foot"]);

    let robot = read(&tree(), None, Some(TOE)).unwrap();
    let toe = robot.patch("toe").unwrap();
    assert_eq!(toe.kind, PatchKind::Point { radius_m: 0.02 });
    assert_eq!(toe.polygon, [Point2::origin()]);
    let quarter = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
    let centre = Vector3::new(0.0, -0.02, 0.0);
    assert!((toe.touching(&quarter).translation.vector - centre).norm() < 1e-15);
}

#[test]
fn contacts_that_cannot_be_are_refused_by_name() {
    let contacts = |text: &str| read(&tree(), None, Some(text));
    let table = r#"
        0.02 => -0.02 ! "toe", radius_m -0.02
        0.02 => nan ! radius_m NaN
        radius_m = 0.02 => ! needs radius_m
        kind = "point" => ! needs polygon_m
        "point" => "ball" ! line, ball
        radius_m = 0.02 => polygon_m = [[0.0, 0.0]] ! needs radius_m
        friction = 0.6 => friction = 0.6 polygon_m = [] ! line
    "#;
    assert_refuses(TOE, table, "test contacts: ", contacts);
    let both = TOE.replace("friction", "polygon_m = [[0.0, 0.0]]\n    friction");
    assert_says(&contacts(&both).unwrap_err().to_string(), &["no polygon_m"]);
    let table = r#"
        link = "sole" => link = "soul" ! candidates: sole
        [-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05] => [-0.1, 0.05], [0.1, 0.05], [0.1, -0.05], [-0.1, -0.05] ! clockwise
        [-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05] => [-0.1, 0.0], [0.1, 0.0] ! 2 vertices
        [-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05] => [0, 0], [1, 0], [1, 0], [0, 1] ! the same
        [0.1, 0.05] => [0.1, inf] ! not within
        friction = 0.6 => friction = 0.0 ! not positive
        friction = 0.6 => ! missing field `friction`
        roles = => rules = ! unknown field `rules`
        [[patch]] => [[patch] ! line 2
    "#;
    assert_refuses(FOOT, table, "test contacts: ", contacts);
    let twice = contacts(&format!("{FOOT}{FOOT}")).unwrap_err().to_string();
    assert_says(&twice, &["\"foot\"", "given twice"]);
}

#[test]
fn what_was_assumed_is_noted() {
    let notes = support::test_tree().notes.join("\n");
    assert_says(&notes, &["\"bite\" at 0.25 (mimics \"hip\")"]);
    assert_says(&notes, &["continuous joints are limited to ±2π rad: spin"]);
    let text = tree()
        .replace(r#"effort="120""#, r#"effort="0""#)
        .replace(r#"lower="-0.5" upper="0.5""#, r#"lower="0.1" upper="0.1""#);
    let robot = read(&text, None, None).unwrap();
    let notes = robot.notes.join("\n");
    assert_says(&notes, &["no effort limit is stated, none is used: hip"]);
    assert_says(&notes, &["without a range are locked: \"wobble\" at 0.1"]);
    assert_eq!((robot.nj(), robot.bodies[1].effort), (3, f64::INFINITY));
}

#[test]
fn unknown_names_list_candidates() {
    let robot = support::test_tree();
    assert_eq!(robot.joint_index("slide").unwrap(), 1);
    let complaint = robot.joint_index("hips").unwrap_err().to_string();
    assert_says(&complaint, &["unknown joint \"hips\"; candidates: hip"]);
    let complaint = robot.posture("standing").unwrap_err().to_string();
    assert_says(&complaint, &["there is none to choose from"]);
}

/// Edits of the URDF (parted by ¶), SRDF and contacts, and what all is said to be wrong at once.
#[test]
fn all_that_is_wrong_is_told_at_once() {
    let patch = |text: &str| {
        format!("[[patch]]\n{text}\nfriction = 0.5\npolygon_m = [[0, 0], [1, 0], [0, 1]]\n")
    };
    let contacts = [
        patch("name = \"a\"\nlink = \"soles\"\nrole = [\"foot\"]"),
        patch("name = \"b\"\nlink = \"sole\"")
            .replace("0.5", "-1")
            .replace("[1, 0]", "[0, 2]"),
        patch("name = \"c\"\nlink = 3"),
    ];
    let wrong_keys = [contacts[0].as_str(), &contacts[2]].concat();
    let wrong_values = [contacts[0].replace("role", "roles"), contacts[1].clone()].concat();
    let srdf = r#"<robot name="t"><group_state name="up"><joint name="hip" value="x"/></group_state>
        <disable_collisions link1="sole" link2="leg"/><disable_collisions link1="sole"/></robot>"#;
    for (edits, srdf, contacts, told) in [
        (
            "<sphere radius=\"0.03\"/> => <sphere/> ¶ <mass value=\"0.1\"/> =>",
            None,
            None,
            &["has no attribute \"radius\"", "has no <mass>"][..],
        ),
        (
            "name=\"spin\" => name=\"hip\" ¶ <child link=\"sole\"/> => <child link=\"soles\"/>",
            None,
            None,
            &["two joints are named \"hip\"", "unknown link \"soles\""],
        ),
        (
            "<mass value=\"0.1\"/> => <mass value=\"-0.1\"/> ¶ <axis xyz=\"0.3 -1.0 0.2\"/> => <axis xyz=\"0 0 0\"/> ¶ \
             <sphere radius=\"0.03\"/> => <mesh filename=\"a.stl\"/>",
            Some(srdf),
            Some(wrong_values.as_str()),
            &[
                "link \"tooth\": its mass",
                "joint \"hip\"",
                "a.stl",
                "not a number",
                "unknown link \"leg\"",
                "no attribute \"link2\"",
                "unknown link \"soles\"",
                "friction -1",
                "its polygon",
            ],
        ),
        (
            "",
            None,
            Some(&wrong_keys),
            &["line 4: unknown field `role`", "line 9: invalid type"],
        ),
    ] {
        let mut urdf = tree();
        for edit in edits.split(" ¶ ").filter(|edit| !edit.is_empty()) {
            let (from, to) = edit.split_once(" =>").unwrap();
            assert!(urdf.contains(from), "there is no {from}");
            urdf = urdf.replacen(from, to.trim(), 1);
        }
        let said = read(&urdf, srdf, contacts).unwrap_err().to_string();
        assert_says(&said, told);
        assert_eq!(said.matches("\n  - ").count(), told.len(), "{said}");
    }
}
