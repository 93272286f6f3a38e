//! A robot on six balls walks over flat ground and onto a step, from known surfaces; the verifier
//! agrees with every stance and every sample of the motion, and physics with the whole.
use std::sync::LazyLock;

use nalgebra::Vector3;
use plan::Plan;
use scandent::export::{self, Format};
use surfaces::Terrain;
use verify::{Check, verify};

use crate::support::program::robot;
use crate::support::walk::{Walk, Walked, face};

const STEP_M: f64 = 0.1;
/// Where the step begins: the front feet stand at 0.675 m.
const EDGE_M: f64 = 1.2;
/// With this way behind it, it stands on the step with every foot.
const WAY_M: f64 = 2.0;

/// A floor and a step.
fn terrain() -> Terrain {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let floor = Vector3::new(EDGE_M - 1.2, 0.0, 0.0);
    let step = Vector3::new(EDGE_M + 1.2, 0.0, STEP_M);
    let riser = Vector3::new(EDGE_M, 0.0, 0.5 * STEP_M);
    Terrain {
        faces: vec![
            face("floor", floor, x, y, [1.2; 2]),
            face("step", step, x, y, [1.2; 2]),
            face("riser", riser, -y, z, [1.2, 0.5 * STEP_M]),
        ],
        obstacles: Vec::new(),
    }
}

/// Onto the step.
static WALKED: LazyLock<Walked> = LazyLock::new(|| {
    let walk = Walk {
        robot: robot("hexapod"),
        terrain: terrain(),
        way: vec![Vector3::new(WAY_M, 0.0, STEP_M)],
        tolerance_m: 0.1,
        goal_face: Some("step"),
        usable: ["floor", "step"].map(str::to_owned).to_vec(),
        posture: posture::Config::default(),
    };
    walk.plan()
});

#[test]
fn it_walks_onto_a_step_and_verifier_and_physics_agree() {
    let walked = &*WALKED;
    let (plan, robot) = (&walked.plan, &walked.robot);
    walked.show("hexapod-step");
    walked.assert_certified();
    #[cfg(feature = "mujoco")]
    walked.assert_executed();

    let stances = &plan.stances;
    let last = stances.last().expect("a stance");
    assert_eq!(last.contacts.len(), 6);
    let on_step = |c: &&plan::Contact| c.face.as_str() == "step";
    assert_eq!(last.contacts.iter().filter(on_step).count(), 6);
    for stance in stances {
        // One leg at a time: five feet carry, or all.
        assert!(stance.contacts.iter().filter(|c| c.loaded).count() >= 5);
        for contact in &stance.contacts {
            // The centre is a radius over the touched point.
            let [touched] = contact.vertices_W[..] else {
                panic!("{} points", contact.vertices_W.len());
            };
            let level = if on_step(&contact) { STEP_M } else { 0.0 };
            assert!((touched[2] - level).abs() < 1e-4, "{touched:?}");
            let patch = &robot.patches[robot.patch_index(&contact.patch).expect("a patch")];
            let radius = patch.point_radius_m().expect("a ball");
            assert!((contact.X_WC.p[2] - touched[2] - radius).abs() < 1e-9);
        }
    }

    // Written in the formats that know of balls, refused by the one that does not.
    let config = export::Config::default();
    for format in [Format::Json, Format::Csv] {
        export::export(plan, None, robot, format, &config).expect("written");
    }
    let refused = export::export(plan, None, robot, Format::MccYaml, &config);
    let refused = format!("{:#}", refused.expect_err("no balls"));
    assert!(refused.contains("touches with"), "{refused}");
}

#[test]
fn the_verifier_finds_a_ball_that_is_moved_or_pushed_elsewhere() {
    let Walked { plan, robot, .. } = &*WALKED;
    let faults = |change: &dyn Fn(&mut Plan)| {
        let mut changed = plan.clone();
        change(&mut changed);
        verify(&changed, None, robot).failed_checks()
    };
    assert_eq!(faults(&|_| {}), []);
    // A thigh lifted by a degree lifts its ball by some millimetres.
    let thigh = 7 + robot.joint_index("front_left_thigh").expect("a thigh");
    assert!(faults(&|p| p.stances[0].q[thigh] += 1f64.to_radians()).contains(&Check::Closure));
    // A force at the centre instead of the touched point.
    let centre = |p: &mut Plan| {
        let contact = &mut p.stances[0].contacts[0];
        contact.force_points_W = vec![contact.X_WC.p];
    };
    assert!(faults(&centre).contains(&Check::ForcePoint));
    // The centre stated where the touched point is.
    let sunk = |p: &mut Plan| {
        let contact = &mut p.stances[0].contacts[0];
        contact.X_WC.p = contact.vertices_W[0];
    };
    assert!(faults(&sunk).contains(&Check::Pose));
    // A surface that is lower than the plan says.
    let lowered = |p: &mut Plan| p.faces[0].X_WF.translation.vector.z -= 0.01;
    assert!(faults(&lowered).contains(&Check::Closure));
}
