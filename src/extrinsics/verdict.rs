//! What is to be thought of a mount that was found.

use calibration::camera::{Checked, SensorModel};

use super::identify::Measured;

/// Residuals that are so many times the stated noise are not explained by it.
const NOISE_MAX: f64 = 2.0;

/// In words: the doubts, none where the mount is to be trusted.
pub fn doubts(checked: &Checked, measured: &[Measured]) -> Vec<String> {
    let mut doubts = Vec::new();
    let name = |i: &usize| measured.get(*i).map_or("?", |one| one.frame.as_str());
    if let Some([a, b]) = &checked.swapped {
        let (a, b) = (name(a), name(b));
        doubts.push(format!(
            "the frames {a} and {b} are swapped: both fit in each other's row"
        ));
    }
    if !checked.left_out.is_empty() {
        let names: Vec<&str> = checked.left_out.iter().map(name).collect();
        let (count, names) = (names.len(), names.join(", "));
        doubts.push(format!(
            "{count} of {} stances disagree with the others by far and are left out: {names}",
            measured.len()
        ));
    }
    if checked.sensor.is_wrong() {
        doubts.push(sensor(&checked.sensor, measured));
    } else if checked.found.noise_factor > NOISE_MAX {
        doubts.push(format!(
            "residuals are {:.1} times the stated noise, and neither units, order, signs nor the \
             sensor's model explain it: the poses of the robot may be noisier than \
             calibration.camera.robot_tilt_sigma_rad and robot_height_sigma_m say, or the ground not flat",
            checked.found.noise_factor
        ));
    }
    doubts
}

/// What is wrong with the sensor's model.
fn sensor(model: &SensorModel, measured: &[Measured]) -> String {
    let view = measured.first().and_then(|one| one.view.as_ref());
    let [a, b, c, e, s] = model.values;
    let times = |v: f64, sigma: f64| format!("{:.3} ± {sigma:.3} times as given", 1.0 + v);
    let shift = |v: f64, sigma: f64, focal: Option<f64>| match focal {
        Some(focal) => format!("{:+.1} ± {:.1} px", v * focal, sigma * focal),
        None => format!("{v:+.4} ± {sigma:.4} focal lengths"),
    };
    let k = view.map(|view| view.intrinsics);
    let sigma = model.sigmas;
    let all = [
        ("fx", a / sigma[0], times(a, sigma[0])),
        ("fy", b / sigma[1], times(b, sigma[1])),
        ("cx", c / sigma[2], shift(c, sigma[2], k.map(|k| k.fx))),
        ("cy", e / sigma[3], shift(e, sigma[3], k.map(|k| k.fy))),
        ("the depth scale", s / sigma[4], times(s, sigma[4])),
    ];
    let strongest = all.iter().map(|one| one.1.abs()).fold(0.0, f64::max);
    let said = all
        .iter()
        .filter(|one| one.1.abs() > strongest.min(3.0) - 1e-9);
    let said: Vec<String> = said
        .map(|(name, _, text)| format!("{name} {text}"))
        .collect();
    format!(
        "the sensor is not what it is taken for (χ² falls by {:.0}): its planes fit the robot's poses with {}; \
         the mount is off by more than its σ says. Check --sensor's intrinsics and depth scale",
        model.gain,
        said.join(", ")
    )
}
