//! What is said of an identification: in words, as a table of its stances, as one HTML page with
//! charts that loads nothing from anywhere.

use anyhow::Result;
use calibration::camera::{Agreement, Identification, PaperParameters};
use serde::Serialize;

use super::file::Extrinsics;
use super::identify::Measured;
use super::plot::{Chart, Series};
use crate::template::render;

/// Colours of the three axes and of what is measured and predicted.
const AXES: [(&str, &str); 3] = [("a", "#d35445"), ("b", "#2a9d5c"), ("c", "#3f8fc9")];
const PREDICTED: &str = "#7b8794";
const MEASURED: &str = "#d35445";

/// What the templates in `report/` know.
#[derive(Serialize)]
pub struct Report<'a> {
    written: &'a Extrinsics,
    /// Name, value and standard deviation of each of the paper's parameters.
    angles: Vec<(&'static str, f64, f64)>,
    positions: Vec<(&'static str, f64, f64)>,
    singular_values: &'a [f64],
    next: Option<&'a str>,
    /// Why the mount is not to be trusted, if it is not.
    doubts: &'a [String],
    /// What of the sensor's model the stances tell.
    noticed: &'a str,
    /// Number of stances that disagree with the others.
    doubted: usize,
    stances: Vec<Stance<'a>>,
    charts: Vec<String>,
}

/// What was measured and predicted of a stance; planes (a, b, c, d) in the paper's axes.
#[derive(Serialize)]
struct Stance<'a> {
    frame: &'a str,
    angles_deg: [f64; 3],
    height_m: f64,
    foot_error_mm: f64,
    inliers: usize,
    measured: [f64; 4],
    predicted: [f64; 4],
    theta_deg: f64,
    distance_error_mm: f64,
    weight: f64,
}

impl<'a> Report<'a> {
    /// The report of what was found and written; `next` is the stance to add, `doubts` are told first; `noticed`
    /// says what would be noticed of the sensor.
    pub fn new(
        measured: &'a [Measured],
        found: &'a Identification,
        written: &'a Extrinsics,
        next: Option<&'a str>,
        doubts: &'a [String],
        noticed: &'a str,
    ) -> Result<Self> {
        let named = |names: [&'static str; 3], values: [f64; 3], sigmas: [f64; 3]| {
            let rows = [0, 1, 2].map(|k| (names[k], values[k], sigmas[k]));
            rows.to_vec()
        };
        let stances = measured.iter().zip(&found.agreement);
        let stances: Vec<Stance> = stances.map(|(one, a)| Stance::of(one, a)).collect();
        let charts = charts(&stances);
        Ok(Self {
            written,
            angles: written.paper.map_or_else(Vec::new, |paper| {
                let names = ["α about Y", "β about Z", "γ about X"];
                named(names, paper.angles_deg, paper.angles_sigma_deg)
            }),
            positions: written.paper.map_or_else(Vec::new, |paper| {
                let names = ["p_x", "p_y", "p_z"];
                named(names, paper.position_mm, paper.position_sigma_mm)
            }),
            singular_values: &found.observability.singular_values,
            next,
            doubts,
            noticed,
            doubted: stances
                .iter()
                .filter(|s| s.weight > 0.0 && s.weight < 1.0)
                .count(),
            charts: charts.iter().map(Chart::svg).collect::<Result<_>>()?,
            stances,
        })
    }

    /// The six parameters with their deviations, and what the stances tell, in words.
    pub fn text(&self) -> Result<String> {
        render("found.txt", include_str!("report/found.txt"), self)
    }

    /// θ and e_d of every stance with both planes, as CSV.
    pub fn csv(&self) -> Result<String> {
        render("stances.csv", include_str!("report/stances.csv"), self)
    }

    /// The page.
    pub fn html(&self) -> Result<String> {
        render("page.html", include_str!("report/page.html"), self)
    }
}

impl<'a> Stance<'a> {
    fn of(one: &'a Measured, agreement: &Agreement) -> Self {
        // The paper's axes of a sensor: x forward, y up, z right.
        let plane = |[x, y, z]: [f64; 3], d: f64| [z, -y, x, d];
        let a = agreement;
        Self {
            frame: &one.frame,
            angles_deg: PaperParameters::of_stance(&one.X_GR)
                .angles_rad
                .map(f64::to_degrees),
            height_m: one.X_GR.translation.z,
            foot_error_mm: 1e3 * one.foot_error_m,
            inliers: one.ground.inliers,
            measured: plane(a.measured_normal, a.measured_distance_m),
            predicted: plane(a.predicted_normal, a.predicted_distance_m),
            theta_deg: a.theta_rad.to_degrees(),
            distance_error_mm: 1e3 * a.distance_error_m,
            weight: a.weight,
        }
    }
}

/// Measured against predicted plane parameters, and their disagreement ([chai2015] Figs. 14–18).
fn charts(stances: &[Stance]) -> [Chart<'static>; 4] {
    let column = |of: &dyn Fn(&Stance) -> f64| stances.iter().map(of).collect::<Vec<f64>>();
    let series = |dots, name, colour, values| Series {
        name,
        colour,
        dots,
        values,
    };
    let mut normals = Vec::new();
    for (k, (name, colour)) in AXES.into_iter().enumerate() {
        normals.push(series(true, name, colour, column(&|s| s.measured[k])));
        normals.push(series(false, "", colour, column(&|s| s.predicted[k])));
    }
    let disagreement = |title, y, values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let max = values.iter().copied().fold(0.0, f64::max);
        Chart {
            title,
            y,
            series: vec![series(true, "", MEASURED, values)],
            levels: vec![
                (format!("mean {mean:.4}"), mean),
                (format!("max {max:.4}"), max),
            ],
        }
    };
    let (theta, distance) = (column(&|s| s.theta_deg), column(&|s| s.distance_error_mm));
    [
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
                series(true, "measured", MEASURED, column(&|s| s.measured[3])),
                series(false, "predicted", PREDICTED, column(&|s| s.predicted[3])),
            ],
            levels: Vec::new(),
        },
        disagreement("Angle between measured and predicted ground", "θ, °", theta),
        disagreement("Difference of the distances", "e_d, mm", distance),
    ]
}
