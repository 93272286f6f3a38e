//! What actuators and equalities say of joints.

use mujoco_rs::prelude::*;

/// How a joint is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Drive {
    /// By nothing: it gives way.
    None,
    /// By actuators of this force or torque, N or N·m; infinite where none is stated.
    Within(f64),
}

/// How each joint of the model is moved.
///
/// Joints that no actuator names are free to give way only where all actuators name joints: a model without
/// actuators, or with muscles, does not tell.
pub(super) fn drives(model: &MjModel) -> Vec<Drive> {
    let mut efforts: Vec<Option<f64>> = vec![None; model.jnt_type().len()];
    let mut tells = !model.actuator_trntype().is_empty();
    for (k, kind) in model.actuator_trntype().iter().enumerate() {
        let target = model.actuator_trnid()[k][0] as usize;
        let force =
            force(model, k) * model.actuator_gear()[model.actuator_outadr()[k] as usize][0].abs();
        let mut adds = |joint: usize, force: f64| {
            *efforts[joint].get_or_insert(0.0) += force;
        };
        match kind {
            MjtTrn::mjTRN_JOINT | MjtTrn::mjTRN_JOINTINPARENT => adds(target, force),
            MjtTrn::mjTRN_TENDON => {
                let first = model.tendon_adr()[target] as usize;
                for wrap in first..first + model.tendon_num()[target] as usize {
                    match model.wrap_type()[wrap] {
                        MjtWrap::mjWRAP_JOINT => {
                            let joint = model.wrap_objid()[wrap] as usize;
                            adds(joint, force * model.wrap_prm()[wrap].abs());
                        }
                        _ => tells = false,
                    }
                }
            }
            _ => tells = false,
        }
    }
    let of = |(joint, effort): (usize, &Option<f64>)| {
        let most = match model.jnt_actfrclimited()[joint] {
            true => least(&model.jnt_actfrcrange()[joint]),
            false => f64::INFINITY,
        };
        match effort {
            None if tells && leader(model, joint).is_none() => Drive::None,
            None => Drive::Within(most),
            Some(effort) => Drive::Within(effort.min(most)),
        }
    };
    efforts.iter().enumerate().map(of).collect()
}

/// The force that an actuator gives either way, infinite where it has no bound.
fn force(model: &MjModel, actuator: usize) -> f64 {
    let motor = model.actuator_gaintype()[actuator] == MjtGain::mjGAIN_FIXED
        && model.actuator_biastype()[actuator] == MjtBias::mjBIAS_NONE;
    let control = model.actuator_ctrladr()[actuator] as usize;
    let limited = motor && model.actuator_ctrllimited()[control];
    let by_control = match limited {
        true => {
            model.actuator_gainprm()[actuator][0].abs()
                * least(&model.actuator_ctrlrange()[control])
        }
        false => f64::INFINITY,
    };
    let by_force = match model.actuator_forcelimited()[actuator] {
        true => least(&model.actuator_forcerange()[actuator]),
        false => f64::INFINITY,
    };
    by_control.min(by_force)
}

/// What a range holds either way; the one way where the other holds nothing.
fn least(range: &[f64; 2]) -> f64 {
    let [a, b] = range.map(f64::abs);
    if a.min(b) > 0.0 { a.min(b) } else { a.max(b) }
}

/// The joint that an equality has this one follow, as q = multiplier · q_leader + offset where it rests.
///
///   q − q₀ = c₀ + c₁ (q_l − q_l0) + …
pub(super) fn leader(model: &MjModel, joint: usize) -> Option<(usize, f64, f64)> {
    let rest = |joint: usize| model.qpos0()[model.jnt_qposadr()[joint] as usize];
    let ties = model.eq_type().iter().enumerate().filter(|(k, kind)| {
        **kind == MjtEq::mjEQ_JOINT
            && model.eq_active0()[*k]
            && model.eq_obj1id()[*k] == joint as i32
            && model.eq_obj2id()[*k] >= 0
    });
    let tie = ties.map(|(k, _)| k).next()?;
    let leader = model.eq_obj2id()[tie] as usize;
    let [c0, c1] = [model.eq_data()[tie][0], model.eq_data()[tie][1]];
    Some((leader, c1, rest(joint) + c0 - c1 * rest(leader)))
}
