//! A plane to start from, where not all that is seen is ground.

use nalgebra::{Matrix3, Vector3};

use super::Samples;

/// Samples that the drawn planes are compared on.
const COMPARED: usize = 1200;
/// Residual beyond which a sample counts against a plane no more, in standard deviations.
const BOUND: f64 = 3.0;

/// m of the drawn plane on which most samples lie, or `None` where no three of them span one.
///
///   min Σ min((m·r − w)²/σ², bound²)
///
/// The samples are thinned evenly, the draws come from a counter: the same scan gives the same plane.
/// Source: [torr2000], whose MSAC this is.
pub(super) fn plane(samples: &Samples, draws: usize, seed: u64) -> Option<Vector3<f64>> {
    let stride = (samples.len() / COMPARED).max(1);
    let thinned = (0..samples.len()).step_by(stride).map(|i| {
        let ray = Vector3::from(samples.rays[i].map(f64::from));
        let w = f64::from(samples.inverse[i]);
        (ray, w, f64::from(samples.sharpness[i]))
    });
    let thinned: Vec<(Vector3<f64>, f64, f64)> = thinned.collect();
    let n = thinned.len() as u64;
    if n < 3 {
        return None;
    }
    let mut counter = seed;
    let mut draw = || {
        counter = counter.wrapping_add(0x9E37_79B9_7F4A_7C15);
        thinned[(mixed(counter) % n) as usize]
    };
    let mut best: Option<(f64, Vector3<f64>)> = None;
    for _ in 0..draws {
        let three = [draw(), draw(), draw()];
        let rows = Matrix3::from_rows(&three.map(|(ray, ..)| ray.transpose()));
        let wanted = Vector3::new(three[0].1, three[1].1, three[2].1);
        let Some(m) = rows.try_inverse().map(|inverse| inverse * wanted) else {
            continue;
        };
        let costs = thinned.iter().map(|(ray, w, sharpness)| {
            let s = (m.dot(ray) - w) * sharpness;
            (s * s).min(BOUND * BOUND)
        });
        let cost: f64 = costs.sum();
        if cost.is_finite() && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, m));
        }
    }
    best.map(|(_, m)| m)
}

/// The finaliser of SplitMix64.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
