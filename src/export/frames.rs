//! Poses and offsets as controllers write them.

use anyhow::{Context, Result, ensure};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use plan::{Contact, Motion, Plan, Pose, Stance};
use robot_model::Robot;

/// A plan's pose as an isometry.
pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let rotation = UnitQuaternion::new_normalize(pose.quat_xyzw.into());
    Isometry3::from_parts(pose.p.into(), rotation)
}

/// Pose of the base in a stance.
///
/// # Errors  a posture that is too short.
pub(super) fn base(stance: &Stance) -> Result<Isometry3<f64>> {
    let [x, y, z, qx, qy, qz, qw, ..] = *stance.q.as_slice() else {
        anyhow::bail!("stance {}: q has no base", stance.index);
    };
    Ok(isometry(&Pose {
        p: [x, y, z],
        quat_xyzw: [qx, qy, qz, qw],
    }))
}

/// Roll, pitch and yaw of a rotation, rad:
///
///   R = R_z(yaw) · R_y(pitch) · R_x(roll)
///
/// Where the pitch is ±90° only yaw ∓ roll is determined; the roll is zero then.
pub(super) fn roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let R = rotation.to_rotation_matrix();
    let up = R[(2, 1)].hypot(R[(2, 2)]);
    let pitch = (-R[(2, 0)]).atan2(up);
    // Nearer than this to the pole, roll and yaw are rounding.
    if up < 1e-9 {
        return [0.0, pitch, (-R[(0, 1)]).atan2(R[(1, 1)])];
    }
    let (roll, yaw) = (R[(2, 1)].atan2(R[(2, 2)]), R[(1, 0)].atan2(R[(0, 0)]));
    [roll, pitch, yaw]
}

/// Micrometres and microradians: postures are solved to ten of them, and more digits only make
/// files long.
pub(super) fn rounded(value: f64) -> f64 {
    let value = (value * 1e6).round() / 1e6;
    if value == 0.0 { 0.0 } else { value }
}

/// The contact of a patch in a stance.
///
/// # Errors  no such stance or contact.
pub(super) fn contact<'a>(plan: &'a Plan, stance: usize, patch: &str) -> Result<&'a Contact> {
    let contacts = plan.stances.get(stance).map(|s| &s.contacts);
    contacts
        .and_then(|contacts| contacts.iter().find(|c| c.patch == patch))
        .with_context(|| format!("stance {stance} lists no contact of {patch}"))
}

/// Refuses a plan that cannot be written: another robot's, or with values that are no numbers.
///
/// # Errors  the stance and what is wrong with it.
pub(super) fn check(plan: &Plan, robot: &Robot) -> Result<()> {
    let (meant, given) = (&plan.robot.name, &robot.name);
    let mut joints = plan.robot.joint_names.iter().map(String::as_str);
    let same = joints.by_ref().eq(robot.joint_names());
    ensure!(
        same,
        "the plan is for {meant}, whose joints are not those of {given}"
    );
    ensure!(!plan.stances.is_empty(), "the plan has no stances");
    for stance in &plan.stances {
        let index = stance.index;
        let (values, wanted) = (stance.q.len(), 7 + robot.nj());
        ensure!(
            values == wanted,
            "stance {index}: q has {values} values, {given} has {wanted}"
        );
        for contact in &stance.contacts {
            let patch = robot.patch(&contact.patch);
            let patch = &patch.with_context(|| format!("stance {index}"))?.name;
            let (points, forces) = (contact.force_points_W.len(), contact.forces_W.len());
            ensure!(
                points == forces,
                "stance {index}, {patch}: {forces} forces at {points} points"
            );
        }
        let vectors = stance.contacts.iter().flat_map(|c| {
            let vectors = c.force_points_W.iter().chain(&c.forces_W);
            let vectors = vectors.chain([&c.X_WC.p]).flatten();
            vectors.chain(&c.X_WC.quat_xyzw).chain([&c.friction])
        });
        let mut all = stance.q.iter().chain(&stance.com_W).chain(vectors);
        let finite = all.all(|x| x.is_finite());
        ensure!(finite, "stance {index} holds a value that is not finite");
        let quaternions = stance.contacts.iter().map(|c| c.X_WC.quat_xyzw);
        let base = [stance.q[3], stance.q[4], stance.q[5], stance.q[6]];
        for q in quaternions.chain([base]) {
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            ensure!(
                (length - 1.0).abs() < 1e-3,
                "stance {index}: a quaternion of length {length}"
            );
        }
    }
    Ok(())
}

/// Total force (N) and moment (N·m) of a contact about its frame's origin, in W.
pub(super) fn wrench(contact: &Contact) -> [f64; 6] {
    let origin = Vector3::from(contact.X_WC.p);
    let mut force = Vector3::zeros();
    let mut moment = Vector3::zeros();
    for (p, f) in contact.force_points_W.iter().zip(&contact.forces_W) {
        let f = Vector3::from(*f);
        force += f;
        moment += (Vector3::from(*p) - origin).cross(&f);
    }
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

/// Refuses a motion that contradicts itself or is another robot's.
///
/// # Errors  what is wrong with it.
pub(super) fn check_motion(motion: &Motion, robot: &Robot) -> Result<()> {
    motion.validate()?;
    let wanted = 7 + robot.nj();
    let given = motion.samples.iter().map(|s| s.q.len());
    if let Some(given) = given.into_iter().find(|given| *given != wanted) {
        let robot = &robot.name;
        anyhow::bail!("the motion has {given} coordinates, {robot} has {wanted}");
    }
    Ok(())
}

/// Force and moment about its frame's origin of every patch of the robot at every sample, in W, one after the
/// other; NaN where the patch is in the air.
pub(super) fn wrenches(motion: &Motion, robot: &Robot) -> impl Iterator<Item = f64> {
    motion.samples.iter().flat_map(move |sample| {
        let phase = motion.phase_at(sample.t_s).map(|i| &motion.phases[i]);
        let contacts = phase.map_or(&[][..], |phase| &phase.contacts);
        robot.patches.iter().flat_map(move |patch| {
            let at = contacts.iter().position(|c| c.patch == patch.name);
            at.map_or([f64::NAN; 6], |i| {
                wrench(&Contact {
                    forces_W: sample.forces_W[i].clone(),
                    ..contacts[i].clone()
                })
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn roll_pitch_yaw_turn_back_into_the_rotation(turn in prop::array::uniform3(-3.2..3.2)) {
            let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
            let [roll, pitch, yaw] = roll_pitch_yaw(&rotation);
            let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)
                * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch)
                * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll);
            prop_assert!(back.angle_to(&rotation) < 1e-7);
        }
    }

    #[test]
    fn the_pole_has_no_roll() {
        let half = std::f64::consts::FRAC_PI_2;
        for pitch in [half, -half] {
            let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4)
                * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch);
            let [roll, p, yaw] = roll_pitch_yaw(&rotation);
            assert!(roll.abs() < 1e-7 && (p - pitch).abs() < 1e-7 && (yaw - 0.4).abs() < 1e-7);
        }
    }
}
