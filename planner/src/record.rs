//! The path as stances of a plan file.

use nalgebra::{Isometry3, Vector3};
use posture::Environment;
use robot_model::Robot;

use crate::answer::PathStance;
use crate::plan::{Margins, Pose, Stance, StanceContact};

/// The stances of a path, ready to be written.
pub fn stances(robot: &Robot, environment: &Environment, path: &[PathStance]) -> Vec<Stance> {
    path.iter()
        .enumerate()
        .map(|(i, stance)| record(robot, environment, i, stance))
        .collect()
}

fn record(robot: &Robot, environment: &Environment, index: usize, stance: &PathStance) -> Stance {
    let posture = &stance.posture;
    let contacts = stance
        .contacts
        .iter()
        .zip(&posture.contacts)
        .map(|(&(patch, surface, loaded), state)| {
            let patch = &robot.patches[patch];
            StanceContact {
                patch: patch.name.clone(),
                link: patch.link.clone(),
                surface: environment
                    .surfaces
                    .get(surface)
                    .map_or_else(String::new, |s| s.id.clone()),
                X_WC: pose(&state.X_WC),
                friction: patch.friction,
                loaded,
                vertices_W: state.vertices_W.iter().map(array).collect(),
                force_points_W: state.force_points_W.iter().map(array).collect(),
                forces_W: state.forces_W.iter().map(array).collect(),
            }
        })
        .collect();
    let m = &posture.margins;
    Stance {
        index,
        change: stance.change.clone(),
        contacts,
        q: posture.q.to_q(),
        com_W: array(&posture.com_W),
        margins: Margins {
            closure_m: m.closure_m,
            inclusion_m: m.inclusion_m,
            equilibrium: m.equilibrium,
            friction_use: m.friction_use,
            torque_use: m.torque_use,
            joint_rad: m.joint_rad,
            clearance_m: m.clearance_m,
            self_clearance_m: m.self_clearance_m,
        },
    }
}

fn pose(x: &Isometry3<f64>) -> Pose {
    let q = x.rotation.coords;
    Pose {
        p: array(&x.translation.vector),
        quat_xyzw: [q.x, q.y, q.z, q.w],
    }
}

fn array(v: &Vector3<f64>) -> [f64; 3] {
    [v.x, v.y, v.z]
}
