//! Small linear programs with six equations: the simplex method on a dense tableau, in two phases.

/// Entries smaller than this are rounding: columns are forces over the weight, and moments in metres.
const ROUNDING: f64 = 1e-9;

/// Smaller entries are no pivots.
const PIVOT: f64 = 1e-7;

/// What the equations may be off by at the end.
const RESIDUAL: f64 = 1e-7;

/// Pivots after which the first column that helps enters instead of the best: that cannot go in circles.
const CAREFUL: usize = 100;

/// Pivots at most.
const PIVOTS: usize = 2000;

/// How a program ended without a maximum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// Nothing fulfils the equations.
    Infeasible,
    /// Rounding, or too many pivots.
    Undecided,
}

/// The largest value of the last unknown, and no more than `most`:
///
///   max x_n   s.t.  Σ x_k a_k = b,   x ≥ 0
pub(crate) fn largest_last(columns: &[[f64; 6]], b: [f64; 6], most: f64) -> Result<f64, Ended> {
    let mut tableau = Tableau::new(columns, b);
    // Phase 1: what the artificial unknowns of the rows add up to goes to nothing.
    let n = columns.len();
    let sum = |k: usize, tableau: &Tableau| tableau.rows.iter().map(|row| row[k]).sum();
    tableau.gain = (0..=n).map(|k| sum(k, &tableau)).collect();
    tableau.maximise()?;
    if tableau.gain[n] > ROUNDING.sqrt() * 1e-3 {
        return Err(Ended::Infeasible);
    }
    tableau.drop_artificial();
    // Phase 2.
    let last = n - 1;
    tableau.gain = vec![0.0; n + 1];
    tableau.gain[last] = 1.0;
    if let Some(row) = tableau.basis.iter().position(|k| *k == last) {
        let row = tableau.rows[row].clone();
        tableau.gain.iter_mut().zip(&row).for_each(|(g, x)| *g -= x);
    }
    let bounded = tableau.maximise()?;
    tableau.check(columns, b)?;
    match bounded {
        true => Ok(tableau.value(last).min(most)),
        false => Ok(most),
    }
}

struct Tableau {
    /// An entry a column, then the right-hand side.
    rows: Vec<Vec<f64>>,
    /// What is gained by a unit of each column.
    gain: Vec<f64>,
    /// The column of each row's unknown; `usize::MAX` is an artificial one.
    basis: Vec<usize>,
}

impl Tableau {
    fn new(columns: &[[f64; 6]], b: [f64; 6]) -> Self {
        let row = |i: usize| {
            let sign = if b[i] < 0.0 { -1.0 } else { 1.0 };
            let entries = columns.iter().map(|column| column[i]).chain([b[i]]);
            entries.map(|x| sign * x).collect()
        };
        Self {
            rows: (0..6).map(row).collect(),
            gain: Vec::new(),
            basis: vec![usize::MAX; 6],
        }
    }

    fn value(&self, column: usize) -> f64 {
        let row = self.basis.iter().position(|k| *k == column);
        row.map_or(0.0, |row| self.rows[row].last().copied().unwrap_or(0.0))
    }

    /// Pivots until nothing gains; whether there is a maximum.
    fn maximise(&mut self) -> Result<bool, Ended> {
        let n = self.gain.len() - 1;
        for pivots in 0..PIVOTS {
            let mut gains = (0..n).filter(|k| self.gain[*k] > ROUNDING);
            let entering = match pivots < CAREFUL {
                true => gains.max_by(|a, b| self.gain[*a].total_cmp(&self.gain[*b])),
                false => gains.next(),
            };
            let Some(column) = entering else {
                return Ok(true);
            };
            // As far as no unknown gets under nothing, but for rounding; of the rows that stop it there
            // the largest pivot, or the first unknown where circles are to be avoided.
            let rows = || {
                self.rows
                    .iter()
                    .enumerate()
                    .filter(|(_, row)| row[column] > PIVOT)
            };
            let farthest = rows().map(|(_, row)| (row[n].max(0.0) + ROUNDING) / row[column]);
            let farthest = farthest.fold(f64::INFINITY, f64::min);
            let stops = rows().filter(|(_, row)| row[n].max(0.0) / row[column] <= farthest);
            let leaving = match pivots < CAREFUL {
                true => stops.max_by(|a, b| a.1[column].total_cmp(&b.1[column])),
                false => stops.min_by_key(|(i, _)| self.basis[*i]),
            };
            let Some((row, _)) = leaving else {
                return Ok(false);
            };
            self.pivot(row, column);
        }
        Err(Ended::Undecided)
    }

    fn pivot(&mut self, row: usize, column: usize) {
        let mut own = std::mem::take(&mut self.rows[row]);
        let scale = 1.0 / own[column];
        own.iter_mut().for_each(|x| *x *= scale);
        for other in self.rows.iter_mut().chain([&mut self.gain]) {
            if let Some(&factor) = other.get(column)
                && factor != 0.0
            {
                other
                    .iter_mut()
                    .zip(&own)
                    .for_each(|(x, y)| *x -= factor * y);
            }
        }
        self.rows[row] = own;
        self.basis[row] = column;
    }

    /// Artificial unknowns that are left at nothing give way where anything can take their place.
    fn drop_artificial(&mut self) {
        let n = self.gain.len() - 1;
        for row in 0..self.rows.len() {
            if self.basis[row] != usize::MAX {
                continue;
            }
            let entries = self.rows[row][..n].iter().enumerate();
            let largest = entries.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            match largest {
                Some((column, x)) if x.abs() > ROUNDING.sqrt() => self.pivot(row, column),
                // The equation follows from the others.
                _ => self.rows[row].fill(0.0),
            }
        }
    }

    /// Whether the unknowns fulfil the equations.
    fn check(&self, columns: &[[f64; 6]], b: [f64; 6]) -> Result<(), Ended> {
        let mut left = b;
        for (row, &column) in self.rows.iter().zip(&self.basis) {
            if let Some(a) = columns.get(column) {
                let x = row[columns.len()];
                left.iter_mut().zip(a).for_each(|(left, a)| *left -= x * a);
            }
        }
        match left.iter().all(|x| x.abs() < RESIDUAL) {
            true => Ok(()),
            false => Err(Ended::Undecided),
        }
    }
}

#[cfg(test)]
mod tests {
    use microlp::{ComparisonOp, OptimizationDirection, Problem};
    use proptest::prelude::*;

    use super::*;

    fn by_microlp(columns: &[[f64; 6]], b: [f64; 6], most: f64) -> Result<f64, Ended> {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let last = columns.len() - 1;
        let variables: Vec<_> = (0..columns.len())
            .map(|k| {
                problem.add_var(
                    f64::from(k == last),
                    (0.0, if k == last { most } else { f64::INFINITY }),
                )
            })
            .collect();
        for (row, wanted) in b.into_iter().enumerate() {
            let terms = variables.iter().zip(columns).map(|(&v, c)| (v, c[row]));
            let terms: Vec<_> = terms.filter(|t| t.1.abs() > 1e-12).collect();
            problem.add_constraint(terms, ComparisonOp::Eq, wanted);
        }
        let solved = problem.solve().map_err(|_| Ended::Infeasible)?;
        let solution = solved.into_solution().map_err(|_| Ended::Undecided)?;
        Ok(solution.objective())
    }

    proptest! {
        /// Weights carried by friction cones at points anywhere, pulled to a side.
        #[test]
        fn agrees_with_another_solver(
            points in prop::collection::vec((prop::array::uniform3(-0.5..0.5_f64), 0.05..1.2_f64), 1..9),
            com in prop::array::uniform3(-0.4..0.4_f64),
            angle in 0.0..6.3_f64,
        ) {
            let mut columns = Vec::new();
            for (p, friction) in &points {
                for k in 0..16 {
                    let (sin, cos) = (f64::from(k) * 0.39).sin_cos();
                    let g = [friction * cos, friction * sin, 1.0];
                    let r = [p[0] - com[0], p[1] - com[1], p[2] - com[2]];
                    let m = [r[1] * g[2] - r[2] * g[1], r[2] * g[0] - r[0] * g[2], r[0] * g[1] - r[1] * g[0]];
                    columns.push([g[0], g[1], g[2], m[0], m[1], m[2]]);
                }
            }
            columns.push([0.0, 0.0, 0.0, angle.sin(), angle.cos(), 0.0]);
            let b = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            match (largest_last(&columns, b, 1.0), by_microlp(&columns, b, 1.0)) {
                (Ok(mine), Ok(theirs)) => prop_assert!((mine - theirs).abs() < 1e-6, "{mine} and {theirs}"),
                (mine, theirs) => prop_assert!(mine.is_ok() == theirs.is_ok(), "{mine:?} and {theirs:?}"),
            }
        }
    }
}
