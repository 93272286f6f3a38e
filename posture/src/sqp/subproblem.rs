//! The quadratic model of the problem at an iterate, and the step that it gives.

use nalgebra::DMatrix;

use crate::constraint::{self, Scratch};
use crate::cost;
use crate::iterate::{Context, Iterate};
use crate::qp::{self, ELASTIC_WEIGHT, Failure, Program, QpEngine};
use crate::rows::Rows;

/// Largest change of a joint or of the base's rotation in one iteration, rad (m where prismatic).
const STEP_MAX_RAD: f64 = 0.4;
/// Largest move of the base in one iteration, m.
const STEP_MAX_M: f64 = 0.3;
/// The cost's part once steps promise too little of the violation: cost and damping, not the
/// constraints, may be what holds them back.
const FAVOURED: f64 = 0.03;

/// Constraints and cost linearised at an iterate, and the engine that solves for steps.
pub(super) struct Subproblem<'a> {
    ctx: &'a Context<'a>,
    engine: Box<dyn QpEngine>,
    scratch: Scratch,
    /// The constraints at the iterate.
    rows: Rows,
    /// The constraints' values at the trial.
    trial_rows: Rows,
    gradient: Vec<f64>,
    /// The Gauss–Newton matrix, with the damping on the configuration's diagonal.
    hessian: DMatrix<f64>,
    damping: f64,
    /// Part of cost and damping that counts.
    cost_scale: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    row_lower: Vec<f64>,
    row_upper: Vec<f64>,
}

impl<'a> Subproblem<'a> {
    pub fn new(ctx: &'a Context<'a>) -> Self {
        let n = ctx.layout.n;
        Self {
            ctx,
            engine: qp::engine(ctx.config.solver.engine),
            scratch: Scratch::default(),
            rows: Rows::new(n),
            trial_rows: Rows::new(n),
            gradient: vec![0.0; n],
            hessian: DMatrix::zeros(n, n),
            damping: 0.0,
            cost_scale: 1.0,
            lower: vec![f64::NEG_INFINITY; n],
            upper: vec![f64::INFINITY; n],
            row_lower: Vec::new(),
            row_upper: Vec::new(),
        }
    }

    /// Linearises constraints and cost at the first iterate of a descent; the cost's value.
    pub fn begin(&mut self, it: &Iterate) -> f64 {
        self.cost_scale = 1.0;
        self.linearise(it)
    }

    /// Linearises constraints and cost at the iterate; the cost's value.
    pub fn linearise(&mut self, it: &Iterate) -> f64 {
        self.rows.clear(true);
        constraint::all(self.ctx, it, &mut self.scratch, &mut self.rows);
        self.damping = 0.0;
        let cost = cost::quadratic(self.ctx, it, &mut self.gradient, &mut self.hessian);
        self.scale_cost(self.cost_scale);
        self.cost_scale * cost
    }

    /// Lowers the cost for the rest of the descent, which is to raise the price of violations
    /// [byrd2008]; its value then, or nothing where it is low already.
    pub fn favour_constraints(&mut self, cost: f64) -> Option<f64> {
        if self.cost_scale < 1.0 {
            return None;
        }
        self.cost_scale = FAVOURED;
        self.damping *= FAVOURED;
        self.scale_cost(FAVOURED);
        Some(FAVOURED * cost)
    }

    fn scale_cost(&mut self, by: f64) {
        if by < 1.0 {
            self.hessian *= by;
            self.gradient.iter_mut().for_each(|g| *g *= by);
        }
    }

    /// Sum of the violations at the iterate, and the largest one.
    pub fn violation(&self) -> (f64, f64) {
        let worst = self.rows.worst().map_or(0.0, |(_, amount)| amount);
        (self.rows.total_violation(), worst)
    }

    /// Values of the constraints somewhere else, without their coefficients.
    pub fn values_at(&mut self, it: &Iterate) -> &Rows {
        self.trial_rows.clear(false);
        constraint::all(self.ctx, it, &mut self.scratch, &mut self.trial_rows);
        &self.trial_rows
    }

    /// Working memory for the evaluation at the end.
    pub fn memory(&mut self) -> (&mut Scratch, &mut Rows) {
        (&mut self.scratch, &mut self.trial_rows)
    }

    /// Takes a step to `trial`; the merit there.
    pub fn take(&mut self, it: &Iterate, delta: &[f64], trial: &mut Iterate) -> f64 {
        self.ctx.step(it, delta, trial);
        let violation = self.values_at(trial).total_violation();
        self.cost_scale * cost::value(self.ctx, trial) + ELASTIC_WEIGHT * violation
    }

    /// The step whose linear model has the constraints' values that [`Self::take`] found at the
    /// end of `delta` (second-order correction); nothing where rows came or went.
    pub fn corrected(&mut self, it: &Iterate, trust: f64, delta: &[f64]) -> Option<Vec<f64>> {
        if self.trial_rows.tag != self.rows.tag {
            return None;
        }
        let kept = self.rows.value.clone();
        for i in 0..self.rows.len() {
            self.rows.value[i] = self.trial_rows.value[i] - self.rows.change(i, delta);
        }
        let step = self.step(it, trust);
        self.rows.value = kept;
        step.ok()
    }

    /// Sets the damping of the configuration's columns.
    pub fn damp(&mut self, damping: f64) {
        let damping = self.cost_scale * damping;
        for k in 0..self.ctx.layout.nq {
            self.hessian[(k, k)] += damping - self.damping;
        }
        self.damping = damping;
    }

    /// The QP's step inside joint limits and trust region.
    pub fn step(&mut self, it: &Iterate, trust: f64) -> Result<Vec<f64>, Failure> {
        let ctx = self.ctx;
        for k in 0..6 {
            let reach = trust * self.step_max(k);
            (self.lower[k], self.upper[k]) = (-reach, reach);
        }
        for (i, column) in ctx.layout.joints() {
            let reach = trust * self.step_max(column);
            let (low, high) = ctx.joint_bounds(i);
            let q = it.q.joints[i - 1];
            self.lower[column] = (low - q).max(-reach).min(0.0);
            self.upper[column] = (high - q).min(reach).max(0.0);
        }
        let rows = &self.rows;
        let less = |bounds: &[f64], out: &mut Vec<f64>| {
            out.clear();
            out.extend(bounds.iter().zip(&rows.value).map(|(b, v)| b - v));
        };
        less(&rows.lower, &mut self.row_lower);
        less(&rows.upper, &mut self.row_upper);
        let program = Program {
            hessian: &self.hessian,
            gradient: &self.gradient,
            a: &rows.a,
            names: &rows.tag,
            row_lower: &self.row_lower,
            row_upper: &self.row_upper,
            hard: &rows.hard,
            lower: &self.lower,
            upper: &self.upper,
        };
        self.engine.solve(&program).or_else(|failure| {
            tracing::debug!("{}; trying the interior point", failure.0);
            qp::InteriorPoint.solve(&program)
        })
    }

    /// Change of the cost and sum of the violations that the linear model gives a step.
    pub fn model(&self, delta: &[f64]) -> (f64, f64) {
        let mut change = 0.0;
        for i in 0..delta.len() {
            change += self.gradient[i] * delta[i] + 0.5 * self.hessian[(i, i)] * delta[i].powi(2);
            for j in 0..i {
                change += self.hessian[(i, j)] * delta[i] * delta[j];
            }
        }
        let rows = &self.rows;
        let violation = |i: usize| {
            let value = rows.value[i] + rows.change(i, delta);
            (rows.lower[i] - value).max(value - rows.upper[i]).max(0.0)
        };
        (change, (0..rows.len()).map(violation).sum())
    }

    /// Length of a step as a part of the largest that the trust region of scale 1 allows.
    pub fn length(&self, delta: &[f64]) -> f64 {
        let steps = delta[..self.ctx.layout.nq].iter().enumerate();
        let parts = steps.map(|(k, d)| d.abs() / self.step_max(k));
        parts.fold(0.0, f64::max)
    }

    /// Largest step in a column of the configuration.
    fn step_max(&self, column: usize) -> f64 {
        let step_max = if column < 3 { STEP_MAX_M } else { STEP_MAX_RAD };
        self.ctx.config.solver.step_scale * step_max
    }
}
