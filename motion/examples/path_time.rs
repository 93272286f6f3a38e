//! How long a path of joints takes at least: reads `{"path": [[…]], "speeds": […], "acceleration": …,
//! "smooth_s": …}` from stdin, the path at equal steps of its parameter, and prints seconds.
//! `benches/peers/pace.py` asks TOPP-RA the same.
use motion::spline::{Ends, Order, Spline};
use motion::time_law::{Row, TimeLaw};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: serde_json::Value = serde_json::from_reader(std::io::stdin())?;
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        let all = value.as_array().into_iter().flatten();
        all.filter_map(serde_json::Value::as_f64).collect()
    };
    let path: Vec<Vec<f64>> = asked["path"]
        .as_array()
        .ok_or("no path")?
        .iter()
        .map(numbers)
        .collect();
    let (speeds, most) = (numbers(&asked["speeds"]), asked["acceleration"].as_f64());
    let (most, smooth_s) = (most.ok_or("no acceleration")?, asked["smooth_s"].as_f64());
    let (pieces, dim) = (path.len() - 1, speeds.len());
    let curve = Spline::new(dim, 1.0 / pieces as f64, path.concat(), Ends::Free);
    let limits = (0..=2 * pieces).map(|i| {
        let at = |order| {
            let mut out = vec![0.0; dim];
            curve.evaluate(i as f64 / (2 * pieces) as f64, order, &mut out);
            out
        };
        let (first, second) = (at(Order::First), at(Order::Second));
        let rates = first.into_iter().zip(second).zip(&speeds);
        let rows = rates.flat_map(|((a, b), speed)| {
            let square = (a / speed).powi(2);
            let both = [(a, b, most), (-a, -b, most), (0.0, square, 1.0)];
            both.map(|(a, b, c)| Row { a, b, c })
        });
        rows.collect()
    });
    let limits: Vec<Vec<Row>> = limits.collect();
    let at: Vec<f64> = (0..=2 * pieces)
        .map(|i| i as f64 / (2 * pieces) as f64)
        .collect();
    let law = TimeLaw::fastest(&at, &limits, smooth_s.ok_or("no smooth_s")?).ok_or("no law")?;
    println!("{}", law.duration_s());
    Ok(())
}
