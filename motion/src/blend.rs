//! Convex combinations of key postures along a way.
//!
//! On fixed contacts the force points do not move, so equilibrium is linear in forces and in the
//! horizontal place of the centre of mass, and friction cones are convex: a convex combination of
//! postures in equilibrium, forces and horizontal centre of mass with the same weights, is in
//! equilibrium with forces in their cones.
//!
//!   w_0 + w_1 + … = 1,  w ≥ 0;   two keys: w_1 = u;   more: quintic steps from key to key
#![allow(non_snake_case)]

use nalgebra::{DVector, Vector3};
use robot_model::Configuration;

use crate::problem::Key;
use crate::time_scaling::quintic;

/// Key postures and what follows from them once.
pub(crate) struct Blend<'a> {
    keys: &'a [Key],
    /// Step from the first key's configuration to each.
    step: Vec<DVector<f64>>,
    sum: Vec<f64>,
}

/// The two keys between which `u` lies, and the weight of the second.
pub(crate) fn between(keys: &[Key], u: f64) -> (usize, f64) {
    if keys.len() <= 2 {
        return (0, u);
    }
    let i = keys[1..keys.len() - 1].partition_point(|key| key.u <= u);
    let (low, high) = (keys[i].u, keys[i + 1].u);
    (i, quintic((u - low) / (high - low)))
}

/// The horizontal place of the centre of mass at `u` (its height is the keys' mean too).
pub(crate) fn com_W(keys: &[Key], u: f64) -> Vector3<f64> {
    let (i, w) = between(keys, u);
    keys[i].com_W + w * (keys[i + 1].com_W - keys[i].com_W)
}

/// Force at each force point of each closed contact at `u`, N.
pub(crate) fn forces_W(keys: &[Key], u: f64) -> Vec<Vec<Vector3<f64>>> {
    let (i, w) = between(keys, u);
    keys[i]
        .forces_W
        .iter()
        .zip(&keys[i + 1].forces_W)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a + w * (b - a)).collect())
        .collect()
}

impl<'a> Blend<'a> {
    pub fn new(keys: &'a [Key]) -> Self {
        let step: Vec<_> = keys
            .iter()
            .map(|key| keys[0].q.difference(&key.q))
            .collect();
        let sum = vec![0.0; step[0].len()];
        Self { keys, step, sum }
    }

    /// Writes the combined configuration at `u`.
    pub fn configuration(&mut self, u: f64, out: &mut Configuration) {
        let (i, w) = between(self.keys, u);
        for ((sum, a), b) in self
            .sum
            .iter_mut()
            .zip(self.step[i].iter())
            .zip(self.step[i + 1].iter())
        {
            *sum = a + w * (b - a);
        }
        let first = &self.keys[0].q;
        out.p_WB = first.p_WB;
        out.R_WB = first.R_WB;
        out.joints.copy_from(&first.joints);
        out.integrate_in_place(&self.sum);
    }
}
