//! One row a sample of the motion, for plots and for players of joint trajectories.

use std::fmt::Write as _;

use anyhow::Result;
use plan::Motion;
use robot_model::Robot;

use super::frames;

/// The motion as a table: time, what the phase does and which patch swings, centre of mass, q, v, a, τ
/// (v and a of the base in W), and for every patch the force and the moment about its origin that it
/// bears (N, N·m, in W); empty where it is in the air.
///
/// # Errors
/// A motion that contradicts itself or is another robot's.
pub(super) fn write(motion: &Motion, robot: &Robot) -> Result<String> {
    frames::check_motion(motion, robot)?;
    let base = "base_x_m,base_y_m,base_z_m,base_qx,base_qy,base_qz,base_qw";
    let mut text = format!("time_s,phase,swing,com_x_m,com_y_m,com_z_m,{base}");
    for joint in robot.joint_names() {
        let _ = write!(text, ",{joint}");
    }
    for rate in ["v", "a"] {
        for base in ["x", "y", "z", "rx", "ry", "rz"] {
            let _ = write!(text, ",base_{rate}{base}");
        }
        for joint in robot.joint_names() {
            let _ = write!(text, ",{joint}_{rate}");
        }
    }
    for joint in robot.joint_names() {
        let _ = write!(text, ",{joint}_tau_Nm");
    }
    for patch in &robot.patches {
        for part in ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"] {
            let _ = write!(text, ",{}_{part}", patch.name);
        }
    }
    text.push('\n');
    let mut wrenches = frames::wrenches(motion, robot);
    for sample in &motion.samples {
        let Some(phase) = motion.phase_at(sample.t_s).map(|i| &motion.phases[i]) else {
            continue;
        };
        let kind = serde_json::to_value(phase.kind)?;
        let kind = kind.as_str().unwrap_or("");
        let swing = phase.swing.as_deref().unwrap_or("");
        let _ = write!(text, "{:.4},{kind},{swing}", sample.t_s);
        let rates = sample.v.iter().chain(&sample.a).chain(&sample.tau);
        for x in sample.com_W.iter().chain(&sample.q).chain(rates) {
            let _ = write!(text, ",{x:.9}");
        }
        for x in wrenches.by_ref().take(6 * robot.patches.len()) {
            if x.is_nan() {
                text.push(',');
            } else {
                let _ = write!(text, ",{x:.6}");
            }
        }
        text.push('\n');
    }
    Ok(text)
}
