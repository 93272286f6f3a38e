//! Line charts as SVG.

use anyhow::Result;
use serde_json::json;

use crate::template::render;

/// Size of a chart and of the margins left, right, top and bottom, px.
const SIZE: [f64; 2] = [720.0, 260.0];
const MARGIN: [f64; 4] = [64.0, 16.0, 30.0, 42.0];
/// Grid lines wanted along y.
const TICKS: f64 = 5.0;

/// Values of every stance, drawn as dots or as a line.
pub struct Series<'a> {
    /// Name in the legend; empty for none.
    pub name: &'a str,
    /// Colour.
    pub colour: &'a str,
    /// Dots; else a line.
    pub dots: bool,
    /// One value a stance.
    pub values: Vec<f64>,
}

/// A chart over the numbers of the stances, from 1.
pub struct Chart<'a> {
    /// Title.
    pub title: &'a str,
    /// What y is, with its unit.
    pub y: &'a str,
    /// What is drawn.
    pub series: Vec<Series<'a>>,
    /// Level lines with their names.
    pub levels: Vec<(String, f64)>,
}

impl Chart<'_> {
    /// The chart as an SVG element.
    pub fn svg(&self) -> Result<String> {
        let values = self.series.iter().flat_map(|s| s.values.iter().copied());
        let values = values.chain(self.levels.iter().map(|level| level.1));
        let (step, [low, high]) = scale(values.filter(|v| v.is_finite()));
        let n = self.series.iter().map(|s| s.values.len()).max();
        let n = n.unwrap_or(0).max(1);

        let [left, right, above, below] = MARGIN;
        let (right, bottom) = (SIZE[0] - right, SIZE[1] - below);
        let x = |i: usize| left + (right - left) * (i as f64 + 0.5) / n as f64;
        let y = |value: f64| above + (bottom - above) * (high - value) / (high - low);

        let digits = (-step.log10().floor()).max(0.0) as usize;
        let ticks = (0..=((high - low) / step).round() as usize).map(|k| {
            let value = low + step * k as f64 + 0.0;
            (format!("{value:.digits$}"), y(value))
        });
        let numbers = (0..n).step_by(n.div_ceil(13)).map(|i| (i + 1, x(i)));
        let levels = self.levels.iter().map(|(name, value)| (name, y(*value)));
        let series = self.series.iter().map(|s| {
            let values = s.values.iter().enumerate();
            let finite = values.filter(|(_, value)| value.is_finite());
            let points: Vec<[f64; 2]> = finite.map(|(i, value)| [x(i), y(*value)]).collect();
            json!({ "name": s.name, "colour": s.colour, "dots": s.dots, "points": points })
        });
        let drawn = json!({
            "title": self.title,
            "y": self.y,
            "width": SIZE[0],
            "height": SIZE[1],
            "left": left,
            "right": right,
            "top": above,
            "bottom": bottom,
            "ticks": ticks.collect::<Vec<_>>(),
            "numbers": numbers.collect::<Vec<_>>(),
            "levels": levels.collect::<Vec<_>>(),
            "series": series.collect::<Vec<_>>(),
        });
        render("chart.html", include_str!("report/chart.html"), drawn)
    }
}

/// The step of the grid, and its lowest and highest line around these values.
fn scale(values: impl Iterator<Item = f64> + Clone) -> (f64, [f64; 2]) {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    // Non-negative values begin at zero.
    let from_zero = (0.0..0.5 * high).contains(&low);
    let low = if from_zero { 0.0 } else { low };
    let step = nice((high - low).max(1e-9) / TICKS);
    let (bottom, top) = ((low / step).floor() * step, (high / step).ceil() * step);
    (step, [bottom, top.max(bottom + step)])
}

/// 1, 2 or 5 times a power of ten, at least `step`.
fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let ratio = step / power;
    let nice = [1.0, 2.0, 5.0].into_iter().find(|n| ratio <= n + 1e-9);
    nice.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_lie_inside_the_frame_and_text_is_escaped() {
        for values in [vec![], vec![0.0], vec![-3.0, 7.0, f64::NAN], vec![1e-6; 60]] {
            let chart = Chart {
                title: "a < b",
                y: "m",
                series: vec![Series {
                    name: "s",
                    colour: "red",
                    dots: true,
                    values: values.clone(),
                }],
                levels: vec![],
            };
            let svg = chart.svg().unwrap();
            assert!(svg.contains("a &lt; b") && !svg.contains("NaN"), "{svg}");
            let finite = values.iter().filter(|v| v.is_finite()).count();
            let dots: Vec<f64> = svg
                .split("cy=\"")
                .skip(1)
                .filter(|rest| rest.contains("r=\"2.6\""))
                .filter_map(|rest| rest.split('"').next()?.parse().ok())
                .filter(|cy| *cy != 14.0)
                .collect();
            assert_eq!(dots.len(), finite);
            let inside = dots.iter().all(|cy| (29.0..=219.0).contains(cy));
            assert!(inside, "{dots:?}");
        }
    }

    #[test]
    fn steps_are_nice() {
        for (step, expected) in [(0.013, 0.02), (0.2, 0.2), (3.1, 5.0), (7.0, 10.0)] {
            assert!((nice(step) - expected).abs() < 1e-12, "{step}");
        }
    }
}
