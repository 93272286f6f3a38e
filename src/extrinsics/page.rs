//! The report of an identification: one HTML page, its charts SVG, nothing loaded from anywhere.

use std::fmt::Write;

use calibration::camera::{Agreement, Identification, PaperParameters};

use super::file::Extrinsics;
use super::identify::Measured;
use super::plot::{Chart, Series, escape};
use super::table::in_paper;

/// Colours of the three axes and of what is measured and predicted.
const AXES: [(&str, &str); 3] = [("a", "#c0392b"), ("b", "#1e8449"), ("c", "#2471a3")];
const PREDICTED: &str = "#555";
const MEASURED: &str = "#c0392b";

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}\
svg{width:100%;height:auto;margin:.5rem 0}svg text{font:11px system-ui,sans-serif;fill:#333}svg .title{font-size:13px;font-weight:600}\
.grid{stroke:#ddd}.level{stroke:#888;stroke-dasharray:4 3}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
td,th{padding:.15rem .6rem;text-align:right;border-bottom:1px solid #e5e5e5}th{font-weight:600}td:first-child,th:first-child{text-align:left}\
.wide{overflow-x:auto}code{font-size:13px;word-break:break-all}";

/// The page.
pub fn html(
    measured: &[Measured],
    found: &Identification,
    written: &Extrinsics,
    next: Option<&str>,
) -> String {
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{robot}: mount of the sensor</title>\
         <style>{STYLE}</style></head><body><h1>Mount of the sensor on {link} of {robot}</h1>",
        robot = escape(&written.robot),
        link = escape(&written.link),
    );
    parameters(&mut out, written);
    quality(&mut out, found, written, next);
    for chart in charts(&found.agreement) {
        out.push_str(&chart.svg());
    }
    stances(&mut out, measured, &found.agreement);
    inputs(&mut out, written);
    out.push_str("</body></html>\n");
    out
}

fn parameters(out: &mut String, written: &Extrinsics) {
    let p = written.position_m;
    let q = written.quat_xyzw;
    let _ = write!(
        out,
        "<p>Optical frame V (x right, y down, z forward) in the link: position ({:.5}, {:.5}, {:.5}) m, \
         quaternion xyzw ({:.6}, {:.6}, {:.6}, {:.6}).</p>",
        p[0], p[1], p[2], q[0], q[1], q[2], q[3]
    );
    let Some(paper) = &written.paper else { return };
    out.push_str("<table><tr><th>[chai2015], y up</th><th>value</th><th>σ</th></tr>");
    for (k, name) in ["α about Y", "β about Z", "γ about X"].iter().enumerate() {
        let (value, sigma) = (paper.angles_deg[k], paper.angles_sigma_deg[k]);
        let (value, sigma) = (format!("{value:.4}°"), format!("{sigma:.4}°"));
        let _ = write!(
            out,
            "<tr><td>{name}</td><td>{value}</td><td>{sigma}</td></tr>"
        );
    }
    for (k, name) in ["p_x", "p_y", "p_z"].iter().enumerate() {
        let (value, sigma) = (paper.position_mm[k], paper.position_sigma_mm[k]);
        let (value, sigma) = (format!("{value:.3} mm"), format!("{sigma:.3} mm"));
        let _ = write!(
            out,
            "<tr><td>{name}</td><td>{value}</td><td>{sigma}</td></tr>"
        );
    }
    out.push_str("</table>");
}

fn quality(out: &mut String, found: &Identification, written: &Extrinsics, next: Option<&str>) {
    let Some(quality) = &written.quality else {
        return;
    };
    let values = found.observability.singular_values.iter();
    let values: Vec<String> = values.map(|value| format!("{value:.3}")).collect();
    let _ = write!(
        out,
        "<p>{} stances of {} tilts. Jacobian (rad, m): rank {} of 6, condition {:.1}, singular values {}. \
         Residuals are {:.2} times the stated noise.</p>",
        quality.stances,
        quality.tilts,
        quality.rank,
        quality.condition,
        values.join(", "),
        quality.noise_factor
    );
    if let Some(next) = next {
        let _ = write!(out, "<p>Next: {}.</p>", escape(next));
    }
}

/// Measured against predicted plane parameters, and their disagreement ([chai2015] Figs. 14–18).
fn charts(agreement: &[Agreement]) -> Vec<Chart<'static>> {
    let column = |of: &dyn Fn(&Agreement) -> f64| agreement.iter().map(of).collect::<Vec<f64>>();
    let dots = |name, colour, values| Series {
        name,
        colour,
        dots: true,
        values,
    };
    let line = |name, colour, values| Series {
        name,
        colour,
        dots: false,
        values,
    };
    let mut normals = Vec::new();
    for (k, (name, colour)) in AXES.into_iter().enumerate() {
        let measured = column(&|a| in_paper(a.measured_normal)[k]);
        normals.push(dots(name, colour, measured));
        let predicted = column(&|a| in_paper(a.predicted_normal)[k]);
        normals.push(line("", colour, predicted));
    }
    let theta = column(&|a| a.theta_rad.to_degrees());
    let distance = column(&|a| 1e3 * a.distance_error_m);
    vec![
        Chart {
            title: "Normal of the ground: measured (dots), predicted (lines)",
            y: "a, b, c",
            series: normals,
            levels: Vec::new(),
        },
        Chart {
            title: "Distance of the ground",
            y: "d, m",
            series: vec![
                dots("measured", MEASURED, column(&|a| a.measured_distance_m)),
                line("predicted", PREDICTED, column(&|a| a.predicted_distance_m)),
            ],
            levels: Vec::new(),
        },
        disagreement("Angle between measured and predicted ground", "θ, °", theta),
        disagreement("Difference of the distances", "e_d, mm", distance),
    ]
}

fn disagreement(title: &'static str, y: &'static str, values: Vec<f64>) -> Chart<'static> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let max = values.iter().copied().fold(0.0, f64::max);
    Chart {
        title,
        y,
        series: vec![Series {
            name: "",
            colour: MEASURED,
            dots: true,
            values,
        }],
        levels: vec![
            (format!("mean {mean:.4}"), mean),
            (format!("max {max:.4}"), max),
        ],
    }
}

fn stances(out: &mut String, measured: &[Measured], agreement: &[Agreement]) {
    out.push_str(
        "<h2>Stances</h2><div class=\"wide\"><table><tr><th>frame</th><th>β °</th><th>γ °</th><th>height m</th>\
         <th>feet mm</th><th>inliers</th><th>measured a, b, c, d</th><th>predicted a, b, c, d</th>\
         <th>θ °</th><th>e_d mm</th><th>weight</th></tr>",
    );
    let plane = |normal: [f64; 3], d: f64| {
        let [a, b, c] = in_paper(normal);
        format!("{a:.4}, {b:.4}, {c:.4}, {d:.4}")
    };
    for (one, a) in measured.iter().zip(agreement) {
        let angles = PaperParameters::of_stance(&one.X_GR).angles_rad;
        let [_, beta, gamma] = angles.map(f64::to_degrees);
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{beta:.2}</td><td>{gamma:.2}</td><td>{:.4}</td><td>{:.2}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{:.4}</td><td>{:.3}</td><td>{:.2}</td></tr>",
            escape(&one.frame),
            one.X_GR.translation.z,
            1e3 * one.foot_error_m,
            one.ground.inliers,
            plane(a.measured_normal, a.measured_distance_m),
            plane(a.predicted_normal, a.predicted_distance_m),
            a.theta_rad.to_degrees(),
            1e3 * a.distance_error_m,
            a.weight
        );
    }
    out.push_str("</table></div>");
}

fn inputs(out: &mut String, written: &Extrinsics) {
    out.push_str("<h2>Inputs</h2><ul>");
    for input in &written.input {
        let (role, name, hash) = (escape(&input.role), escape(&input.name), &input.sha256);
        let _ = write!(out, "<li>{role} {name}: <code>{hash}</code></li>");
    }
    out.push_str("</ul>");
}
