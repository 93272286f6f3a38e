//! Convex combinations of keyframes along a path.
//!
//! On fixed contacts the force points do not move, but for those of balls, which roll a little
//! (`statics`), so equilibrium is linear in forces and in the horizontal place of the centre of
//! mass, and friction cones are convex: a convex combination of postures in equilibrium, forces
//! and horizontal centre of mass with the same weights, is in equilibrium with forces in their
//! cones.
//!
//!   w_0 + w_1 + … = 1,  w ≥ 0;   two keyframes: w_1 = u;   more: quintic steps from keyframe to keyframe

use nalgebra::{DVector, Vector3};
use robot_model::Configuration;

use crate::problem::Keyframe;
use crate::time_scaling::quintic;

/// Keyframes and what follows from them once.
pub(crate) struct Blend<'a> {
    keyframes: &'a [Keyframe],
    /// Step from the first keyframe's configuration to each.
    step: Vec<DVector<f64>>,
    sum: Vec<f64>,
}

/// The two keyframes between which `u` lies, and the weight of the second.
pub(crate) fn between(keyframes: &[Keyframe], u: f64) -> (usize, f64) {
    if keyframes.len() <= 2 {
        return (0, u);
    }
    let i = keyframes[1..keyframes.len() - 1].partition_point(|keyframe| keyframe.u <= u);
    let (low, high) = (keyframes[i].u, keyframes[i + 1].u);
    (i, quintic((u - low) / (high - low)))
}

/// The horizontal place of the centre of mass at `u` (its height is the keyframes' mean too).
pub(crate) fn com_W(keyframes: &[Keyframe], u: f64) -> Vector3<f64> {
    let (i, w) = between(keyframes, u);
    keyframes[i].com_W + w * (keyframes[i + 1].com_W - keyframes[i].com_W)
}

/// Force at each force point of each closed contact at `u`, N.
pub(crate) fn forces_W(keyframes: &[Keyframe], u: f64) -> Vec<Vec<Vector3<f64>>> {
    let (i, w) = between(keyframes, u);
    let between = |(a, b): (&Vec<Vector3<f64>>, &Vec<Vector3<f64>>)| {
        let points = a.iter().zip(b);
        points.map(|(a, b)| a + w * (b - a)).collect()
    };
    let contacts = keyframes[i].forces_W.iter().zip(&keyframes[i + 1].forces_W);
    contacts.map(between).collect()
}

impl<'a> Blend<'a> {
    pub fn new(keyframes: &'a [Keyframe]) -> Self {
        let steps = keyframes.iter().map(|k| keyframes[0].q.difference(&k.q));
        let step: Vec<DVector<f64>> = steps.collect();
        Self {
            keyframes,
            sum: vec![0.0; step[0].len()],
            step,
        }
    }

    /// Writes the combined configuration at `u`.
    pub fn configuration(&mut self, u: f64, out: &mut Configuration) {
        let (i, w) = between(self.keyframes, u);
        let ends = self.step[i].iter().zip(self.step[i + 1].iter());
        for (sum, (a, b)) in self.sum.iter_mut().zip(ends) {
            *sum = a + w * (b - a);
        }
        let first = &self.keyframes[0].q;
        out.p_WB = first.p_WB;
        out.R_WB = first.R_WB;
        out.joints.copy_from(&first.joints);
        out.integrate_in_place(&self.sum);
    }
}
