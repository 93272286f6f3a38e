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
    // A ball that rolls from elsewhere, all along or from one stance to the next.
    let far = |p: &mut plan::Contact| p.rolls_from.as_mut().unwrap().p[0] += 3e-3;
    let each = |p: &mut Plan| {
        let contacts = p.stances.iter_mut().flat_map(|s| &mut s.contacts);
        contacts.for_each(far);
    };
    assert!(faults(&each).contains(&Check::Kept));
    assert!(faults(&|p| far(&mut p.stances[1].contacts[0])).contains(&Check::Kept));
    // One that does not roll although its link turns.
    let dragged = |p: &mut Plan| {
        let contacts = p.stances.iter_mut().flat_map(|s| &mut s.contacts);
        contacts.for_each(|contact| contact.rolls_from = None);
    };
    assert!(faults(&dragged).contains(&Check::Kept));
    // A surface that is lower than the plan says.
    let lowered = |p: &mut Plan| p.faces[0].X_WF.translation.vector.z -= 0.01;
    assert!(faults(&lowered).contains(&Check::Closure));
}

/// The plan says how a ball rolls by a formula that knows nothing of the way to a posture; the sum over the way does.
#[test]
fn its_balls_roll_all_the_way_and_hardly_slide() {
    let Walked { robot, .. } = &*WALKED;
    let motion = WALKED.motion();
    let (mut farthest_m, mut worst_m) = (0.0_f64, 0.0_f64);
    for (foot, patch) in robot.patches.iter().enumerate() {
        let radius_m = patch.point_radius_m().unwrap();
        let (mut rolled, mut slid) = (Vector3::zeros(), Vector3::zeros());
        let mut before: Option<robot_model::Kinematics> = None;
        for sample in &motion.samples {
            let phase = motion.phases.iter().find(|p| sample.t_s < p.t_end_s);
            let is_closed = |c: &plan::Contact| c.patch == robot.patches[foot].name;
            let stands = phase.is_some_and(|p| p.contacts.iter().any(is_closed));
            let q = robot_model::Configuration::from_q(&sample.q).unwrap();
            let now = robot_model::Kinematics::new(robot, &q);
            match &before {
                Some(before) if stands => {
                    let [a, b] = [before, &now].map(|k| k.X_WC(patch));
                    let turn = (b.rotation * a.rotation.inverse()).scaled_axis();
                    let rolls = radius_m * turn.cross(&Vector3::z());
                    rolled += rolls;
                    slid += b.translation.vector - a.translation.vector - rolls;
                    farthest_m = farthest_m.max(rolled.norm());
                    worst_m = worst_m.max(slid.norm());
                }
                _ => (rolled, slid) = (Vector3::zeros(), Vector3::zeros()),
            }
            before = stands.then_some(now);
        }
    }
    println!("rolls by {farthest_m} m, slides by {worst_m} m");
    assert!(farthest_m > 8e-3, "{farthest_m} m");
    assert!(worst_m < 0.25 * farthest_m, "{worst_m} of {farthest_m} m");
}
