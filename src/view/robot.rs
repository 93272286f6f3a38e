//! The robot in the page: its collision shapes, and where its bodies are in a stance.

use anyhow::{Result, ensure};
use plan::Plan;
use robot_model::collision::ShapeGeometry;
use robot_model::{Body, Configuration, Kinematics, Robot};
use serde_json::{Value, json};

use super::number::{metres, point, pose};

/// # Errors
/// When the plan was made for other joints, naming the first that differs.
pub(super) fn check_joints(robot: &Robot, plan: &Plan) -> Result<()> {
    let theirs = &plan.robot.joint_names;
    let (meant, given, joints) = (&plan.robot.name, &robot.name, robot.nj());
    let wanted = theirs.len();
    ensure!(
        joints == wanted,
        "the plan is for robot {meant:?} with {wanted} joints, but robot {given:?} has {joints}"
    );
    for (j, (ours, theirs)) in robot.joint_names().zip(theirs).enumerate() {
        ensure!(
            ours == theirs,
            "joint {j} of the plan is {theirs:?}, of robot {given:?} {ours:?}"
        );
    }
    Ok(())
}

/// The bodies' names and shapes.
pub(super) fn bodies(robot: &Robot) -> Vec<Value> {
    let shapes_of = |body: usize| -> Vec<Value> {
        let own = robot.collision.shapes().iter().filter(|s| s.body == body);
        own.map(|s| {
            let mut record = geometry(&s.geometry);
            record["X_BG"] = json!(pose(&s.X_BG));
            record
        })
        .collect()
    };
    let bodies = robot.bodies.iter().enumerate();
    let record = |(i, body): (_, &Body)| json!({ "name": body.name, "shapes": shapes_of(i) });
    bodies.map(record).collect()
}

/// A shape in its own frame, its lengths along z.
fn geometry(shape: &ShapeGeometry) -> Value {
    match shape {
        ShapeGeometry::Sphere { radius_m } => {
            json!({ "kind": "sphere", "radius_m": metres(*radius_m) })
        }
        ShapeGeometry::Capsule {
            half_length_m,
            radius_m,
        } => json!({
            "kind": "capsule", "half_length_m": metres(*half_length_m), "radius_m": metres(*radius_m),
        }),
        ShapeGeometry::Cylinder {
            half_length_m,
            radius_m,
        } => json!({
            "kind": "cylinder", "half_length_m": metres(*half_length_m), "radius_m": metres(*radius_m),
        }),
        ShapeGeometry::Box { half_extents_m: h } => {
            json!({ "kind": "box", "half_extents_m": [metres(h.x), metres(h.y), metres(h.z)] })
        }
        ShapeGeometry::ConvexHull(hull) => json!({
            "kind": "mesh",
            "vertices_m": hull.vertices().iter().flat_map(point).collect::<Vec<_>>(),
            "triangles": hull.triangles().as_flattened(),
        }),
    }
}

/// Poses of all bodies in W at `q`, seven numbers a body.
///
/// # Errors
/// When `q` is not a posture of the robot.
pub(super) fn poses(robot: &Robot, q: &[f64]) -> Result<Vec<f64>> {
    let configuration = Configuration::from_q(q)?;
    let (values, joints) = (configuration.joints.len(), robot.nj());
    ensure!(
        values == joints,
        "q has {values} joint values, robot {:?} has {joints} joints",
        robot.name
    );
    let kinematics = Kinematics::new(robot, &configuration);
    Ok(kinematics.X_WB.iter().flat_map(pose).collect())
}
