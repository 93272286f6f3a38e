//! Robots out of MJCF, against what MuJoCo itself computes of them.

use mujoco_rs::prelude::*;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot_model::{Kinematics, Robot, RobotFiles, load};
use simulation::from_mjcf::document;

/// Anchors off the origin, several joints on a body, a reference value, a slide, a turned base, what gives way,
/// what follows, ellipsoids, meshes, what is only shown, and a ball beside the robot.
const ODD: &str = r#"
<mujoco model="odd &amp; even">
  <compiler angle="degree" autolimits="true"/>
  <asset><mesh name="tip" vertex="0 0 0  .1 0 0  0 .1 0  0 0 .1"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="ball" pos="2 0 0"><freejoint/><geom size=".1"/></body>
    <body name="trunk" pos="0 0 1" quat="1 0 0 .3">
      <freejoint/>
      <geom type="ellipsoid" size=".2 .1 .05" mass="4"/>
      <body name="leg" pos=".1 -.2 .05" euler="10 20 30">
        <joint name="yaw" axis="0 0 1" pos=".02 .01 0" range="-60 60"/>
        <joint name="pitch" axis="0 1 .2" pos="0 0 .03" range="-20 90" ref="15"/>
        <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03" mass="1"/>
        <geom type="box" size=".4 .4 .4" contype="0" conaffinity="0" mass=".1"/>
        <body name="shank" pos="0 0 -.3">
          <joint name="knee" axis="1 0 0" range="-90 0"/>
          <joint name="stretch" type="slide" axis="0 0 1" range="-.1 .1" ref=".02"/>
          <geom type="mesh" mesh="tip" mass=".5"/>
          <body name="toe" pos="0 0 -.2">
            <joint name="give" axis="0 1 0" range="5 30" pos="0 0 .1"/>
            <geom type="sphere" size=".02" mass=".1"/>
            <site name="sole" pos="0 0 -.02"/>
          </body>
          <body name="claw" pos=".1 0 -.1">
            <joint name="grip" axis="0 1 0" range="-30 30"/>
            <geom type="sphere" size=".02" mass=".1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="trunk" body2="toe"/></contact>
  <equality><joint joint1="grip" joint2="knee" polycoef=".1 2 0 0 0"/></equality>
  <actuator>
    <motor joint="yaw" gear="20" ctrlrange="-2 3"/>
    <position joint="pitch" kp="50" forcerange="-9 9" gear="2"/>
    <position joint="knee" kp="50"/>
    <motor joint="stretch"/>
  </actuator>
  <keyframe><key name="bent" qpos="0 0 0 1 0 0 0  0 0 1 1 0 0 0  .1 .2 -.3 .04 .1 .2"/></keyframe>
</mujoco>"#;

fn read(text: &str) -> (Robot, MjModel) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.xml");
    std::fs::write(&path, text).unwrap();
    let mut files = RobotFiles::new(&path);
    files.document = Some(document(&path).unwrap());
    (
        load(&files).unwrap(),
        MjModel::from_xml_string(text).unwrap(),
    )
}

#[test]
fn frames_and_centres_of_mass_are_mujocos() {
    let (robot, model) = read(ODD);
    assert_eq!(robot.name, "odd & even");
    let names: Vec<&str> = robot.joint_names().collect();
    assert_eq!(names, ["yaw", "pitch", "knee", "stretch"]);
    let mut data = MjData::try_new(&model).unwrap();
    let at = |joint: &str| {
        let id = model.name_to_id(MjtObjBase::mjOBJ_JOINT, joint).unwrap();
        model.jnt_qposadr()[id] as usize
    };
    for number in 0..20 {
        let mut q = robot_model::load::sampled(&robot, number);
        q.p_WB = Vector3::new(0.3, -0.2, 1.1);
        q.R_WB = UnitQuaternion::from_euler_angles(0.1 * number as f64, 0.2, -0.4);
        let base = [
            q.p_WB.x, q.p_WB.y, q.p_WB.z, q.R_WB.w, q.R_WB.i, q.R_WB.j, q.R_WB.k,
        ];
        // The robot is the second tree; what gives way rests, what follows is where its leader's zero has it.
        data.qpos_mut()[7..14].copy_from_slice(&base);
        for (name, value) in names.iter().zip(q.joints.iter()) {
            data.qpos_mut()[at(name)] = *value;
        }
        data.qpos_mut()[at("give")] = 5_f64.to_radians();
        data.qpos_mut()[at("grip")] = 0.1;
        data.forward();
        let kinematics = Kinematics::new(&robot, &q);
        for name in ["trunk", "leg", "shank", "toe", "claw"] {
            let id = model.name_to_id(MjtObjBase::mjOBJ_BODY, name).unwrap();
            let X_WL = kinematics.X_WL(&robot, name).unwrap();
            let off = (X_WL.translation.vector - Vector3::from(data.xpos()[id])).norm();
            let [w, i, j, k] = data.xquat()[id];
            let turned = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
            assert!(off < 1e-9, "{name} of posture {number} is {off} m off");
            assert!(X_WL.rotation.angle_to(&turned) < 1e-7, "{name}");
        }
        let site = Vector3::from(data.site_xpos()[0]);
        let sole = kinematics.X_WL(&robot, "sole").unwrap().translation.vector;
        assert!((sole - site).norm() < 1e-9);
        let trunk = model.name_to_id(MjtObjBase::mjOBJ_BODY, "trunk").unwrap();
        let com = Vector3::from(data.subtree_com()[trunk]);
        assert!(
            (kinematics.com_W - com).norm() < 1e-9,
            "{}",
            kinematics.com_W - com
        );
        assert!((robot.mass_kg - model.body_subtreemass()[trunk]).abs() < 1e-9);
    }
}

#[test]
fn what_a_model_says_beside_its_tree_is_kept_and_what_is_not_is_told() {
    let (robot, _) = read(ODD);
    let effort = |name: &str| robot.bodies[robot.joint_index(name).unwrap() + 1].effort;
    let efforts = ["yaw", "pitch", "knee", "stretch"].map(effort);
    assert_eq!(efforts, [40.0, 18.0, f64::INFINITY, f64::INFINITY]);
    assert_eq!(robot.postures["bent"].joints, [0.1, 0.2, -0.3, 0.04]);
    let shapes = robot.collision.shapes();
    assert_eq!(
        shapes.len(),
        5,
        "the box is only shown, the ball no part of the robot"
    );
    let watched = |a: &str, b: &str| {
        let pairs = robot.collision.pairs().iter();
        let link = |k: usize| shapes[k].link.as_str();
        pairs
            .into_iter()
            .any(|&(i, j)| [(a, b), (b, a)].contains(&(link(i), link(j))))
    };
    assert!(watched("trunk", "claw") && !watched("trunk", "toe"));
    let notes = robot.notes.join("\n");
    for told in [
        "beside the robot are left out: ball",
        "without an actuator are locked: give",
        "mimic joints are locked: \"grip\" at 0.1",
        "hulls up to 2 % larger: trunk",
        "no velocity limit is stated, none is used: yaw",
    ] {
        assert!(notes.contains(told), "{told}: {notes}");
    }
}

#[test]
fn files_without_one_robot_are_refused() {
    let refused = |text: &str| {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(&file, text).unwrap();
        document(file.path()).unwrap_err().to_string()
    };
    let body = |inner: &str| format!("<mujoco><worldbody>{inner}</worldbody></mujoco>");
    let two = "<body name='a'><geom size='1'/><body><joint/><geom size='1'/></body></body>";
    assert!(refused("<mujoco><worldbody><body/>").contains("load failed"));
    assert!(refused(&body("<geom size='1'/>")).contains("no robot in it"));
    assert!(refused(&body(&(two.to_owned() + &two.replace("'a'", "'b'")))).contains("a, b have"));
}
