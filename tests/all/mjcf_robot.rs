//! A robot given as MJCF: planned for, verified and simulated as one given as URDF.

#[cfg(not(feature = "mujoco"))]
use crate::support::program::ends_with;

/// A quadruped: hips, thighs and shanks of capsules, balls for feet.
fn quadruped() -> String {
    let leg = |name: &str, x: f64, y: f64| {
        let side = 0.05 * y.signum();
        format!(
            r#"<body name="{name}_hip" pos="{x} {y} 0">
                 <joint name="{name}_hip" axis="1 0 0" range="-.8 .8"/><geom size=".03" mass=".6"/>
                 <body name="{name}_thigh" pos="0 {side} 0">
                   <joint name="{name}_thigh" axis="0 1 0" range="-1 2.5"/>
                   <geom type="capsule" fromto="0 0 -.04 0 0 -.18" size=".02" mass=".8"/>
                   <body name="{name}_shank" pos="0 0 -.22">
                     <joint name="{name}_knee" axis="0 1 0" range="-2.6 -.5"/>
                     <geom type="capsule" fromto="0 0 -.04 0 0 -.18" size=".012" mass=".2"/>
                     <geom size=".02" pos="0 0 -.22" mass=".05"/>
            </body></body></body>"#
        )
    };
    let legs = [
        ("fl", 0.2, 0.06),
        ("fr", 0.2, -0.06),
        ("rl", -0.2, 0.06),
        ("rr", -0.2, -0.06),
    ];
    let legs: String = legs.iter().map(|(name, x, y)| leg(name, *x, *y)).collect();
    let motors = ["fl", "fr", "rl", "rr"].map(|leg| {
        let of = |joint| format!(r#"<motor joint="{leg}_{joint}" ctrlrange="-40 40"/>"#);
        ["hip", "thigh", "knee"].map(of).concat()
    });
    format!(
        r#"<mujoco model="four"><compiler angle="radian" autolimits="true"/><worldbody>
             <geom type="plane" size="5 5 1"/>
             <body name="trunk" pos="0 0 .4"><freejoint/>
               <geom type="box" size=".22 .06 .04" mass="6"/>{legs}</body>
           </worldbody><actuator>{}</actuator></mujoco>"#,
        motors.concat()
    )
}

#[test]
#[cfg(feature = "mujoco")]
fn a_robot_in_mjcf_is_planned_for_verified_and_simulated() {
    use crate::support::program::succeeds;

    let place = tempfile::tempdir().unwrap();
    let [robot, bench, out] = ["four.xml", "bench", "out"].map(|name| place.path().join(name));
    std::fs::write(&robot, quadruped()).unwrap();
    let said = succeeds(
        "robot @ --propose @",
        &[&robot, &place.path().join("proposed")],
    );
    assert!(
        said.contains("read from MJCF") && said.contains("postures: standing"),
        "{said}"
    );
    succeeds(
        "bench --robot @ --family stairs-up --count 1 -o @",
        &[&robot, &bench],
    );
    let world = bench.join("worlds/stairs-up-four-1.toml");
    let said = succeeds("plan @ -o @", &[&world, &out]);
    assert!(said.contains("verified: all of"), "{said}");
    let plan = out.join("plan.json");
    succeeds("verify @", &[&plan]);
    succeeds("simulate @ --execute", &[&plan]);
    // The plan is that robot's only.
    let heavier = quadruped().replace("mass=\".8\"", "mass=\".9\"");
    std::fs::write(&robot, heavier).unwrap();
    crate::support::program::ends_with("verify @", &[&plan], 1, &["FAIL"]);
}

#[test]
#[cfg(not(feature = "mujoco"))]
fn without_mujoco_mjcf_is_named_and_refused() {
    let place = tempfile::tempdir().unwrap();
    let robot = place.path().join("four.xml");
    std::fs::write(&robot, quadruped()).unwrap();
    ends_with(
        "robot @",
        &[&robot],
        1,
        &["four.xml", "MJCF", "--features mujoco"],
    );
}
