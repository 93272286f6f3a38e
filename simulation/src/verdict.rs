//! What an execution is judged by, and what is said of one that failed.

use robot_model::Robot;

use crate::criteria::{Criterion, Unit};
use crate::monitor::Monitor;
use crate::observed::Peak;

/// Largest deviation of the centre of mass from its reference, m; and at the end.
const COM_ERROR_MAX_M: f64 = 0.020;
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
/// Largest delay after which a contact bears [`CONTACT_N`], s.
pub(crate) const CONTACT_DELAY_S: f64 = 0.3;
/// Force that a contact bears once it is made, N.
pub(crate) const CONTACT_N: f64 = 5.0;

/// Every criterion of an execution.
pub(crate) fn judge(
    robot: &Robot,
    monitor: &Monitor,
    fell_s: Option<f64>,
    simulated_s: f64,
) -> Vec<Criterion> {
    let peaks = &monitor.peaks;
    let mm = Unit::Millimetre;
    let plain = Unit::Plain("");
    let most = |name: &str, peak: &Peak, bound: f64, unit: Unit| {
        Criterion::at_most(name, peak.value, bound, unit).on(peak.detail.clone())
    };
    let at = |patch: usize, t_s: f64| format!("{} of {t_s:.2} s", robot.patches[patch].name);
    let pairs = || monitor.closures().iter().zip(&monitor.observed);
    let slip = pairs().max_by(|a, b| a.1.slip_m.total_cmp(&b.1.slip_m));
    let delay = pairs()
        .filter_map(|(closure, observed)| {
            let due_s = closure.loaded_from_s.filter(|due| *due < simulated_s)?;
            let loaded_s = observed.loaded_s.unwrap_or(closure.end_s.min(simulated_s));
            Some((
                (loaded_s - due_s).max(0.0),
                at(closure.patch, closure.start_s),
            ))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let fallen = f64::from(u8::from(fell_s.is_some()));
    vec![
        Criterion::at_most("falls", fallen, 0.0, plain).on(fell_s.map(|t| format!("at {t:.2} s"))),
        most("com error", &peaks.com_error_m, COM_ERROR_MAX_M, mm),
        Criterion::at_most(
            "com error at the end",
            monitor.com_error_m,
            COM_ERROR_FINAL_MAX_M,
            mm,
        ),
        Criterion::at_most("slip", slip.map_or(0.0, |s| s.1.slip_m), SLIP_MAX_M, mm)
            .on(slip.map(|s| at(s.0.patch, s.0.start_s))),
        most("tilt", &peaks.tilt_rad, TILT_MAX_RAD, Unit::Degree),
        most("swing error", &peaks.swing_error_m, SWING_ERROR_MAX_M, mm),
        most("torque use", &peaks.torque_use, TORQUE_USE_MAX, plain),
        most("penetration", &peaks.penetration_m, PENETRATION_MAX_M, mm),
        Criterion::at_most(
            "unplanned contacts",
            monitor.unplanned.len() as f64,
            0.0,
            plain,
        )
        .on(monitor.unplanned_words()),
        Criterion::at_most(
            "contact delay",
            delay.as_ref().map_or(0.0, |d| d.0),
            CONTACT_DELAY_S,
            Unit::Plain("s"),
        )
        .on(delay.map(|d| d.1)),
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
