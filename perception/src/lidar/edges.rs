//! How far a slope reaches along its start line.

use nalgebra::Vector3;

use super::field::Field;

/// The ends of a slope along a direction.
pub(super) struct Edges {
    /// Least coordinate, m.
    pub low: f64,
    /// Its standard deviation, m.
    pub low_sigma: f64,
    /// Greatest coordinate, m.
    pub high: f64,
    /// Its standard deviation, m.
    pub high_sigma: f64,
}

/// Ends of rings that lie within this of the farthest but one are the edge's, m.
const EDGE_M: f64 = 0.025;
/// Part of the points beyond the ends where there are no rings, on either side.
const QUANTILE: f64 = 0.005;

/// The ends of the points `members` along the unit vector `l` (coordinates q·l of points q).
///
/// Every ring that crosses the slope ends at its edges, half a step short on average. A ring that
/// leaves it across its foot or its top ends before them, so that the farthest ends count; the very
/// farthest alone may be a stray. Without rings the ends are quantiles.
/// Source: [meng] Eq. 11; deviation: max and min of q_x + q_y degenerate for lines at 135°.
pub(super) fn along(field: &Field, members: &[u32], l: &Vector3<f64>) -> Option<Edges> {
    let coordinate = |i: u32| field.point(i as usize).dot(l);
    if field.ring.is_empty() {
        let mut values: Vec<f64> = members.iter().map(|&i| coordinate(i)).collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let cut = (n as f64 * QUANTILE) as usize;
        let (low, high) = (*values.get(cut)?, *values.get(n.checked_sub(1 + cut)?)?);
        // The points' mean distance along the line.
        let sigma = (high - low) / (n as f64).sqrt();
        return Some(Edges {
            low,
            low_sigma: sigma,
            high,
            high_sigma: sigma,
        });
    }
    // The ends of every ring with a few points, and its step there.
    let (mut lows, mut highs) = (Vec::new(), Vec::new());
    let mut from = 0;
    for at in 1..=members.len() {
        let ring = |k: usize| field.ring[members[k] as usize];
        if at < members.len() && ring(at) == ring(at - 1) {
            continue;
        }
        let run = &members[from..at];
        from = at;
        if run.len() < 5 {
            continue;
        }
        let mut values: Vec<f64> = run.iter().map(|&i| coordinate(i)).collect();
        values.sort_by(f64::total_cmp);
        let n = values.len();
        let step = (values[n - 1] - values[0]) / (n - 1) as f64;
        lows.push((-values[0], step));
        highs.push((values[n - 1], step));
    }
    let (low, low_sigma) = edge(lows)?;
    let (high, high_sigma) = edge(highs)?;
    Some(Edges {
        low: -low,
        low_sigma,
        high,
        high_sigma,
    })
}

/// The mean of the farthest ends and its standard deviation, from (end, step) of every ring.
fn edge(mut ends: Vec<(f64, f64)>) -> Option<(f64, f64)> {
    ends.sort_by(|a, b| b.0.total_cmp(&a.0));
    let reference = ends.get(1).or(ends.first())?.0;
    let agreeing: Vec<&(f64, f64)> = ends
        .iter()
        .filter(|(end, _)| (end - reference).abs() <= EDGE_M)
        .collect();
    let n = agreeing.len() as f64;
    let step = agreeing.iter().map(|(_, step)| step).sum::<f64>() / n;
    let mean = agreeing.iter().map(|(end, _)| end).sum::<f64>() / n + step / 2.0;
    let variance = agreeing
        .iter()
        .map(|(end, _)| (end + step / 2.0 - mean).powi(2))
        .sum::<f64>()
        / n;
    // Not less than that of a step's even spread.
    let sigma = ((variance.max(step * step / 12.0)) / n)
        .sqrt()
        .max(step / 12.0_f64.sqrt() / n);
    Some((mean, sigma))
}
