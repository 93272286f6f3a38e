//! The 52 poses of [chai2015] Table A1, simulated: agreement, true error and its prediction.

use crate::support::{Device, Outcome, Series, heading, outcome, rms, row};
use scenes::simulator::DepthNoise;

/// Runs of a series.
const RUNS: u64 = 20;
/// How many times smaller the images are than a Kinect's, both ways.
const SMALLER: usize = 5;

fn outcomes(series: &Series) -> Vec<Outcome> {
    let run = |run| outcome(&series.measure(run), &series.config.camera);
    (0..RUNS).map(run).collect()
}

/// A series in numbers: α, β, γ in degrees, p in mm.
struct Summary {
    /// Root mean square of the true error: of the joint estimate, predicted, and of the closed form.
    rms: [f64; 6],
    sigma: [f64; 6],
    closed: [f64; 6],
    /// Mean of eᵀ Σ⁻¹ e / 6.
    nees: f64,
    /// Mean over all poses; mean over the runs of the greatest of a run.
    theta_mean_deg: f64,
    theta_max_deg: f64,
    distance_mm: f64,
}

/// Prints a series.
fn report(name: &str, outcomes: &[Outcome]) -> Summary {
    let runs = outcomes.len() as f64;
    let columns = |of: fn(&Outcome) -> [f64; 6]| rms(&outcomes.iter().map(of).collect::<Vec<_>>());
    let all = || outcomes.iter().flat_map(|o| &o.found.agreement);
    let poses = all().count() as f64;
    let greatest = |o: &Outcome| {
        let thetas = o.found.agreement.iter().map(|a| a.theta_rad.to_degrees());
        thetas.fold(0.0, f64::max)
    };
    let summary = Summary {
        rms: columns(|o| o.error),
        sigma: columns(|o| o.sigma),
        closed: columns(|o| o.closed_error),
        nees: outcomes.iter().map(|o| o.nees).sum::<f64>() / runs,
        theta_mean_deg: all().map(|a| a.theta_rad.to_degrees()).sum::<f64>() / poses,
        theta_max_deg: outcomes.iter().map(greatest).sum::<f64>() / runs,
        distance_mm: all().map(|a| 1e3 * a.distance_error_m).sum::<f64>() / poses,
    };
    println!("\n{name}, {} runs", outcomes.len());
    heading();
    row("true error of the joint estimate, RMS", &summary.rms);
    row("  predicted", &summary.sigma);
    row("true error of the closed form, RMS", &summary.closed);
    let factor = outcomes.iter().map(|o| o.found.noise_factor).sum::<f64>() / runs;
    println!(
        "NEES/6 {:.2}; θ {:.3}° mean, {:.3}° max a run (published 0.210, 0.522); e_d {:.2} mm mean \
         (published 1.1); residuals {factor:.2} × the stated noise",
        summary.nees, summary.theta_mean_deg, summary.theta_max_deg, summary.distance_mm
    );
    summary
}

/// The mean over poses and runs that [chai2015] gives for its 52 poses: 0.2104°; its greatest angle
/// 0.5219°; its mean distance 1.1 mm.
#[test]
fn an_undistorted_sensor() {
    let noise = DepthNoise {
        distortion: 0.0,
        ..DepthNoise::default()
    };
    let series = Series::new(Device::kinect(SMALLER, &noise));
    let summary = report("sensor without distortion", &outcomes(&series));
    // The agreement is the paper's: 5 % of sampling error for the means of 52 · 20 values, a fifth
    // for a greatest value.
    assert!((summary.theta_mean_deg / 0.21 - 1.0).abs() < 0.05);
    assert!((summary.theta_max_deg / 0.52 - 1.0).abs() < 0.2);
    assert!((1.1..1.5).contains(&summary.distance_mm));
    // The true error, which the paper could not know: positions, and pitch. A tilt error of 0.17° of
    // each of these 52 poses leaves 0.080, 0.025 and 0.031° of α, β and γ to *any* unbiased
    // estimator (the inverse of the Fisher information, of sensors without noise too), so the
    // angles are held to what was predicted.
    for (k, most) in [(1, 0.025), (3, 1.0), (4, 0.3), (5, 1.0)] {
        assert!(summary.rms[k] <= most, "parameter {k}: {:?}", summary.rms);
    }
    check_prediction(&summary);
    // Weighing tilt and distance as a pair is worth a third of the position along x and z.
    for k in [3, 5] {
        assert!(summary.rms[k] < 0.75 * summary.closed[k], "parameter {k}");
    }
}

#[test]
fn a_distortion_that_all_frames_share_is_estimated_along() {
    let series = Series::new(Device::kinect(SMALLER, &DepthNoise::default()));
    let summary = report("distortion of the device", &outcomes(&series));
    check_prediction(&summary);
    for k in [1, 3] {
        assert!(summary.rms[k] < 0.67 * summary.closed[k], "parameter {k}");
    }
}

#[test]
fn a_distortion_that_is_drawn_anew_in_each_frame_is_averaged() {
    let mut series = Series::new(Device::kinect(SMALLER, &DepthNoise::default()));
    series.distorted_anew = true;
    series.config.ground.distortion_shared = 0.0;
    let summary = report("distortion anew in each frame", &outcomes(&series));
    check_prediction(&summary);
}

/// The covariance says how far the truth is: NEES/6 within 0.5–2, each error within 1.5 of its
/// deviation (20 runs: the RMS of a Gaussian is within 1.35 of it in 98 %).
fn check_prediction(summary: &Summary) {
    assert!((0.5..2.0).contains(&summary.nees), "{}", summary.nees);
    for k in 0..6 {
        assert!(summary.rms[k] < 1.5 * summary.sigma[k], "parameter {k}");
    }
}
