//! Line charts as SVG.

use std::fmt::Write;

/// Size of a chart and of the margins left, right, top and bottom, px.
const SIZE: [f64; 2] = [720.0, 260.0];
const MARGIN: [f64; 4] = [64.0, 16.0, 30.0, 42.0];
/// Grid lines wanted along y.
const TICKS: f64 = 5.0;

/// Values of every stance, drawn as dots or as a line.
pub struct Series<'a> {
    /// Name in the legend.
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
    pub fn svg(&self) -> String {
        let values = || {
            let all = self.series.iter().flat_map(|s| s.values.iter().copied());
            all.chain(self.levels.iter().map(|level| level.1))
                .filter(|v| v.is_finite())
        };
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // Non-negative values begin at zero.
        let from_zero = (0.0..0.5 * high).contains(&low);
        let low = if from_zero { 0.0 } else { low };
        let step = nice((high - low).max(1e-9) / TICKS);
        let (bottom, top) = ((low / step).floor() * step, (high / step).ceil() * step);
        let top = if top > bottom { top } else { bottom + step };
        let n = self.series.iter().map(|s| s.values.len()).max();
        let n = n.unwrap_or(0);

        let [left, right, above, below] = MARGIN;
        let width = SIZE[0] - left - right;
        let height = SIZE[1] - above - below;
        let x = |i: usize| left + width * (i as f64 + 0.5) / n.max(1) as f64;
        let y = |value: f64| above + height * (top - value) / (top - bottom);

        let mut out = format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\"><title>{title}</title>\
             <text x=\"{left}\" y=\"18\" class=\"title\">{title}</text>",
            SIZE[0],
            SIZE[1],
            title = escape(self.title),
        );
        // Grid and axes.
        let digits = (-step.log10().floor()).max(0.0) as usize;
        let lines = ((top - bottom) / step).round() as usize;
        for k in 0..=lines {
            let value = bottom + step * k as f64;
            let at = y(value);
            let _ = write!(
                out,
                "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\" class=\"grid\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{:.digits$}</text>",
                left + width,
                left - 6.0,
                at + 4.0,
                value + 0.0
            );
        }
        let every = n.div_ceil(13).max(1);
        for i in (0..n).step_by(every) {
            let _ = write!(
                out,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                x(i),
                above + height + 16.0,
                i + 1
            );
        }
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">stance</text>\
             <text transform=\"translate(14 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            left + 0.5 * width,
            SIZE[1] - 8.0,
            above + 0.5 * height,
            escape(self.y)
        );
        // Values.
        for series in &self.series {
            let values = series.values.iter().enumerate();
            let finite = values.filter(|(_, value)| value.is_finite());
            let points = finite.map(|(i, value)| [x(i), y(*value)]);
            let colour = series.colour;
            if series.dots {
                for [x, y] in points {
                    let place = format!("cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\"");
                    let _ = write!(out, "<circle {place} fill=\"{colour}\"/>");
                }
            } else {
                let points: Vec<String> = points.map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
                let line = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\"");
                let _ = write!(out, "<polyline points=\"{}\" {line}/>", points.join(" "));
            }
        }
        for (name, value) in &self.levels {
            let at = y(*value);
            let _ = write!(
                out,
                "<line x1=\"{left}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\" class=\"level\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left + width,
                left + width,
                at - 4.0,
                escape(name)
            );
        }
        // Legend, from the right; a series without a name has no entry.
        let mut at = left + width;
        let named = self.series.iter().filter(|series| !series.name.is_empty());
        for series in named.rev() {
            at -= 7.0 * series.name.chars().count() as f64 + 22.0;
            let _ = write!(
                out,
                "<circle cx=\"{at:.1}\" cy=\"14\" r=\"4\" fill=\"{}\"/>\
                 <text x=\"{:.1}\" y=\"18\">{}</text>",
                series.colour,
                at + 8.0,
                escape(series.name)
            );
        }
        out.push_str("</svg>");
        out
    }
}

/// 1, 2 or 5 times a power of ten, at least `step`.
fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let ratio = step / power;
    let nice = [1.0, 2.0, 5.0].into_iter().find(|n| ratio <= n + 1e-9);
    nice.unwrap_or(10.0) * power
}

/// Text as it may stand in HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
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
            let svg = chart.svg();
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
