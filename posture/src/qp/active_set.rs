//! The dense dual active-set engine (Goldfarb and Idnani 1983), warm-started.

use sqp_craft::qp::{
    ActiveSet as WorkingSet, Activity, QpBackend, QpModel, QpOptions, QpOutcome, QpWarmStart,
};
use sqp_craft::{Bounds, CancellationToken, CsrMatrix, CsrPattern};
use sqp_craft_activeset::ActiveSetQp;

use super::{ELASTIC_WEIGHT, Failure, Program, QpEngine};
use crate::rows::Tag;

/// Keeps its memory between programs, and of the working set the rows that the next program has
/// too.
#[derive(Default)]
pub(crate) struct ActiveSet {
    backend: ActiveSetQp,
    options: Option<QpOptions>,
    model: Option<QpModel>,
    last: Option<Active>,
    /// Names of a program's rows in order, with their numbers.
    names: Vec<(Tag, u32, usize)>,
}

/// The working set of the last program.
struct Active {
    variables: Vec<Activity>,
    /// Rows in the working set by name and by which of that name, in order.
    rows: Vec<(Tag, u32, Activity)>,
}

/// Working-set changes that one program may cost beyond the first entries.
const MAX_CHANGES: u32 = 400;

impl QpEngine for ActiveSet {
    fn solve(&mut self, program: &Program) -> Result<Vec<f64>, Failure> {
        let fail = |e: &dyn std::fmt::Display| Failure(format!("active set: {e}"));
        let configured = self.options.as_ref();
        if configured.is_none_or(|options| options.hard_rows != program.hard) {
            let options = QpOptions {
                tolerance: 1e-9,
                acceptance_tolerance: 1e-5,
                max_iterations: MAX_CHANGES,
                elastic_weight: Some(ELASTIC_WEIGHT),
                hard_rows: program.hard.to_vec(),
                ..QpOptions::default()
            };
            self.backend.configure(&options).map_err(|e| fail(&e))?;
            self.options = Some(options);
        }
        let model = self.model.get_or_insert_with(empty);
        fill(model, program);
        name(&mut self.names, program.names);
        let warm = warm_start(self.last.take(), &self.names, model);
        let (warm, never) = (warm.as_ref(), CancellationToken::default());
        match self.backend.solve(model, warm, &never) {
            Ok(QpOutcome::Optimal(solution)) => {
                self.last = solution.active_set.map(|set| {
                    let rows = self.names.iter().map(|n| (n.0, n.1, set.rows[n.2]));
                    Active {
                        rows: rows.filter(|row| row.2 != Activity::Inactive).collect(),
                        variables: set.variables,
                    }
                });
                Ok(solution.step)
            }
            Ok(other) => Err(Failure(format!("active set: {other:?}"))),
            Err(e) => Err(fail(&e)),
        }
    }
}

/// Names in order, the rows of one name numbered as they come.
fn name(names: &mut Vec<(Tag, u32, usize)>, tags: &[Tag]) {
    names.clear();
    names.extend(tags.iter().enumerate().map(|(i, &tag)| (tag, 0, i)));
    names.sort_unstable();
    for i in 1..names.len() {
        if names[i].0 == names[i - 1].0 {
            names[i].1 = names[i - 1].1 + 1;
        }
    }
}

/// The last working set as far as the program still has its rows.
fn warm_start(
    last: Option<Active>,
    names: &[(Tag, u32, usize)],
    model: &QpModel,
) -> Option<QpWarmStart> {
    let last = last.filter(|last| last.variables.len() == model.n())?;
    let mut rows = vec![Activity::Inactive; model.m()];
    let mut known = names.iter().peekable();
    for (tag, number, activity) in last.rows {
        while known.next_if(|n| (n.0, n.1) < (tag, number)).is_some() {}
        if let Some(same) = known.next_if(|n| (n.0, n.1) == (tag, number)) {
            rows[same.2] = activity;
        }
    }
    Some(QpWarmStart {
        active_set: Some(WorkingSet {
            variables: last.variables,
            rows,
        }),
        ..QpWarmStart::default()
    })
}

fn empty() -> QpModel {
    let nothing = CsrMatrix {
        pattern: CsrPattern {
            rows: 0,
            cols: 0,
            indptr: Vec::new(),
            indices: Vec::new(),
        },
        values: Vec::new(),
    };
    QpModel {
        hessian_lower: nothing.clone(),
        gradient: Vec::new(),
        variables: Bounds::new(Vec::new(), Vec::new()),
        matrix: nothing,
        rows: Bounds::new(Vec::new(), Vec::new()),
    }
}

/// The program in the engine's form: lower triangle of H and A in compressed rows.
fn fill(model: &mut QpModel, program: &Program) {
    let n = program.gradient.len();
    let m = program.hard.len();
    compress(&mut model.hessian_lower, n, n, |i, push| {
        for j in 0..=i {
            push(j, program.hessian[(i, j)]);
        }
    });
    compress(&mut model.matrix, m, n, |i, push| {
        for (j, &value) in program.a[i * n..(i + 1) * n].iter().enumerate() {
            push(j, value);
        }
    });
    model.gradient.clear();
    model.gradient.extend_from_slice(program.gradient);
    for (to, from) in [
        (&mut model.variables.lower, program.lower),
        (&mut model.variables.upper, program.upper),
        (&mut model.rows.lower, program.row_lower),
        (&mut model.rows.upper, program.row_upper),
    ] {
        to.clear();
        to.extend_from_slice(from);
    }
}

/// Writes the entries that are not zero, row by row.
fn compress(
    to: &mut CsrMatrix,
    rows: usize,
    cols: usize,
    fill: impl Fn(usize, &mut dyn FnMut(usize, f64)),
) {
    let CsrMatrix { pattern, values } = to;
    (pattern.rows, pattern.cols) = (rows, cols);
    pattern.indices.clear();
    pattern.indptr.clear();
    pattern.indptr.push(0);
    values.clear();
    for i in 0..rows {
        fill(i, &mut |j, value| {
            if value != 0.0 {
                pattern.indices.push(j);
                values.push(value);
            }
        });
        pattern.indptr.push(pattern.indices.len());
    }
}
