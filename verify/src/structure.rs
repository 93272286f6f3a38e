//! The plan as a whole: its format, robot, promises and environment.

use std::collections::BTreeSet;

use plan::{Change, PLAN_FORMAT, Plan};
use robot_model::Robot;

use crate::findings::{Findings, exceeds};
use crate::{Check, TOLERANCES};

/// Everything that concerns no single stance; whether the stances can be looked at.
pub(crate) fn check(plan: &Plan, robot: &Robot, findings: &mut Findings) -> bool {
    if plan.format != PLAN_FORMAT {
        let note = format!("{:?}, {PLAN_FORMAT:?} is read here", plan.format);
        findings.flaw(None, Check::Format, "", note);
    }
    same_robot(plan, robot, findings);
    required(plan, findings);
    environment(plan, findings);
    let sets = plan.stances.iter().filter(|s| s.change != Change::Goal);
    let sets = sets.count();
    if plan.search.path_stances != sets {
        let note = format!("{} stated, the plan has {sets}", plan.search.path_stances);
        findings.flaw(None, Check::PathLength, "", note);
    }
    let ends = plan
        .stances
        .last()
        .is_some_and(|s| s.change == Change::Goal);
    if ends && plan.search.changes_min >= sets {
        let note = format!(
            "at least {} changes stated, the plan has fewer",
            plan.search.changes_min
        );
        findings.flaw(None, Check::PathLength, "", note);
    }
    for check in [
        Check::Format,
        Check::Robot,
        Check::Required,
        Check::Environment,
        Check::PathLength,
    ] {
        findings.holds_unless_flawed(None, check);
    }
    !findings.flawed(None, Check::Environment)
}

fn same_robot(plan: &Plan, robot: &Robot, findings: &mut Findings) {
    let mut flaw = |note: String| findings.flaw(None, Check::Robot, "", note);
    let stated = &plan.robot;
    if stated.name != robot.name {
        let (meant, given) = (&stated.name, &robot.name);
        flaw(format!("the plan is for {meant:?}, the robot is {given:?}"));
    }
    let joints: Vec<&str> = (robot.bodies.iter().skip(1).map(|b| b.joint.as_str())).collect();
    let mut pairs = stated.joint_names.iter().zip(&joints).enumerate();
    if stated.joint_names.len() != joints.len() {
        let (s, r) = (stated.joint_names.len(), joints.len());
        flaw(format!("the plan has {s} joints, the robot {r}"));
    } else if let Some((k, (s, r))) = pairs.find(|(_, (s, r))| s != *r) {
        flaw(format!(
            "joint {k} is {s:?} in the plan, {r:?} in the robot"
        ));
    }
    let mass: f64 = robot.bodies.iter().map(|b| b.mass_kg).sum();
    // A part in a million: the mass is a sum that may be rounded, nothing else.
    if exceeds((stated.mass_kg - mass).abs(), 1e-6 * mass) {
        let meant = stated.mass_kg;
        flaw(format!(
            "the plan's robot weighs {meant} kg, the robot {mass} kg"
        ));
    }
}

/// A plan cannot certify itself by promising nothing.
fn required(plan: &Plan, findings: &mut Findings) {
    let required = &plan.required;
    let mut flaw = |name: &str, value: f64, allowed: String| {
        let note = format!("{value} is not in {allowed}");
        findings.flaw(None, Check::Required, name, note);
    };
    for (name, value) in [
        ("friction_use", required.friction_use),
        ("torque_use", required.torque_use),
    ] {
        if !(value > 0.0 && value <= 1.0) {
            flaw(name, value, "(0, 1]".to_owned());
        }
    }
    let most = TOLERANCES.margin_max;
    for (name, value) in [
        ("joint_rad", required.joint_rad),
        ("clearance_m", required.clearance_m),
        ("self_clearance_m", required.self_clearance_m),
        ("com_m", required.com_m),
    ] {
        if !(0.0..=most).contains(&value) {
            flaw(name, value, format!("[0, {most}]"));
        }
    }
    if !(0.0..=TOLERANCES.edge_sigmas_max).contains(&required.edge_sigmas) {
        let allowed = format!("[0, {}]", TOLERANCES.edge_sigmas_max);
        flaw("edge_sigmas", required.edge_sigmas, allowed);
    }
    let joints = plan.goal.joints.as_ref();
    for (name, tolerance) in [
        ("goal.tolerance_m", plan.goal.tolerance_m),
        (
            "goal.joints.tolerance_rad",
            joints.map_or(0.0, |joints| joints.tolerance_rad),
        ),
    ] {
        if !(0.0..=TOLERANCES.extent_m).contains(&tolerance) {
            flaw(name, tolerance, format!("[0, {}]", TOLERANCES.extent_m));
        }
    }
    let [thinnest, thickest] = TOLERANCES.thin_body_m;
    if !(thinnest..=thickest).contains(&plan.thin_body_m) {
        let allowed = format!("[{thinnest}, {thickest}]");
        flaw("thin_body_m", plan.thin_body_m, allowed);
    }
}

const INSANE: &str = "a coordinate is not finite or out of all proportion";

/// Faces and obstacles are distinct and drawn with finite numbers.
fn environment(plan: &Plan, findings: &mut Findings) {
    let sane = |x: f64| x.is_finite() && x.abs() <= TOLERANCES.extent_m;
    let mut flaw = |subject: &str, note: String| {
        findings.flaw(None, Check::Environment, subject, note);
    };
    if !sane(plan.thin_body_m) {
        flaw("thin_body_m", "is not a thickness".to_owned());
    }
    let mut ids = BTreeSet::new();
    for face in &plan.faces {
        let id = face.id.as_str();
        if !ids.insert(id) {
            flaw(id, "there are two faces of this name".to_owned());
        }
        let pose = &face.X_WF;
        let rings = face.region.rings();
        let mut vertices = rings.iter().flat_map(|ring| &ring.vertices);
        let finite = vertices.all(|v| sane(v.x) && sane(v.y));
        if !(pose.translation.vector.iter().all(|x| sane(*x)) && finite && sane(face.depth_m)) {
            flaw(id, INSANE.to_owned());
        }
        let norm = pose.rotation.coords.norm();
        // Poses of faces are read as unit quaternions.
        if exceeds((norm - 1.0).abs(), TOLERANCES.quaternion) {
            flaw(id, format!("its quaternion has length {norm}"));
        }
        for edge in rings.iter().flat_map(|ring| &ring.edges) {
            if !(edge.further_m >= 0.0 && sane(edge.further_m) && sane(edge.inside_rad)) {
                flaw(id, format!("an edge is off by {} m", edge.further_m));
            }
            if edge.view.is_some_and(|view| view >= face.views.len()) {
                flaw(id, "an edge names a view that is not there".to_owned());
            }
        }
        if let Err(error) = face.validate() {
            flaw(id, error.to_string());
        }
    }
    let mut obstacles = BTreeSet::new();
    for obstacle in &plan.obstacles {
        let id = obstacle.id.as_str();
        if !obstacles.insert(id) {
            flaw(id, "there are two obstacles of this name".to_owned());
        }
        if obstacle.points_W.is_empty() {
            flaw(id, "has no points".to_owned());
        }
        let mut coordinates = obstacle.points_W.iter().flat_map(|p| p.coords.iter());
        if !coordinates.all(|x| sane(*x)) {
            flaw(id, INSANE.to_owned());
        }
    }
}
