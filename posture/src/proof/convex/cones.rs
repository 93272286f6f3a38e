//! A cone program whose least value is proved by its dual solution: the engine is not believed. With z moved
//! into the dual cones
//!
//!   s ≥ −b·z − Σ |c + Aᵀz|_j X_j − ε Σ |z_e|
//!
//! with a bound X_j of every variable, and ε what the equalities e may be off by.

use std::ops::Range;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::{Matrix3, Matrix3xX, Vector3};

use super::SLACK;
use crate::outcome::{Constraint, Violation};

/// What a place to begin may be off by.
const ROUGH: f64 = 1e-5;

/// Three linear forms of the variables; the constant is the last column.
pub type Form = Matrix3xX<f64>;
/// Columns of a rotation.
pub type Turn = [Form; 3];

/// R v.
pub fn along(R: &Turn, v: &Vector3<f64>) -> Form {
    &R[0] * v.x + &R[1] * v.y + &R[2] * v.z
}

/// The cone program: rows b − A x in cones, and the bounds of the variables.
pub struct Cones {
    /// Number of variables; the first is s.
    pub n: usize,
    /// Row, column, value.
    a: Vec<(usize, usize, f64)>,
    b: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    /// First rows of the cones that s is the top of.
    violations: Vec<(usize, Constraint)>,
    /// Largest value of every variable.
    pub bound: Vec<f64>,
    /// Whether a place to begin is wanted and no proof: that costs less than half.
    pub is_rough: bool,
}

/// The least violation: the variables, what multiplies every row, which constraint is violated most and how much
/// at least.
pub struct Least {
    pub x: Vec<f64>,
    pub z: Vec<f64>,
    pub violation: Violation,
}

impl Cones {
    pub fn new(n: usize) -> Self {
        Self {
            n,
            a: Vec::new(),
            b: Vec::new(),
            cones: Vec::new(),
            violations: Vec::new(),
            bound: vec![1.0; n],
            is_rough: false,
        }
    }

    /// A row with the value of the form's row k.
    fn row(&mut self, form: &Form, k: usize) {
        let i = self.b.len();
        for (j, v) in form.row(k).iter().enumerate() {
            if j == self.n {
                self.b.push(*v);
            } else if *v != 0.0 {
                self.a.push((i, j, -v));
            }
        }
    }

    /// A form of no variable.
    pub fn constant(&self, v: &Vector3<f64>) -> Form {
        let mut form = Form::zeros(self.n + 1);
        form.set_column(self.n, v);
        form
    }

    /// Three variables.
    pub fn variables(&self, first: usize) -> Form {
        let mut form = Form::zeros(self.n + 1);
        form.fixed_view_mut::<3, 3>(0, first).fill_with_identity();
        form
    }

    /// Rows of a form that are zero.
    pub fn zero(&mut self, form: &Form, rows: &[usize]) {
        rows.iter().for_each(|&k| self.row(form, k));
        self.cones.push(SupportedConeT::ZeroConeT(rows.len()));
    }

    /// ‖form‖ ≤ bound.
    pub fn within(&mut self, form: &Form, bound: f64) {
        self.b.push(bound);
        (0..3).for_each(|k| self.row(form, k));
        self.cones.push(SupportedConeT::SecondOrderConeT(4));
    }

    /// Rows of a form that are not negative.
    pub fn positive(&mut self, form: &Form, rows: &[usize]) {
        rows.iter().for_each(|&k| self.row(form, k));
        self.cones
            .push(SupportedConeT::NonnegativeConeT(rows.len()));
    }

    /// A force in axes of which the last is the cone's.
    pub fn friction(&mut self, first: usize, mu: f64) -> Form {
        let f = self.variables(first);
        self.row(&(&f * mu), 2);
        (0..2).for_each(|k| self.row(&f, k));
        self.cones.push(SupportedConeT::SecondOrderConeT(3));
        f
    }

    /// ‖form‖ ≤ s.
    pub fn violated(&mut self, form: &Form, constraint: Constraint) {
        self.violations.push((self.b.len(), constraint));
        self.a.push((self.b.len(), 0, -1.0));
        self.within(form, 0.0);
    }

    /// Number of rows so far.
    pub fn rows(&self) -> usize {
        self.b.len()
    }

    /// The multipliers of a form that s bounds, where it is that of a constraint.
    pub fn multipliers(&self, z: &[f64], of: impl Fn(&Constraint) -> bool) -> [f64; 3] {
        let first = self.violations.iter().find(|(_, what)| of(what));
        first.map_or([0.0; 3], |(row, _)| [1, 2, 3].map(|k| -z[row + k]))
    }

    /// Σ z_i A_ij over some rows, for nine columns.
    pub fn turn(&self, z: &[f64], rows: &Range<usize>, first: usize) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for &(i, j, v) in self.a.iter().filter(|(i, ..)| rows.contains(i)) {
            if (first..first + 9).contains(&j) {
                sum.as_mut_slice()[j - first] += z[i] * v;
            }
        }
        sum
    }

    /// The variables at the least violation, and what it is at least.
    pub fn least_violation(&self) -> Option<Least> {
        let (m, n) = (self.b.len(), self.n);
        let rows = self.a.iter().map(|e| e.0).collect();
        let columns = self.a.iter().map(|e| e.1).collect();
        let values = self.a.iter().map(|e| e.2).collect();
        let a = CscMatrix::new_from_triplets(m, n, rows, columns, values);
        let mut cost = vec![0.0; n];
        cost[0] = 1.0;
        let mut settings = DefaultSettings {
            verbose: false,
            ..DefaultSettings::default()
        };
        if self.is_rough {
            settings.tol_gap_abs = ROUGH;
            settings.tol_gap_rel = ROUGH;
            settings.tol_feas = ROUGH;
        }
        let h = CscMatrix::zeros((n, n));
        let solver = DefaultSolver::new(&h, &cost, &a, &self.b, &self.cones, settings);
        let mut solver = solver.ok()?;
        solver.solve();
        let mut z = std::mem::take(&mut solver.solution.z);
        let (mut first, mut unsure) = (0, 0.0);
        for cone in &self.cones {
            first += match *cone {
                SupportedConeT::ZeroConeT(size) => {
                    unsure += SLACK * z[first..first + size].iter().map(|z| z.abs()).sum::<f64>();
                    size
                }
                SupportedConeT::SecondOrderConeT(size) => {
                    let side = &z[first + 1..first + size];
                    let least = side.iter().map(|z| z * z).sum::<f64>().sqrt();
                    z[first] = z[first].max(least);
                    size
                }
                SupportedConeT::NonnegativeConeT(size) => {
                    z[first..first + size]
                        .iter_mut()
                        .for_each(|z| *z = z.max(0.0));
                    size
                }
                _ => return None,
            };
        }
        let mut left = cost;
        for &(i, j, v) in &self.a {
            left[j] += v * z[i];
        }
        let gain: f64 = self.b.iter().zip(&z).map(|(b, z)| b * z).sum();
        unsure += left
            .iter()
            .zip(&self.bound)
            .map(|(r, x)| r.abs() * x)
            .sum::<f64>();
        let amount = -gain - unsure;
        let most = self.violations.iter();
        let (_, constraint) = most.max_by(|a, b| z[a.0].total_cmp(&z[b.0]))?;
        let constraint = constraint.clone();
        Some(Least {
            x: solver.solution.x,
            z,
            violation: Violation { constraint, amount },
        })
    }
}
