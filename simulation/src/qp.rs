//! The convex quadratic program of the whole-body controller.
//!
//!   min ½ xᵀHx + gᵀx   s.t.  l ≤ A x ≤ u
//!
//! Dense dual active set [goldfarb1983], warm-started from the program before it.

use nalgebra::DMatrix;
use sqp_craft::qp::{
    ActiveSet as WorkingSet, QpBackend, QpModel, QpOptions, QpOutcome, QpWarmStart,
};
use sqp_craft::{Bounds, CancellationToken, CsrMatrix, CsrPattern};
use sqp_craft_activeset::ActiveSetQp;

use crate::Error;

/// Working-set changes that one program may cost beyond the first entries.
const MAX_CHANGES: u32 = 400;

/// A solver that keeps its memory and its working set between programs.
#[derive(Default)]
pub(crate) struct Solver {
    backend: ActiveSetQp,
    last: Option<WorkingSet>,
    configured: bool,
}

/// Rows l ≤ A x ≤ u, compressed.
#[derive(Default)]
pub(crate) struct RowSet {
    indptr: Vec<usize>,
    indices: Vec<usize>,
    values: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl RowSet {
    /// No rows.
    pub fn clear(&mut self) {
        self.indptr.clear();
        self.indptr.push(0);
        self.indices.clear();
        self.values.clear();
        self.lower.clear();
        self.upper.clear();
    }

    /// Adds an entry to the row that is being written; columns ascend.
    pub fn entry(&mut self, column: usize, value: f64) {
        if value != 0.0 {
            self.indices.push(column);
            self.values.push(value);
        }
    }

    /// Ends the row.
    pub fn end(&mut self, lower: f64, upper: f64) {
        self.indptr.push(self.indices.len());
        self.lower.push(lower);
        self.upper.push(upper);
    }

    fn matrix(&self, cols: usize) -> CsrMatrix {
        CsrMatrix {
            pattern: CsrPattern {
                rows: self.lower.len(),
                cols,
                indptr: self.indptr.clone(),
                indices: self.indices.clone(),
            },
            values: self.values.clone(),
        }
    }
}

impl Solver {
    /// The minimiser x.
    ///
    /// # Errors
    /// [`Error::Controller`] where the program is infeasible or the engine gives up.
    pub fn solve(
        &mut self,
        hessian: &DMatrix<f64>,
        gradient: &[f64],
        rows: &RowSet,
    ) -> Result<Vec<f64>, Error> {
        let fail = |e: &dyn std::fmt::Display| Error::Controller(e.to_string());
        if !self.configured {
            let options = QpOptions {
                tolerance: 1e-8,
                acceptance_tolerance: 1e-5,
                max_iterations: MAX_CHANGES,
                ..QpOptions::default()
            };
            self.backend.configure(&options).map_err(|e| fail(&e))?;
            self.configured = true;
        }
        let n = gradient.len();
        let model = QpModel {
            hessian_lower: lower_triangle(hessian),
            gradient: gradient.to_vec(),
            variables: Bounds::new(vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]),
            matrix: rows.matrix(n),
            rows: Bounds::new(rows.lower.clone(), rows.upper.clone()),
        };
        let fits = |set: &WorkingSet| set.rows.len() == model.m() && set.variables.len() == n;
        let warm = self.last.take().filter(fits).map(|set| QpWarmStart {
            active_set: Some(set),
            ..QpWarmStart::default()
        });
        let (warm, never) = (warm.as_ref(), CancellationToken::default());
        match self.backend.solve(&model, warm, &never) {
            Ok(QpOutcome::Optimal(solution)) => {
                self.last = solution.active_set;
                Ok(solution.step)
            }
            Ok(other) => Err(Error::Controller(format!("{other:?}"))),
            Err(e) => Err(fail(&e)),
        }
    }
}

fn lower_triangle(matrix: &DMatrix<f64>) -> CsrMatrix {
    let n = matrix.nrows();
    let mut rows = RowSet::default();
    rows.clear();
    for i in 0..n {
        (0..=i).for_each(|j| rows.entry(j, matrix[(i, j)]));
        rows.end(0.0, 0.0);
    }
    rows.matrix(n)
}
