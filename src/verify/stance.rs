//! One stance: is what it says whole, is it where it says, does it hold.
#![allow(non_snake_case)]

use nalgebra::{Matrix4, Vector3};
use planner::plan::{Plan, Stance, StanceContact};
use robot_model::{ContactPatch, Robot};
use surfaces::{EdgeKind, Surface};

use super::clearance::{self, Surroundings};
use super::findings::Findings;
use super::forces;
use super::polygon;
use super::posture::{Posture, angle_between, column, inverse_point, point, pose};
use super::{Check, Options, whole};

/// A contact of a stance, with what it refers to and where the posture puts it.
pub(crate) struct Touch<'a> {
    pub stated: &'a StanceContact,
    pub patch: &'a ContactPatch,
    pub surface: &'a Surface,
    /// Pose of the patch frame in W, by the posture; of a ball its centre, with the surface's axes.
    pub X_WC: Matrix4<f64>,
    /// The patch's vertices in W, by the posture; of a ball the point that is nearest to the
    /// surface's plane on the outer side.
    pub vertices_W: Vec<Vector3<f64>>,
}

/// What all stances share.
pub(crate) struct Scene<'a> {
    pub plan: &'a Plan,
    pub robot: &'a Robot,
    pub options: &'a Options,
    pub surroundings: Surroundings,
}

/// Goes through one stance.
pub(crate) fn check(scene: &Scene, index: usize, stance: &Stance, findings: &mut Findings) {
    let at = Some(index);
    if !whole::check(scene, index, stance, findings) {
        return;
    }
    let Some(posture) = Posture::new(scene.robot, &stance.q) else {
        findings.flaw(
            at,
            Check::Numbers,
            "q",
            "the robot has another number of joints",
        );
        return;
    };
    let touches = place(scene, stance, &posture);

    quaternions(scene, index, stance, findings);
    joint_limits(scene, index, stance, findings);
    let com = (Vector3::from(stance.com_W) - posture.com_W).norm();
    findings.value(at, Check::Com, "", com, scene.options.com_m);
    for touch in &touches {
        contact(scene, index, touch, findings);
    }
    let used = forces::check(scene, index, &posture, &touches, findings);
    let nearest = clearance::check(
        scene.plan,
        &posture,
        &touches,
        &scene.surroundings,
        scene.options,
        index,
        findings,
    );
    stated_margins(scene, index, stance, &used, &nearest, findings);
}

/// The contacts with what they refer to, which [`whole::check`] has found to exist.
fn place<'a>(scene: &Scene<'a>, stance: &'a Stance, posture: &Posture) -> Vec<Touch<'a>> {
    let (plan, robot) = (scene.plan, scene.robot);
    stance
        .contacts
        .iter()
        .filter_map(|stated| {
            let patch = robot.patches.iter().find(|p| p.name == stated.patch)?;
            let surface = plan.surfaces.iter().find(|s| s.id == stated.surface)?;
            let mut X_WC = posture.X_WB.get(patch.body)? * patch.X_BC.to_homogeneous();
            let radius = patch.point_radius_m();
            if radius.is_some() {
                let axes = surface.X_WS.rotation.to_rotation_matrix();
                X_WC.fixed_view_mut::<3, 3>(0, 0).copy_from(axes.matrix());
            }
            let below = -radius.unwrap_or(0.0);
            let vertices_W = patch
                .polygon
                .iter()
                .map(|v| point(&X_WC, &Vector3::new(v.x, v.y, below)))
                .collect();
            Some(Touch {
                stated,
                patch,
                surface,
                X_WC,
                vertices_W,
            })
        })
        .collect()
}

fn quaternions(scene: &Scene, index: usize, stance: &Stance, findings: &mut Findings) {
    let mut add = |subject: &str, q: &[f64]| {
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (check, most) = (Check::Quaternion, scene.options.quaternion);
        findings.value(Some(index), check, subject, (norm - 1.0).abs(), most);
    };
    if let Some(quaternion) = stance.q.get(3..7) {
        add("base", quaternion);
    }
    for contact in &stance.contacts {
        add(&contact.patch, &contact.X_WC.quat_xyzw);
    }
}

/// The joint that is nearest to a limit, and every one that is too near.
fn joint_limits(scene: &Scene, index: usize, stance: &Stance, findings: &mut Findings) {
    let bound = scene.plan.required.joint_rad - scene.options.joint_rad;
    let joints = stance.q.get(7..).unwrap_or_default();
    let distances: Vec<(f64, &str)> = scene
        .robot
        .bodies
        .iter()
        .skip(1)
        .zip(joints)
        .map(|(body, q)| ((q - body.lower).min(body.upper - q), body.joint.as_str()))
        .collect();
    let nearest = distances.iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let too_near = distances.iter().filter(|(d, _)| *d < bound);
    let rows: Vec<_> = too_near
        .chain(nearest.filter(|(d, _)| *d >= bound))
        .collect();
    for (distance, joint) in rows {
        findings.value(Some(index), Check::JointLimit, *joint, *distance, bound);
    }
}

/// Where one contact is, on its surface and in the file.
fn contact(scene: &Scene, index: usize, touch: &Touch, findings: &mut Findings) {
    let (at, options) = (Some(index), scene.options);
    let name = &touch.stated.patch;
    let X_WS = touch.surface.X_WS.to_homogeneous();

    // Stated and real pose, stated and real vertices.
    let X_stated = pose(&touch.stated.X_WC.p, &touch.stated.X_WC.quat_xyzw);
    let mut off = (column(&X_stated, 3) - column(&touch.X_WC, 3)).norm();
    for (stated, real) in touch.stated.vertices_W.iter().zip(&touch.vertices_W) {
        off = off.max((Vector3::from(*stated) - real).norm());
    }
    findings.value(at, Check::Pose, name, off, options.closure_m);
    let turned = angle_between(&X_stated, &touch.X_WC);
    if turned > options.pose_rad {
        let most = options.pose_rad;
        findings.flaw(
            at,
            Check::Pose,
            name,
            format!("turned by {turned:.4} rad, {most} allowed"),
        );
    }

    // Plane, normal, polygon.
    let in_surface: Vec<Vector3<f64>> = touch
        .vertices_W
        .iter()
        .map(|p| inverse_point(&X_WS, p))
        .collect();
    let height = in_surface.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
    findings.value(at, Check::Closure, name, height, options.closure_m);
    // A ball may be turned as it likes.
    if touch.patch.point_radius_m().is_none() {
        let (z_C, z_S) = (column(&touch.X_WC, 2), column(&X_WS, 2));
        let angle = z_C.cross(&z_S).norm().atan2(z_C.dot(&z_S));
        findings.value(at, Check::Normal, name, angle, options.normal_rad);
    }
    let polygon: Vec<[f64; 2]> = touch
        .surface
        .polygon
        .vertices()
        .iter()
        .map(|v| [v.x, v.y])
        .collect();
    let insets_m = insets(touch.surface);
    let out = in_surface
        .iter()
        .map(|p| polygon::outside_inset(&polygon, &insets_m, [p.x, p.y]))
        .fold(f64::NEG_INFINITY, f64::max);
    let inside = -out;
    findings.value(at, Check::Inclusion, name, inside, -options.inclusion_m);
}

/// How far each edge of a surface's polygon is taken back, m: what the file says of it, else the one
/// inset of all, but never seams.
fn insets(surface: &Surface) -> Vec<f64> {
    let edges = surface.polygon.vertices().len();
    let one = |l: usize| {
        let seam = surface.polygon_edges.get(l) == Some(&EdgeKind::Seam);
        let own = surface.edge_insets_m.get(l).copied();
        own.unwrap_or(if seam { 0.0 } else { surface.inset_m })
    };
    (0..edges).map(one).collect()
}

/// The parts of friction and torque that the stated forces use.
pub(crate) struct Used {
    pub friction: f64,
    pub torque: f64,
}

/// The plan may not say that its margins are better than they are.
fn stated_margins(
    scene: &Scene,
    index: usize,
    stance: &Stance,
    used: &Used,
    nearest: &clearance::Nearest,
    findings: &mut Findings,
) {
    let stated = &stance.margins;
    let joints = stance.q.get(7..).unwrap_or_default();
    let joint = scene
        .robot
        .bodies
        .iter()
        .skip(1)
        .zip(joints)
        .map(|(body, q)| (q - body.lower).min(body.upper - q))
        .fold(f64::INFINITY, f64::min);
    // How much better than found, for each.
    let better = [
        ("friction_use", used.friction - stated.friction_use),
        ("torque_use", used.torque - stated.torque_use),
        ("joint_rad", stated.joint_rad - joint),
        (
            "clearance_m",
            stated.clearance_m.map_or(0.0, |s| s - nearest.environment),
        ),
        (
            "self_clearance_m",
            stated.self_clearance_m.map_or(0.0, |s| s - nearest.own),
        ),
    ];
    let worst = better
        .into_iter()
        .max_by(|a, b| a.1.is_nan().cmp(&b.1.is_nan()).then(a.1.total_cmp(&b.1)));
    if let Some((margin, value)) = worst {
        let most = scene.options.stated;
        findings.value(Some(index), Check::StatedMargin, margin, value, most);
    }
}
