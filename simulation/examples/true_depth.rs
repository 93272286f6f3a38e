//! How deep a motion's robot is in the true world of a scene that ships, whatever its plan saw of it:
//!
//! ```sh
//! cargo run --release -p scandent-simulation --example true_depth SCENE ROBOT MOTION.json
//! ```
use std::collections::BTreeMap;

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};
use robot_model::collision::{Other, World};
use robot_model::{Configuration, Kinematics};

/// What is this far from everything is not told, m.
const NEAR_M: f64 = 0.005;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, robot, file] = &arguments[..] else {
        return Err("SCENE ROBOT MOTION.json".into());
    };
    let truth = scenes::builtin(scene).ok_or("no such scene")?.truth;
    let boxes = truth().boxes;
    let robot = scenes::builtin_robot(robot).ok_or("no such robot")?;
    let robot = robot.load(&Default::default())?;
    let corners = |solid: &scenes::OrientedBox| -> Vec<Point3<f64>> {
        let faces = [-1.0, 1.0].into_iter();
        let all = faces.flat_map(|x| {
            [
                [x, -1.0, -1.0],
                [x, 1.0, -1.0],
                [x, -1.0, 1.0],
                [x, 1.0, 1.0],
            ]
        });
        let half = Vector3::from(solid.size_m) / 2.0;
        let at = |c: [f64; 3]| solid.X_WO() * Point3::from(half.component_mul(&Vector3::from(c)));
        all.map(at).collect()
    };
    let bodies: Vec<_> = boxes.iter().map(corners).collect();
    let world = World::new(&bodies).map_err(|(body, cause)| format!("{body}: {cause}"))?;
    let motion: plan::Motion = serde_json::from_slice(&std::fs::read(file)?)?;

    // The least distance of each link from each body, and when.
    let mut least: BTreeMap<(String, String), (f64, f64, Vector3<f64>)> = BTreeMap::new();
    for sample in &motion.samples {
        let q = &sample.q;
        let configuration = Configuration {
            p_WB: Vector3::new(q[0], q[1], q[2]),
            R_WB: UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5])),
            joints: q[7..].to_vec().into(),
        };
        let kinematics = Kinematics::new(&robot, &configuration);
        let (mut near, all) = (Vec::new(), |_, _| false);
        (robot.collision).world_proximities(&kinematics, &world, NEAR_M, &all, &mut near);
        for pair in near {
            let Other::Obstacle(body) = pair.b else {
                continue;
            };
            let link = robot.collision.shapes()[pair.a.shape].link.clone();
            let entry = least.entry((link, boxes[body].name.clone()));
            let now = (pair.distance, sample.t_s, pair.p_a_W);
            let kept = entry.or_insert(now);
            if now.0 < kept.0 {
                *kept = now;
            }
        }
    }
    let mut told: Vec<_> = least.into_iter().collect();
    told.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    for ((link, body), (distance_m, t_s, p)) in told {
        let mm = 1e3 * distance_m;
        println!(
            "{mm:8.1} mm  {link} from {body} at {t_s:.2} s, ({:.3}, {:.3}, {:.3}) m",
            p.x, p.y, p.z
        );
    }
    Ok(())
}
