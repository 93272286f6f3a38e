//! The plan as a whole: its format, robot, promises and environment.

use std::collections::BTreeSet;

use planner::plan::{Change, PLAN_FORMAT, Plan};
use robot_model::Robot;

use super::findings::{Findings, exceeds};
use super::{Check, Options};

/// Everything that concerns no single stance; whether the stances can be looked at.
pub(crate) fn check(
    plan: &Plan,
    robot: &Robot,
    options: &Options,
    findings: &mut Findings,
) -> bool {
    if plan.format != PLAN_FORMAT {
        let note = format!("{:?}, {PLAN_FORMAT:?} is read here", plan.format);
        findings.flaw(None, Check::Format, "", note);
    }
    same_robot(plan, robot, findings);
    required(plan, options, findings);
    environment(plan, options, findings);
    let sets = plan
        .stances
        .iter()
        .filter(|s| s.change != Change::Goal)
        .count();
    if plan.search.path_stances != sets {
        let note = format!("{} stated, the plan has {sets}", plan.search.path_stances);
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
        flaw(format!(
            "the plan is for {:?}, the robot is {:?}",
            stated.name, robot.name
        ));
    }
    let joints: Vec<&str> = robot
        .bodies
        .iter()
        .skip(1)
        .map(|b| b.joint.as_str())
        .collect();
    if stated.joint_names.len() != joints.len() {
        let (s, r) = (stated.joint_names.len(), joints.len());
        flaw(format!("the plan has {s} joints, the robot {r}"));
    } else if let Some((k, (s, r))) = stated
        .joint_names
        .iter()
        .zip(&joints)
        .enumerate()
        .find(|(_, (s, r))| s != *r)
    {
        flaw(format!(
            "joint {k} is {s:?} in the plan, {r:?} in the robot"
        ));
    }
    let mass: f64 = robot.bodies.iter().map(|b| b.mass_kg).sum();
    // A part in a million: the mass is a sum that may be rounded, nothing else.
    if exceeds((stated.mass_kg - mass).abs(), 1e-6 * mass) {
        flaw(format!(
            "the plan's robot weighs {} kg, the robot {mass} kg",
            stated.mass_kg
        ));
    }
}

/// A plan cannot certify itself by promising nothing.
fn required(plan: &Plan, options: &Options, findings: &mut Findings) {
    let required = &plan.required;
    let mut flaw = |name: &str, value: f64, allowed: String| {
        findings.flaw(
            None,
            Check::Required,
            name,
            format!("{value} is not in {allowed}"),
        );
    };
    for (name, value) in [
        ("friction_use", required.friction_use),
        ("torque_use", required.torque_use),
    ] {
        if !(value > 0.0 && value <= 1.0) {
            flaw(name, value, "(0, 1]".to_owned());
        }
    }
    let most = options.margin_max;
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
    let [thinnest, thickest] = options.thin_body_m;
    if !(thinnest..=thickest).contains(&plan.thin_body_m) {
        flaw(
            "thin_body_m",
            plan.thin_body_m,
            format!("[{thinnest}, {thickest}]"),
        );
    }
}

/// Surfaces and obstacles are distinct and drawn with finite numbers.
fn environment(plan: &Plan, options: &Options, findings: &mut Findings) {
    let sane = |x: f64| x.is_finite() && x.abs() <= options.extent_m;
    let mut flaw = |subject: &str, note: String| {
        findings.flaw(None, Check::Environment, subject, note);
    };
    if !sane(plan.thin_body_m) {
        flaw("thin_body_m", "is not a thickness".to_owned());
    }
    let mut ids = BTreeSet::new();
    for surface in &plan.surfaces {
        let id = surface.id.as_str();
        if !ids.insert(id) {
            flaw(id, "there are two surfaces of this name".to_owned());
        }
        let pose = &surface.X_WS;
        let mut vertices = surface.polygon.vertices().iter().flat_map(|v| [v.x, v.y]);
        if !(pose.translation.vector.iter().all(|x| sane(*x)) && vertices.all(sane)) {
            flaw(
                id,
                "a coordinate is not finite or out of all proportion".to_owned(),
            );
        }
        let norm = pose.rotation.coords.norm();
        // Poses of surfaces are read as unit quaternions.
        if exceeds((norm - 1.0).abs(), options.quaternion) {
            flaw(id, format!("its quaternion has length {norm}"));
        }
        if !(surface.inset_m >= 0.0 && sane(surface.inset_m)) {
            flaw(id, format!("its inset is {} m", surface.inset_m));
        }
        let edges = surface.polygon.vertices().len();
        let counts = [surface.edge_insets_m.len(), surface.polygon_edges.len()];
        if counts.iter().any(|count| ![0, edges].contains(count)) {
            flaw(
                id,
                format!("it has {counts:?} insets and kinds for {edges} edges"),
            );
        }
        if let Some(inset) = surface
            .edge_insets_m
            .iter()
            .find(|m| !(**m >= 0.0 && sane(**m)))
        {
            flaw(id, format!("the inset of an edge is {inset} m"));
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
        if !obstacle
            .points_W
            .iter()
            .flat_map(|p| p.coords.iter())
            .all(|x| sane(*x))
        {
            flaw(
                id,
                "a coordinate is not finite or out of all proportion".to_owned(),
            );
        }
    }
}
