//! Slopes on the terminal.

use std::io::Write;

use perception::lidar::SegmentedCloud;

use super::record::{SlopeRecord, ThingRecord, WallRecord};

/// Prints what was found.
///
/// # Errors
/// When it cannot be printed.
pub fn print(
    seen: &SegmentedCloud,
    slopes: &[SlopeRecord],
    walls: &[WallRecord],
    things: &[ThingRecord],
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let c = &seen.counts;
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
    match &seen.scan {
        Some(scan) => {
            let (below_m, rms_mm) = (scan.ground.plane_V.offset_m, 1e3 * scan.ground.rms_m);
            let how = ["not seen, as calibrated", "seen"][usize::from(scan.ground.seen)];
            writeln!(
                out,
                "ground: {how}, {below_m:.3} m below the sensor, rms {rms_mm:.1} mm"
            )?;
        }
        None => writeln!(
            out,
            "no ground: none of the planes is about level under the sensor; a calibration would tell \
             where it is. What follows is in the sensor's frame"
        )?,
    }
    print_slopes(slopes, out)?;
    print_around(walls, things, out)
}

fn print_slopes(slopes: &[SlopeRecord], out: &mut dyn Write) -> std::io::Result<()> {
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
            let (heading, angle) = (step.heading_deg, step.delta_s_deg);
            writeln!(out, "  heading {heading:.1}°: stepping angle {angle:.2}°")?;
        }
    }
    Ok(())
}

fn print_around(
    walls: &[WallRecord],
    things: &[ThingRecord],
    out: &mut dyn Write,
) -> std::io::Result<()> {
    for (number, w) in walls.iter().enumerate() {
        let [[x1, y1], [x2, y2]] = w.ends_m;
        let [low, high] = w.heights_m;
        writeln!(
            out,
            "wall {number}: {:.2} m away, from ({x1:.2}, {y1:.2}) to ({x2:.2}, {y2:.2}) m, seen \
             {low:.2} to {high:.2} m high, {} points, rms {:.1} mm",
            w.distance_m,
            w.inliers,
            1e3 * w.rms_m
        )?;
    }
    for (number, t) in things.iter().enumerate() {
        let [x, y, _] = t.centre;
        let [low, high] = t.heights_m;
        writeln!(
            out,
            "thing {number}: at ({x:.2}, {y:.2}) m, {:.2} m wide, seen {low:.2} to {high:.2} m high, \
             {} points",
            t.width_m, t.points
        )?;
    }
    Ok(())
}
