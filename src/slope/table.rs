//! Slopes on the terminal.

use std::io::Write;

use perception::lidar::SlopeScan;

use super::record::SlopeRecord;

/// Prints what was found.
///
/// # Errors
/// When it cannot be printed.
pub fn print(scan: &SlopeScan, slopes: &[SlopeRecord], out: &mut dyn Write) -> std::io::Result<()> {
    let c = &scan.counts;
    writeln!(
        out,
        "{} points ({} invalid), {} in view, {} not isolated ({:.2} %), {} on the ground",
        c.points,
        c.invalid,
        c.in_view,
        c.kept,
        100.0 * c.kept as f64 / c.in_view.max(1) as f64,
        c.ground
    )?;
    let ground = &scan.ground;
    writeln!(
        out,
        "ground: {}, {:.3} m below the sensor, rms {:.1} mm",
        if ground.seen {
            "seen"
        } else {
            "not seen, as calibrated"
        },
        ground.plane_V.offset_m,
        1e3 * ground.rms_m
    )?;
    if slopes.is_empty() {
        return writeln!(out, "no slope");
    }
    let triple = |v: &[f64; 3]| format!("({:.4}, {:.4}, {:.4})", v[0], v[1], v[2]);
    for (number, s) in slopes.iter().enumerate() {
        writeln!(
            out,
            "slope {number}: {:.2}° ± {:.2}°, {} points, rms {:.1} mm",
            s.delta_deg,
            s.delta_sigma_deg,
            s.inliers,
            1e3 * s.rms_m
        )?;
        for (name, p, i) in [("p1", &s.p1, 0), ("p2", &s.p2, 1)] {
            writeln!(
                out,
                "  {name}  {} m ± {:.1} mm across, {:.1} mm along the line",
                triple(p),
                1e3 * s.across_sigma_m[i],
                1e3 * s.along_sigma_m[i]
            )?;
        }
        writeln!(out, "  l   {}", triple(&s.l))?;
        writeln!(out, "  psi {}, {:.2}° from x", triple(&s.psi), s.ascent_deg)?;
        for step in &s.stepping {
            writeln!(
                out,
                "  heading {:.1}°: stepping angle {:.2}°",
                step.heading_deg, step.delta_s_deg
            )?;
        }
    }
    Ok(())
}
