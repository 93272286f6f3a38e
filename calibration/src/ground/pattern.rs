//! What the device's own distortion does to a plane, cell by cell of the view.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::Samples;

/// What one cell of the device's distortion does to (η₁, η₂, d) of a plane, for a distortion there
/// of one standard deviation; rad, rad, m.
///
/// The slowly varying error is taken for constant within cells as large as the area 4π s² over
/// which it repeats itself, and independent between them. Cells are numbered alike in all frames
/// of a device, and their distortion is the same in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellEffect {
    /// Number of the cell.
    pub cell: u32,
    /// δ(η₁, η₂, d).
    pub effect: Vector3<f64>,
}

/// The effects of the cells on a plane that answers an error δw of sample i by
/// `transform` · `pull(i)` · δw, for the samples that it was fitted to.
pub(super) fn effects(
    samples: &Samples,
    fitted: impl Iterator<Item = usize>,
    pull: impl Fn(usize) -> Vector3<f64>,
    transform: &Matrix3<f64>,
) -> Vec<CellEffect> {
    if samples.pattern_ratio <= 0.0 {
        return Vec::new();
    }
    let mut sums: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
    // Samples come row by row: most have the cell of the one before.
    let mut run = (u32::MAX, Vector3::zeros());
    for i in fitted {
        let error = samples.pattern_ratio * f64::from(samples.inverse[i]);
        if samples.cells[i] != run.0 {
            *sums.entry(run.0).or_insert_with(Vector3::zeros) += run.1;
            run = (samples.cells[i], Vector3::zeros());
        }
        run.1 += pull(i) * error;
    }
    *sums.entry(run.0).or_insert_with(Vector3::zeros) += run.1;
    sums.remove(&u32::MAX);
    let effects = sums.into_iter().map(|(cell, sum)| CellEffect {
        cell,
        effect: transform * sum,
    });
    effects.collect()
}
