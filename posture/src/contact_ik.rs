//! Inverse kinematics of all contacts at once, from a seed: damped Gauss–Newton.
//!
//!   min ‖E(q)‖²  +  w_c ‖c_xy − s_xy‖²  +  w_t ‖p − p*‖²  +  step damping,   q inside the joint limits
//!
//! E: closure, inclusion, goal; c: the centre of mass, s: the middle of the contacts that can carry
//! it; p: a sole that may move, p*: where it is wanted, in the first steps only. A step costs a tenth of one
//! of the SQP's, which then begins where the contacts nearly hold.
//! Joints at a limit are held there (projected Gauss–Newton).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Point2, Vector3};

use crate::constraint;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Steps at most.
const STEPS_MAX: usize = 25;
/// Remaining error at which it ends, m.
const NEAR_M: f64 = 1e-3;
/// Part of the error that may be left after three steps.
const PROGRESS: f64 = 0.7;
/// Weight of the centre of mass against a contact's error.
const WEIGHT_COM: f64 = 0.05;
/// Weight of the place that is wanted, how far from it a contact is drawn there, m, and in how many steps.
const WEIGHT_TOWARD: f64 = 0.3;
const TOWARD_M: f64 = 0.1;
const TOWARD_STEPS: usize = 6;
/// Damping of a step against an error of one metre per radian, and its growth with the error.
const DAMPING: f64 = 1e-4;
/// Pull of the joints toward the reference, as a part of the damping.
const PULL: f64 = 0.1;
/// A joint nearer to its limit than this is at it, rad (m).
const AT_LIMIT: f64 = 1e-6;
/// Factorisations a step, each with more joints held.
const PASSES: usize = 3;
/// Largest change of a joint in one step, rad (m).
const STEP_MAX: f64 = 0.6;

/// Working memory.
pub(crate) struct ContactIk {
    rows: Rows,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    held: Vec<bool>,
    used: Vec<usize>,
    step: Vec<f64>,
}

impl ContactIk {
    pub fn new(ctx: &Context) -> Self {
        let nq = ctx.layout.nq;
        Self {
            rows: Rows::new(ctx.layout.n),
            normal: DMatrix::zeros(nq, nq),
            right: DVector::zeros(nq),
            held: vec![false; nq],
            used: Vec::with_capacity(nq),
            step: vec![0.0; ctx.layout.n],
        }
    }

    /// Moves the iterate toward its contacts; the sum of what is left, m.
    pub fn run(&mut self, ctx: &Context, it: &mut Iterate) -> f64 {
        let support = support(ctx, it);
        let mut trial = it.clone();
        let mut error = self.evaluate(ctx, it);
        // First toward the places that are wanted on their faces: between them and where patches are may be
        // what no descent gets past, another foot above all.
        for _ in 0..TOWARD_STEPS {
            if off_place_m(ctx, it) < TOWARD_M {
                break;
            }
            self.step(ctx, it, error, support, true);
            ctx.step(it, &self.step, &mut trial);
            std::mem::swap(it, &mut trial);
            error = self.evaluate(ctx, it);
        }
        let mut checkpoint = f64::INFINITY;
        for k in 0..STEPS_MAX {
            if error < NEAR_M {
                break;
            }
            if k % 3 == 2 {
                if error > PROGRESS * checkpoint {
                    break;
                }
                checkpoint = error;
            }
            self.step(ctx, it, error, support, false);
            ctx.step(it, &self.step, &mut trial);
            std::mem::swap(it, &mut trial);
            error = self.evaluate(ctx, it);
        }
        error
    }

    /// Writes the rows of the contacts and the goal; the sum of their violations.
    fn evaluate(&mut self, ctx: &Context, it: &Iterate) -> f64 {
        self.rows.clear(true);
        constraint::touching(ctx, it, &mut self.rows);
        self.rows.total_violation()
    }

    /// Solves (JᵀJ + w_c J_cᵀJ_c + D) δ = −Jᵀe − …, joints at their limits held; with `toward`, soles are
    /// drawn to where they are wanted.
    fn step(
        &mut self,
        ctx: &Context,
        it: &Iterate,
        error: f64,
        support: Option<Vector3<f64>>,
        toward: bool,
    ) {
        let nq = ctx.layout.nq;
        let damping = DAMPING * (1.0 + 30.0 * error);
        self.normal.fill(0.0);
        self.right.fill(0.0);
        for k in 0..nq {
            self.normal[(k, k)] = damping;
        }
        for (i, column) in ctx.layout.joints() {
            let away = ctx.problem.reference.joints[i - 1] - it.q.joints[i - 1];
            self.right[column] += PULL * damping * away;
        }
        if let Some(support) = support {
            let n = self.rows.n;
            for k in 0..2 {
                let e = it.kinematics.com_W[k] - support[k];
                self.rows.push(Tag::Balance, e, 0.0, 0.0);
                let start = self.rows.a.len() - n;
                let mut row = std::mem::take(&mut self.rows.a);
                ctx.add_com_gradient(it, &Vector3::ith(k, 1.0), &mut row[start..]);
                self.rows.a = row;
            }
        }
        let drawn = self.rows.len();
        for (i, place) in places(ctx).filter(|_| toward) {
            let is = ctx.patch_point_W(it, i, &Point2::origin());
            let n = self.rows.n;
            for k in 0..3 {
                self.rows.push(Tag::Closure(i), is[k] - place[k], 0.0, 0.0);
                let start = self.rows.a.len() - n;
                let row = &mut self.rows.a[start..];
                ctx.add_point_gradient(it, ctx.contacts[i].body, &is, &Vector3::ith(k, 1.0), row);
            }
        }
        for i in 0..self.rows.len() {
            let e = (self.rows.value[i] - self.rows.upper[i]).max(0.0)
                - (self.rows.lower[i] - self.rows.value[i]).max(0.0);
            let equality = self.rows.lower[i] == self.rows.upper[i];
            if e == 0.0 && !equality {
                continue;
            }
            let is_com = self.rows.tag[i] == Tag::Balance;
            let weight = if i >= drawn {
                WEIGHT_TOWARD
            } else if is_com {
                WEIGHT_COM
            } else {
                1.0
            };
            let row = &self.rows.a[i * self.rows.n..i * self.rows.n + nq];
            self.used.clear();
            self.used.extend((0..nq).filter(|&c| row[c] != 0.0));
            for (k, &c) in self.used.iter().enumerate() {
                let wa = weight * row[c];
                self.right[c] -= wa * e;
                // The lower triangle.
                let column = &mut self.normal.as_mut_slice()[c * nq..(c + 1) * nq];
                for &r in &self.used[k..] {
                    column[r] += wa * row[r];
                }
            }
        }
        self.hold_pressed(ctx, it);
        for _ in 0..PASSES {
            let free: Vec<usize> = (0..nq).filter(|&k| !self.held[k]).collect();
            let n = free.len();
            let m = DMatrix::from_fn(n, n, |r, c| self.normal[(free[r], free[c])]);
            let mut b = DVector::from_fn(n, |r, _| self.right[free[r]]);
            self.step.fill(0.0);
            let Some(factor): Option<Cholesky<f64, Dyn>> = Cholesky::new(m) else {
                return;
            };
            factor.solve_mut(&mut b);
            let longest = b.amax();
            let too_long = longest > STEP_MAX;
            let scale = if too_long { STEP_MAX / longest } else { 1.0 };
            for (&k, d) in free.iter().zip(b.iter()) {
                self.step[k] = scale * d;
            }
            if !self.hold(ctx, it) {
                break;
            }
        }
    }

    /// Holds the joints that stand at a limit and are pushed against it.
    fn hold_pressed(&mut self, ctx: &Context, it: &Iterate) {
        self.held.fill(false);
        for (i, column) in ctx.layout.joints() {
            let (lower, upper) = ctx.joint_bounds(i);
            let q = it.q.joints[i - 1];
            let push = self.right[column];
            self.held[column] =
                (q <= lower + AT_LIMIT && push < 0.0) || (q >= upper - AT_LIMIT && push > 0.0);
        }
    }

    /// Keeps the step inside the joint limits; whether a joint that was free is now held.
    fn hold(&mut self, ctx: &Context, it: &Iterate) -> bool {
        let mut more = false;
        for (i, column) in ctx.layout.joints() {
            let (lower, upper) = ctx.joint_bounds(i);
            let q = it.q.joints[i - 1];
            let clamped = self.step[column].clamp((lower - q).min(0.0), (upper - q).max(0.0));
            if clamped != self.step[column] {
                self.step[column] = clamped;
                if clamped.abs() < AT_LIMIT && !self.held[column] {
                    self.held[column] = true;
                    more = true;
                }
            }
        }
        more
    }
}

/// The soles that may move and whose heading is wanted, with the places where they are, in W: hands go where
/// the posture wants them, and balls get past each other.
fn places<'a>(ctx: &'a Context) -> impl Iterator<Item = (usize, Vector3<f64>)> + 'a {
    let contacts = ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate();
    let soles = contacts.filter(|(_, (_, model))| model.radius.is_none());
    let areas = soles.filter_map(|(i, (contact, _))| Some((i, contact.area()?)));
    let headed = areas.filter(|(_, area)| area.yaw_rad.is_some());
    headed.filter_map(|(i, area)| Some((i, area.toward?.coords)))
}

/// The farthest that a contact is from where it is wanted, m.
fn off_place_m(ctx: &Context, it: &Iterate) -> f64 {
    let off = places(ctx).map(|(i, to)| (ctx.patch_point_W(it, i, &Point2::origin()) - to).norm());
    off.fold(0.0, f64::max)
}

/// Where the centre of mass should be: the middle of the contacts whose normals point up.
fn support(ctx: &Context, it: &Iterate) -> Option<Vector3<f64>> {
    let mut sum = Vector3::zeros();
    let mut count = 0.0;
    for (i, (contact, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        let z = model.axes[(2, 2)];
        if contact.loaded && z > 0.7 {
            sum += ctx.wanted_W(it, i);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}
