//! The scan in the page: thinned evenly, positions in 16-bit steps.

use std::collections::HashSet;

use base64ct::{Base64, Encoding};
use serde_json::{Value, json};

/// Edge of the first grid, m; each following one is wider by [`WIDENING_MIN`] at least, and more while far too many
/// points are left: their number falls as the square of the edge.
const FIRST_CELL_M: f32 = 0.005;
const WIDENING_MIN: f32 = 1.2;

/// At most `most` of the finite points, in their order: the first of each cell of the first grid
/// that has few enough cells.
pub(super) fn thinned(points: &[[f32; 3]], most: usize) -> Vec<[f32; 3]> {
    let mut kept = points.to_vec();
    kept.retain(|p| p.iter().all(|c| c.is_finite()));
    let mut cell = FIRST_CELL_M;
    while kept.len() > most {
        // Asked only whether a cell is taken: the order of the set reaches nothing.
        let mut taken = HashSet::new();
        kept.retain(|p| taken.insert(p.map(|c| (c / cell).floor() as i64)));
        cell *= (kept.len() as f32 / most as f32)
            .powf(0.4)
            .max(WIDENING_MIN);
    }
    kept
}

/// The points as base64 of little-endian 16-bit steps above their lower corner; null when there
/// are none. `total` is the number of points they were thinned from.
pub(super) fn record(points: &[[f32; 3]], total: usize) -> Value {
    if points.is_empty() {
        return Value::Null;
    }
    let bound = |pick: fn(f32, f32) -> f32, axis: usize| {
        points.iter().map(|p| p[axis]).fold(points[0][axis], pick)
    };
    let low = [0, 1, 2].map(|axis| f64::from(bound(f32::min, axis)));
    let high = [0, 1, 2].map(|axis| f64::from(bound(f32::max, axis)));
    let extents = (0..3).map(|axis| high[axis] - low[axis]);
    let step = (extents.fold(0.0, f64::max) / f64::from(u16::MAX)).max(1e-6);
    let steps = |p: &[f32; 3]| {
        [0, 1, 2].map(|axis| ((f64::from(p[axis]) - low[axis]) / step).round() as u16)
    };
    let bytes = points.iter().flat_map(steps).flat_map(u16::to_le_bytes);
    let bytes: Vec<u8> = bytes.collect();
    json!({
        "count": points.len(),
        "total": total,
        "origin_m": low,
        "step_m": step,
        "positions": Base64::encode_string(&bytes),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_an_even_part_and_leaves_out_what_is_not_finite() {
        let mut points: Vec<[f32; 3]> = (0..40_000)
            .map(|i| [(i % 200) as f32 * 0.01, (i / 200) as f32 * 0.01, 0.0])
            .collect();
        points.push([f32::NAN, 0.0, 0.0]);
        points.push([0.0, f32::INFINITY, 0.0]);

        let thin = thinned(&points, 5000);

        assert!((2501..=5000).contains(&thin.len()), "{}", thin.len());
        assert!(thin.iter().flatten().all(|c| c.is_finite()));
        // Both halves keep their share: 10 % of a half for the cells that the border cuts.
        let left = thin.iter().filter(|p| p[0] < 1.0).count();
        assert!((left as f64 - thin.len() as f64 / 2.0).abs() < 0.1 * left as f64);
        assert_eq!(thinned(&points, 100_000).len(), 40_000);
    }

    #[test]
    fn positions_come_back_to_half_a_step() {
        let points = [[-1.5, 0.25, 0.0], [2.0, -0.75, 1.0], [0.123_45, 0.0, 0.5]];
        let cloud = record(&points, 7);
        assert_eq!(cloud["count"], 3);
        assert_eq!(cloud["total"], 7);
        let step = cloud["step_m"].as_f64().unwrap();
        // The longest side is 3.5 m.
        assert!((step - 3.5 / 65_535.0).abs() < 1e-9);
        // The first point lies at the lower x, 1 m above the lower y and at the lower z.
        let steps = (1.0 / step).round() as u16;
        let [a, b] = steps.to_le_bytes();
        let text = cloud["positions"].as_str().unwrap();
        assert!(
            text.starts_with(&Base64::encode_string(&[0, 0, a, b, 0, 0])),
            "{text}"
        );
        assert_eq!(record(&[], 9), Value::Null);
    }
}
