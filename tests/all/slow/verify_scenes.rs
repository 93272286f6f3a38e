//! What is planned for the humanoid passes the verifier, and fails it broken in every way of the table.

use nalgebra::Vector3;
use plan::Plan;
use robot_model::Robot;
use surfaces::Terrain;
use verify::verify;

use crate::support::mutations;
use crate::support::program::robot;
use crate::support::shipped::shipped;
use crate::support::walk::{Walk, face};

fn judge(plan: &Plan, robot: &Robot) {
    let certificate = verify(plan, None, robot);
    assert!(certificate.pass, "{}", certificate.table());
    mutations::assert_noticed(plan, robot);
}

#[test]
fn the_plan_of_each_scene_passes_and_every_broken_one_fails() {
    for scene in ["irregular-stairs", "slope-and-hand"] {
        judge(&shipped(scene).plan, &robot("hrp2"));
    }
}

/// A floor and two steps of 0.15 m, each with its front.
fn stairs() -> Terrain {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut faces = vec![face("floor", -0.2 * x, x, y, [0.44, 1.0])];
    for (k, length) in [0.34, 1.0].into_iter().enumerate() {
        let (start, height) = (0.24 + 0.34 * k as f64, 0.15 * (k + 1) as f64);
        let top = Vector3::new(start + length / 2.0, 0.0, height);
        faces.push(face(&format!("step{k}"), top, x, y, [length / 2.0, 0.6]));
        let front = Vector3::new(start, 0.0, height / 2.0);
        let (id, half) = (format!("front{k}"), [0.6, height / 2.0]);
        faces.push(face(&id, front, -y, z, half));
    }
    let edges = faces.iter_mut().flat_map(|f| f.region.edges_mut());
    edges.flatten().for_each(|edge| edge.further_m = 0.01);
    Terrain {
        faces,
        obstacles: Vec::new(),
    }
}

#[test]
fn a_climb_of_exactly_known_stairs_passes_and_every_broken_one_fails() {
    let walk = Walk {
        robot: robot("hrp2"),
        terrain: stairs(),
        way: vec![Vector3::new(0.88, 0.0, 0.3)],
        tolerance_m: 0.15,
        goal_face: None,
        usable: ["floor", "step0", "step1"].map(str::to_owned).to_vec(),
        posture: posture::Config::default(),
    };
    let walked = walk.plan();
    walked.assert_found();
    judge(&walked.plan, &walked.robot);
}
