//! What is to be thought of a mount that was found.

use calibration::camera::{Checked, Mistake, SensorModel};

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
    let likely = SensorModel::likely(&checked.sensor);
    if !likely.is_empty() {
        doubts.push(sensor(&likely, measured));
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

/// How far each part of the sensor's model has to be off to be noticed by these stances.
pub fn noticed(models: &[SensorModel], measured: &[Measured]) -> String {
    let of = |model: &SensorModel| {
        let [a, _, c, e, s] = model.noticed();
        match model.mistake {
            Mistake::Focal => Some(format!("focal lengths that are {:.1} % off", 100.0 * a)),
            Mistake::Centre => Some(match focal_px(measured) {
                Some([fx, fy]) => format!(
                    "a principal point that is {:.0} px off across or {:.0} px down",
                    c * fx,
                    e * fy
                ),
                None => format!("a principal point that is {c:.3} or {e:.3} focal lengths off"),
            }),
            Mistake::Scale => Some(format!("a depth scale that is {:.1} % off", 100.0 * s)),
            Mistake::Several => None,
        }
    };
    let parts: Vec<String> = models.iter().filter_map(of).collect();
    format!(
        "of the sensor's model these stances show {}; what is less cannot be told from the mount",
        parts.join(", ")
    )
}

fn focal_px(measured: &[Measured]) -> Option<[f64; 2]> {
    let k = measured.first()?.view?.intrinsics;
    Some([k.fx, k.fy])
}

/// What may be wrong with the sensor's model.
fn sensor(likely: &[SensorModel], measured: &[Measured]) -> String {
    let fits: Vec<String> = likely.iter().map(|one| values(one, measured)).collect();
    let apart = match likely.len() {
        1 => "",
        _ => " (which of these, these stances do not tell)",
    };
    format!(
        "the sensor is not what it is taken for (χ² falls by {:.0}): its planes fit the robot's poses with {}{apart}; \
         the mount is off by more than its σ says. Check --sensor's intrinsics and depth scale",
        likely[0].gain,
        fits.join(", or with ")
    )
}

/// What a mistake changed, in words.
fn values(model: &SensorModel, measured: &[Measured]) -> String {
    let [a, b, c, e, s] = model.values;
    let times = |v: f64, sigma: f64| format!("{:.3} ± {sigma:.3} times as given", 1.0 + v);
    let focal = focal_px(measured);
    let shift = |v: f64, sigma: f64, axis: usize| match focal {
        Some(focal) => format!("{:+.1} ± {:.1} px", v * focal[axis], sigma * focal[axis]),
        None => format!("{v:+.4} ± {sigma:.4} focal lengths"),
    };
    let sigma = model.sigmas;
    let all = [
        ("fx", a / sigma[0], times(a, sigma[0])),
        ("fy", b / sigma[1], times(b, sigma[1])),
        ("cx", c / sigma[2], shift(c, sigma[2], 0)),
        ("cy", e / sigma[3], shift(e, sigma[3], 1)),
        ("the depth scale", s / sigma[4], times(s, sigma[4])),
    ];
    // What the mistake leaves alone is not a number.
    let strongest = all.iter().map(|one| one.1.abs()).fold(0.0, f64::max);
    let said = (all.iter()).filter(|one| one.1.abs() > strongest.min(3.0) - 1e-9);
    let said: Vec<String> = said
        .map(|(name, _, text)| format!("{name} {text}"))
        .collect();
    said.join(", ")
}
