//! How much points bend off a plane: stairs and rubble are no slope.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::field::Field;
use super::joint_fit::BiasPrior;
use super::plane::{Plane, variance};

/// Edge of the cells of which means are taken, m, and the least points in one.
const CELL_M: f64 = 0.08;
const CELL_POINTS: f64 = 4.0;

/// Root mean square by which points between the edges of a plane bend beyond their noise, m: of the
/// means over cells of [`CELL_M`], once with the ring errors as they were found and once as large as
/// they may be.
///
/// Steps that the rings of a sweep cross one by one look like errors of the rings, and steps that one
/// ring crosses do not; the larger of the two is told.
pub(super) fn uneven_m(
    field: &Field,
    points: &[u32],
    plane: &Plane,
    bias_m: &[f64],
    prior: &BiasPrior,
    noise: f64,
) -> f64 {
    let [t1, t2] = plane.tangents();
    let mut cells: BTreeMap<(Option<usize>, i64, i64), [f64; 5]> = BTreeMap::new();
    for &i in points {
        let (p, ring) = (field.point(i as usize), field.ring_of(i as usize));
        let n_u = plane.normal.dot(&p) / p.norm();
        let at = |t: &Vector3<f64>| (t.dot(&p) / CELL_M).floor() as i64;
        let of_ring = |values: &[f64]| ring.map_or(0.0, |r| n_u * values[r]);
        let off = plane.distance(&p);
        let one = [
            1.0,
            off - of_ring(bias_m),
            off - of_ring(&prior.mean_m),
            noise * variance(n_u, p.norm()),
            of_ring(&prior.sigma_m).powi(2),
        ];
        let cell = cells.entry((ring, at(&t1), at(&t2))).or_default();
        cell.iter_mut().zip(one).for_each(|(sum, x)| *sum += x);
    }
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    for [n, fitted, raw, white, of_ring] in cells.into_values().filter(|c| c[0] >= CELL_POINTS) {
        squares[0] += (fitted * fitted - white) / n;
        squares[1] += (raw * raw - white) / n - of_ring;
        count += n;
    }
    (squares[0].max(squares[1]).max(0.0) / f64::max(count, 1.0)).sqrt()
}
