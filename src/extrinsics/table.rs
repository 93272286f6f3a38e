//! The disagreement of every stance, for the terminal and as CSV.

use std::io::Write;

use calibration::camera::{Identification, PaperParameters};

use super::file::Extrinsics;
use super::identify::Measured;

/// Prints the six parameters with their deviations, and what the stances tell.
///
/// # Errors
/// When `out` cannot be written to.
pub fn print(
    found: &Identification,
    written: &Extrinsics,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let p = &written.position_m;
    let q = &written.quat_xyzw;
    writeln!(
        out,
        "the sensor's optical frame in {:?}: p = {:.4}, {:.4}, {:.4} m, quat_xyzw = {:.5}, {:.5}, {:.5}, {:.5}",
        written.link, p[0], p[1], p[2], q[0], q[1], q[2], q[3]
    )?;
    if let Some(paper) = &written.paper {
        writeln!(out, "  as chai2015 writes it (about Y, Z, X; y up):")?;
        for (k, name) in ["α", "β", "γ"].iter().enumerate() {
            let (value, sigma) = (paper.angles_deg[k], paper.angles_sigma_deg[k]);
            writeln!(out, "    {name:<3} {value:>9.4} ± {sigma:.4} °")?;
        }
        for (k, name) in ["p_x", "p_y", "p_z"].iter().enumerate() {
            let (value, sigma) = (paper.position_mm[k], paper.position_sigma_mm[k]);
            writeln!(out, "    {name:<3} {value:>9.3} ± {sigma:.3} mm")?;
        }
    }
    if let Some(quality) = &written.quality {
        writeln!(
            out,
            "{} stances of {} tilts: rank {} of 6, condition {:.1}; residuals {:.2} times the stated noise",
            quality.stances, quality.tilts, quality.rank, quality.condition, quality.noise_factor
        )?;
        writeln!(
            out,
            "ground seen against ground predicted: θ {:.4}° mean, {:.4}° max; e_d {:.3} mm mean, {:.3} mm max",
            quality.theta_mean_deg,
            quality.theta_max_deg,
            quality.distance_mean_mm,
            quality.distance_max_mm
        )?;
    }
    let doubted = found.agreement.iter().filter(|a| a.weight < 1.0).count();
    if doubted > 0 {
        writeln!(
            out,
            "{doubted} stances disagree with the others and count less"
        )?;
    }
    Ok(())
}

/// θ and e_d of every stance with both planes, as CSV.
pub fn csv(measured: &[Measured], found: &Identification) -> String {
    let mut text = String::from(
        "stance,frame,alpha_deg,beta_deg,gamma_deg,height_m,foot_error_mm,inliers,\
         measured_a,measured_b,measured_c,measured_d_m,\
         predicted_a,predicted_b,predicted_c,predicted_d_m,theta_deg,e_d_mm,weight\n",
    );
    for (i, (one, agreement)) in measured.iter().zip(&found.agreement).enumerate() {
        let angles = PaperParameters::of_stance(&one.X_GR).angles_rad;
        let [alpha, beta, gamma] = angles.map(f64::to_degrees);
        let [ma, mb, mc] = in_paper(agreement.measured_normal);
        let [pa, pb, pc] = in_paper(agreement.predicted_normal);
        text.push_str(&format!(
            "{},{},{alpha:.4},{beta:.4},{gamma:.4},{:.5},{:.3},{},{ma:.6},{mb:.6},{mc:.6},{:.6},{pa:.6},{pb:.6},{pc:.6},{:.6},{:.5},{:.4},{:.3}\n",
            i + 1,
            one.frame,
            one.X_GR.translation.z,
            1e3 * one.foot_error_m,
            one.ground.inliers,
            agreement.measured_distance_m,
            agreement.predicted_distance_m,
            agreement.theta_rad.to_degrees(),
            1e3 * agreement.distance_error_m,
            agreement.weight,
        ));
    }
    text
}

/// (a, b, c) in the paper's axes of a sensor (x forward, y up, z right) from those of V.
pub fn in_paper([x, y, z]: [f64; 3]) -> [f64; 3] {
    [z, -y, x]
}
