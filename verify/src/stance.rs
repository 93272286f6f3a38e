//! One stance: is what it says whole, is it where it says, does it hold.

use nalgebra::Vector3;
use plan::{Contact, Stance};
use robot_model::Body;

use crate::clearance::{self, Nearest};
use crate::findings::Findings;
use crate::forces::{self, Used};
use crate::posture::{Posture, angle_between, column, inverse_point, point, pose};
use crate::region;
use crate::rolling;
use crate::scene::{Placed, Scene, Touch};
use crate::{Check, TOLERANCES, well_formed};

/// Goes through one stance.
pub(crate) fn check(scene: &Scene, index: usize, stance: &Stance, findings: &mut Findings) {
    let at = Some(index);
    if !well_formed::check(scene, index, stance, findings) {
        return;
    }
    let Some(posture) = Posture::new(scene.robot, &stance.q) else {
        let note = "the robot has another number of joints";
        findings.flaw(at, Check::Numbers, "q", note);
        return;
    };
    let placed = Placed {
        touches: place(scene, stance, &posture),
        scene,
        at,
        stance,
        posture,
    };
    placed.quaternions(findings);
    placed.joint_limits(findings);
    let com = (Vector3::from(stance.com_W) - placed.posture.com_W).norm();
    findings.value(at, Check::Com, "", com, TOLERANCES.com_m);
    let mut inside = f64::NEG_INFINITY;
    for touch in &placed.touches {
        inside = inside.max(placed.contact(touch, findings));
    }
    let used = forces::check(&placed, findings);
    let nearest = clearance::check(&placed, findings);
    placed.stated_margins(&used, &nearest, inside, findings);
}

/// The contacts with what they refer to, which [`well_formed::check`] has found to exist.
fn place<'a>(scene: &Scene<'a>, stance: &'a Stance, posture: &Posture) -> Vec<Touch<'a>> {
    let touch = |stated: &'a Contact| {
        let (patch, face) = scene.named(stated)?;
        let mut X_WC = posture.X_WB.get(patch.body)? * patch.X_BC.to_homogeneous();
        let radius = patch.point_radius_m();
        if radius.is_some() {
            let axes = face.X_WF.rotation.to_rotation_matrix();
            X_WC.fixed_view_mut::<3, 3>(0, 0).copy_from(axes.matrix());
        }
        let below = -radius.unwrap_or(0.0);
        let vertices = patch.polygon.iter();
        let vertices = vertices.map(|v| point(&X_WC, &Vector3::new(v.x, v.y, below)));
        Some(Touch {
            stated,
            patch,
            face,
            vertices_W: vertices.collect(),
            X_WC,
        })
    };
    stance.contacts.iter().filter_map(touch).collect()
}

impl Placed<'_> {
    fn quaternions(&self, findings: &mut Findings) {
        let mut add = |subject: &str, q: &[f64]| {
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            let (check, most) = (Check::Quaternion, TOLERANCES.quaternion);
            findings.value(self.at, check, subject, (norm - 1.0).abs(), most);
        };
        if let Some(quaternion) = self.stance.q.get(3..7) {
            add("base", quaternion);
        }
        for contact in &self.stance.contacts {
            add(&contact.patch, &contact.X_WC.quat_xyzw);
            if let Some(from) = &contact.rolls_from {
                add(&contact.patch, &from.quat_xyzw);
            }
        }
    }

    /// The joint that is nearest to its margin, and every one that is inside of it.
    fn joint_limits(&self, findings: &mut Findings) {
        let slack = TOLERANCES.joint_rad;
        let bound = |body: &Body| body.kept_margin(self.scene.plan.required.joint_rad) - slack;
        let over = |(distance, body): &(f64, &Body)| distance - bound(body);
        let distances: Vec<(f64, &Body)> = self.to_limits().collect();
        let nearest = distances.iter().min_by(|a, b| over(a).total_cmp(&over(b)));
        let too_near = distances.iter().filter(|d| over(d) < 0.0);
        for (distance, body) in too_near.chain(nearest.filter(|d| over(d) >= 0.0)) {
            findings.value(
                self.at,
                Check::JointLimit,
                &body.joint,
                *distance,
                bound(body),
            );
        }
    }

    /// How far each joint is from its nearer limit, and the body that it moves.
    fn to_limits(&self) -> impl Iterator<Item = (f64, &Body)> {
        let joints = self.stance.q.get(7..).unwrap_or_default();
        let bodies = self.scene.robot.bodies.iter().skip(1).zip(joints);
        bodies.map(|(body, q)| ((q - body.lower).min(body.upper - q), body))
    }

    /// Where one contact is, on its face and in the file; how far it is inside the face, m.
    fn contact(&self, touch: &Touch, findings: &mut Findings) -> f64 {
        let at = self.at;
        let name = &touch.stated.patch;
        let X_WF = touch.face.X_WF.to_homogeneous();

        // Stated and real pose, stated and real vertices.
        let X_stated = pose(&touch.stated.X_WC.p, &touch.stated.X_WC.quat_xyzw);
        let mut off = (column(&X_stated, 3) - column(&touch.X_WC, 3)).norm();
        for (stated, real) in touch.stated.vertices_W.iter().zip(&touch.vertices_W) {
            off = off.max((Vector3::from(*stated) - real).norm());
        }
        findings.value(at, Check::Pose, name, off, TOLERANCES.closure_m);
        let turned = angle_between(&X_stated, &touch.X_WC);
        if turned > TOLERANCES.pose_rad {
            let note = format!("turned by {turned:.4} rad, {} allowed", TOLERANCES.pose_rad);
            findings.flaw(at, Check::Pose, name, note);
        }

        // Plane, normal, polygon.
        let in_face = touch.vertices_W.iter().map(|p| inverse_point(&X_WF, p));
        let in_face: Vec<Vector3<f64>> = in_face.collect();
        let height = in_face.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
        findings.value(at, Check::Closure, name, height, TOLERANCES.closure_m);
        // A ball may be turned as it likes.
        if touch.patch.point_radius_m().is_none() {
            let (z_C, z_F) = (column(&touch.X_WC, 2), column(&X_WF, 2));
            let angle = z_C.cross(&z_F).norm().atan2(z_C.dot(&z_F));
            findings.value(at, Check::Normal, name, angle, TOLERANCES.normal_rad);
        }
        // A ball that rolls is where its link's turning has brought it; a sole that is said to roll is nowhere.
        if touch.stated.rolls_from.is_some() {
            let X_WB = &self.posture.X_WB[touch.patch.body];
            let centre_W = rolling::centre_W(touch.stated, touch.patch, touch.face, X_WB);
            let off = centre_W.map_or(f64::NAN, |p| (p - column(&touch.X_WC, 3)).norm());
            findings.value(at, Check::Kept, name, off, TOLERANCES.closure_m);
        }
        let patch: Vec<_> = in_face.iter().map(|p| p.xy()).collect();
        let inside = region::inside_m(touch.face, self.scene.plan.required.edge_sigmas, &patch);
        findings.value(at, Check::Inclusion, name, inside, -TOLERANCES.inclusion_m);
        inside
    }

    /// Margins that follow from posture and forces alone are as the plan says. Distances may be better than
    /// stated, as the bodies that they were measured from may be larger, but not worse; and no plan states
    /// less than it promises.
    fn stated_margins(&self, used: &Used, nearest: &Nearest, inside: f64, findings: &mut Findings) {
        let stated = &self.stance.margins;
        let required = &self.scene.plan.required;
        let joints = self.to_limits().map(|(distance, _)| distance);
        let joint = joints.fold(f64::INFINITY, f64::min);
        // By how much what is stated is off, and how much of that is arithmetic, for each.
        let off = |stated: f64, found: f64| (stated - found).abs();
        let distance = |stated: Option<f64>, found: f64, promised: f64| {
            stated.map_or(0.0, |stated| (stated - found).max(promised - stated))
        };
        let (clearance, own) = (required.clearance_m, required.self_clearance_m);
        let off = [
            (
                "friction_use",
                off(stated.friction_use, used.friction),
                TOLERANCES.part,
            ),
            (
                "torque_use",
                off(stated.torque_use, used.torque),
                TOLERANCES.part,
            ),
            (
                "joint_rad",
                off(stated.joint_rad, joint),
                TOLERANCES.joint_rad,
            ),
            (
                "equilibrium",
                off(stated.equilibrium, used.residual),
                TOLERANCES.force,
            ),
            (
                "closure_m",
                off(stated.closure_m, self.apart_m()),
                TOLERANCES.closure_m,
            ),
            (
                "clearance_m",
                distance(stated.clearance_m, nearest.environment, clearance),
                TOLERANCES.distance_m,
            ),
            (
                "self_clearance_m",
                distance(stated.self_clearance_m, nearest.own, own),
                TOLERANCES.distance_m,
            ),
            // Of the contact that is placed: none is farther inside than that of all contacts.
            (
                "inclusion_m",
                distance(stated.inclusion_m, inside, 0.0),
                TOLERANCES.inclusion_m,
            ),
        ];
        let over = |(_, value, most): &(&str, f64, f64)| value - most;
        let worst = off.into_iter().max_by(|a, b| {
            let nan = a.1.is_nan().cmp(&b.1.is_nan());
            nan.then(over(a).total_cmp(&over(b)))
        });
        if let Some((margin, value, most)) = worst {
            findings.value(self.at, Check::StatedMargin, margin, value, most);
        }
    }

    /// The largest distance of a patch's vertex from its face's plane, m.
    fn apart_m(&self) -> f64 {
        let of = |touch: &Touch| {
            let X_WF = touch.face.X_WF.to_homogeneous();
            let heights = touch
                .vertices_W
                .iter()
                .map(|p| inverse_point(&X_WF, p).z.abs());
            heights.fold(0.0, f64::max)
        };
        self.touches.iter().map(of).fold(0.0, f64::max)
    }
}
