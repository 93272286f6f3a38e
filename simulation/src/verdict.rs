//! What an execution is judged by, and what is said of one that failed.

use robot_model::{GRAVITY_M_S2, Robot};

use crate::criteria::{Criterion, Unit};
use crate::monitor::Monitor;
use crate::schedule::Closure;

/// Largest deviation of the centre of mass from its reference, m: half of what plans keep to the edge of
/// support, where the robot is pushed all of it; and at the end.
const COM_ERROR_MAX_M: f64 = 0.020;
const COM_ERROR_PUSHED_MAX_M: f64 = 0.040;
pub(crate) const COM_ERROR_FINAL_MAX_M: f64 = 0.010;
/// Largest slip of a contact, m.
const SLIP_MAX_M: f64 = 0.010;
/// Largest deviation of the base's orientation, rad.
pub(crate) const TILT_MAX_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Largest deviation of a patch in the air from its reference, m.
const SWING_ERROR_MAX_M: f64 = 0.020;
/// Largest use of the torque limits.
const TORQUE_USE_MAX: f64 = 0.95;
/// Deepest penetration, m.
pub(crate) const PENETRATION_MAX_M: f64 = 0.001;
/// Largest delay after which a contact bears [`contact_n`], s.
pub(crate) const CONTACT_DELAY_S: f64 = 0.3;

/// Force that a contact bears once it is made, N: a hundredth of the robot's weight, 5 N at most. Six feet of a
/// robot of 4 kg bear 6 N each.
pub(crate) fn contact_n(robot: &Robot) -> f64 {
    (0.01 * robot.mass_kg * GRAVITY_M_S2).min(5.0)
}

/// Every criterion of an execution.
pub(crate) fn judge(
    robot: &Robot,
    monitor: &Monitor,
    pushed: bool,
    fell_s: Option<f64>,
    dt_s: f64,
) -> Vec<Criterion> {
    let peaks = &monitor.peaks;
    let mm = Unit::Millimetre;
    let plain = Unit::Plain("");
    let at = |c: &Closure| format!("{} of {:.2} s", robot.patches[c.patch].name, c.start_s);
    // In the simulation's time, in which a reference that waits makes nothing less late.
    let latest = monitor
        .pairs()
        .max_by_key(|(_, observed)| observed.late_steps);
    let delay_s = latest.map_or(0.0, |(_, observed)| observed.late_steps as f64 * dt_s);
    let delayed = latest
        .filter(|_| delay_s > 0.0)
        .map(|(closure, _)| at(closure));
    let second = Unit::Plain("s");
    let (com_end, com_end_max) = (monitor.com_error_m, COM_ERROR_FINAL_MAX_M);
    let com_max = [COM_ERROR_MAX_M, COM_ERROR_PUSHED_MAX_M][usize::from(pushed)];
    let fallen = f64::from(u8::from(fell_s.is_some()));
    vec![
        Criterion::at_most("falls", fallen, 0.0, plain).on(fell_s.map(|t| format!("at {t:.2} s"))),
        peaks.com_error_m.at_most("com error", com_max, mm),
        Criterion::at_most("com error at the end", com_end, com_end_max, mm),
        monitor.slip(SLIP_MAX_M, at),
        peaks.tilt_rad.at_most("tilt", TILT_MAX_RAD, Unit::Degree),
        peaks
            .swing_error_m
            .at_most("swing error", SWING_ERROR_MAX_M, mm),
        peaks
            .torque_use
            .at_most("torque use", TORQUE_USE_MAX, plain),
        peaks
            .penetration_m
            .at_most("penetration", PENETRATION_MAX_M, mm),
        monitor.none_unplanned(),
        Criterion::at_most("contact delay", delay_s, CONTACT_DELAY_S, second).on(delayed),
    ]
}

/// What to say of a run that failed: a fall says less than what led to it.
pub(crate) fn cause(criteria: &[Criterion], fell_s: Option<f64>) -> Option<String> {
    let failed: Vec<&Criterion> = criteria.iter().filter(|c| !c.pass).collect();
    let first = failed
        .iter()
        .find(|c| c.name == "unplanned contacts")
        .or_else(|| failed.first())?;
    let place = first.detail.clone().unwrap_or_default();
    Some(match fell_s {
        Some(t) if first.name != "falls" => format!("fell at {t:.2} s; {}: {place}", first.name),
        Some(t) => format!("fell at {t:.2} s"),
        None => format!("{}: {:.3} {} {place}", first.name, first.value, first.unit),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hexapod of 3.7 kg that stands on six feet stands on all of them.
    #[test]
    fn what_a_light_robot_bears_counts() {
        let mut robot = scenes::robot("hexapod").unwrap();
        assert_eq!(contact_n(&robot), 5.0);
        robot.mass_kg = 3.7;
        let each_n = robot.mass_kg * GRAVITY_M_S2 / 6.0;
        assert!(contact_n(&robot) < 0.1 * each_n);
    }
}
