//! The quadratic programs of the SQP, behind one trait so that engines can be exchanged.
//!
//!   min ½ δᵀHδ + gᵀδ + γ Σ |t_i|   s.t.  l ≤ Aδ + t ≤ u,  lower ≤ δ ≤ upper
//!
//! Rows that are not hard are relaxed by t at the price γ (elastic mode), so that every program
//! has a solution.

mod active_set;
mod interior_point;

use nalgebra::DMatrix;

use crate::config::Engine;
use crate::rows::Tag;

pub(crate) use active_set::ActiveSet;
pub(crate) use interior_point::InteriorPoint;

/// Price γ of a violated row: above the multipliers of problems that have a posture.
pub(crate) const ELASTIC_WEIGHT: f64 = 100.0;

/// One quadratic program.
pub(crate) struct Program<'a> {
    /// H, n × n, positive definite; the lower triangle is read.
    pub hessian: &'a DMatrix<f64>,
    /// g, n.
    pub gradient: &'a [f64],
    /// A, row-major, m × n.
    pub a: &'a [f64],
    /// What each row speaks of: the same names in two programs are the same rows, m.
    pub names: &'a [Tag],
    /// l, m.
    pub row_lower: &'a [f64],
    /// u, m.
    pub row_upper: &'a [f64],
    /// Rows that are never relaxed, m.
    pub hard: &'a [bool],
    /// Bounds of δ, n.
    pub lower: &'a [f64],
    /// Bounds of δ, n.
    pub upper: &'a [f64],
}

/// Why an engine gave no solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure(pub String);

/// A solver of quadratic programs.
pub(crate) trait QpEngine {
    /// The minimiser δ, n.
    fn solve(&mut self, program: &Program) -> Result<Vec<f64>, Failure>;
}

/// The engine that the settings name.
pub(crate) fn engine(kind: Engine) -> Box<dyn QpEngine> {
    match kind {
        Engine::ActiveSet => Box::new(ActiveSet::default()),
        Engine::InteriorPoint => Box::new(InteriorPoint),
    }
}
