//! The dense dual active-set engine (Goldfarb and Idnani 1983), warm-started.

use sqp_craft::qp::{
    ActiveSet as WorkingSet, QpBackend, QpModel, QpOptions, QpOutcome, QpWarmStart,
};
use sqp_craft::{Bounds, CancellationToken, CsrMatrix, CsrPattern};
use sqp_craft_activeset::ActiveSetQp;

use super::{Failure, Program, QpEngine};

/// Keeps its memory between programs, and the working set where the next program has the same
/// shape.
#[derive(Default)]
pub(crate) struct ActiveSet {
    backend: ActiveSetQp,
    last: Option<WorkingSet>,
}

/// Working-set changes that one program may cost beyond the first entries.
const MAX_CHANGES: u32 = 400;

impl QpEngine for ActiveSet {
    fn solve(&mut self, program: &Program) -> Result<Vec<f64>, Failure> {
        let fail = |e: &dyn std::fmt::Display| Failure(format!("active set: {e}"));
        self.backend
            .configure(&QpOptions {
                tolerance: 1e-9,
                acceptance_tolerance: 1e-5,
                max_iterations: MAX_CHANGES,
                elastic_weight: Some(program.elastic_weight),
                hard_rows: program.hard.to_vec(),
                ..QpOptions::default()
            })
            .map_err(|e| fail(&e))?;
        let model = model(program);
        let warm = self
            .last
            .take()
            .filter(|set| set.rows.len() == model.m() && set.variables.len() == model.n())
            .map(|set| QpWarmStart {
                active_set: Some(set),
                ..QpWarmStart::default()
            });
        match self
            .backend
            .solve(&model, warm.as_ref(), &CancellationToken::default())
        {
            Ok(QpOutcome::Optimal(solution)) => {
                self.last = solution.active_set;
                Ok(solution.step)
            }
            Ok(other) => Err(Failure(format!("active set: {other:?}"))),
            Err(e) => Err(fail(&e)),
        }
    }
}

/// The program in the engine's form: lower triangle of H and A in compressed rows.
fn model(program: &Program) -> QpModel {
    let n = program.gradient.len();
    let m = program.hard.len();
    let hessian = compressed(n, n, |i, push| {
        for j in 0..=i {
            let value = program.hessian[(i, j)];
            if value != 0.0 {
                push(j, value);
            }
        }
    });
    let matrix = compressed(m, n, |i, push| {
        for (j, &value) in program.a[i * n..(i + 1) * n].iter().enumerate() {
            if value != 0.0 {
                push(j, value);
            }
        }
    });
    QpModel {
        hessian_lower: hessian,
        gradient: program.gradient.to_vec(),
        variables: Bounds::new(program.lower.to_vec(), program.upper.to_vec()),
        matrix,
        rows: Bounds::new(program.row_lower.to_vec(), program.row_upper.to_vec()),
    }
}

fn compressed(
    rows: usize,
    cols: usize,
    mut fill: impl FnMut(usize, &mut dyn FnMut(usize, f64)),
) -> CsrMatrix {
    let (mut indptr, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in 0..rows {
        fill(i, &mut |j, value| {
            indices.push(j);
            values.push(value);
        });
        indptr.push(indices.len());
    }
    CsrMatrix {
        pattern: CsrPattern {
            rows,
            cols,
            indptr,
            indices,
        },
        values,
    }
}
