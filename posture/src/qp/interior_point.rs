//! Clarabel's interior point: slower, and hard to confuse.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::{ELASTIC_WEIGHT, Failure, Program, QpEngine};

/// Keeps nothing between programs.
pub(crate) struct InteriorPoint;

impl QpEngine for InteriorPoint {
    /// Variables are the step, then one t ≥ 0 a side of every soft row.
    fn solve(&mut self, program: &Program) -> Result<Vec<f64>, Failure> {
        let n = program.gradient.len();
        // (row's coefficients, relaxed, bound) of a·x − t ≤ bound, and equalities first.
        let mut equal: Vec<(Vec<(usize, f64)>, f64)> = Vec::new();
        let mut below: Vec<(Vec<(usize, f64)>, f64)> = Vec::new();
        let mut slacks = 0;
        let mut slack = |hard: bool| {
            (!hard).then(|| {
                slacks += 1;
                n + slacks - 1
            })
        };
        for (i, &hard) in program.hard.iter().enumerate() {
            let row = program.a[i * n..(i + 1) * n].iter().copied().enumerate();
            let row: Vec<(usize, f64)> = row.filter(|&(_, v)| v != 0.0).collect();
            let (lower, upper) = (program.row_lower[i], program.row_upper[i]);
            if lower == upper {
                let mut entries = row;
                if let (Some(plus), Some(minus)) = (slack(hard), slack(hard)) {
                    entries.extend([(plus, 1.0), (minus, -1.0)]);
                }
                equal.push((entries, upper));
                continue;
            }
            if upper.is_finite() {
                let mut entries = row.clone();
                entries.extend(slack(hard).map(|t| (t, -1.0)));
                below.push((entries, upper));
            }
            if lower.is_finite() {
                let mut entries: Vec<_> = row.iter().map(|&(j, v)| (j, -v)).collect();
                entries.extend(slack(hard).map(|t| (t, -1.0)));
                below.push((entries, -lower));
            }
        }
        for j in 0..n {
            if program.upper[j].is_finite() {
                below.push((vec![(j, 1.0)], program.upper[j]));
            }
            if program.lower[j].is_finite() {
                below.push((vec![(j, -1.0)], -program.lower[j]));
            }
        }
        for t in n..n + slacks {
            below.push((vec![(t, -1.0)], 0.0));
        }
        let size = n + slacks;
        let (mut hi, mut hj, mut hv) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            for j in 0..=i {
                // The upper triangle is asked for: entry (j, i).
                if program.hessian[(i, j)] != 0.0 {
                    hi.push(j);
                    hj.push(i);
                    hv.push(program.hessian[(i, j)]);
                }
            }
        }
        let h = CscMatrix::new_from_triplets(size, size, hi, hj, hv);
        let mut gradient = program.gradient.to_vec();
        gradient.resize(size, ELASTIC_WEIGHT);
        let (mut ai, mut aj, mut av, mut b) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (entries, bound) in equal.iter().chain(&below) {
            for &(j, v) in entries {
                ai.push(b.len());
                aj.push(j);
                av.push(v);
            }
            b.push(*bound);
        }
        let a = CscMatrix::new_from_triplets(b.len(), size, ai, aj, av);
        let cones = [
            SupportedConeT::ZeroConeT(equal.len()),
            SupportedConeT::NonnegativeConeT(below.len()),
        ];
        let settings = DefaultSettings {
            verbose: false,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&h, &gradient, &a, &b, &cones, settings)
            .map_err(|e| Failure(format!("interior point: {e}")))?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                Ok(solver.solution.x[..n].to_vec())
            }
            other => Err(Failure(format!("interior point: {other:?}"))),
        }
    }
}
