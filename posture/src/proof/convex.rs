//! The least violation of a convex problem that every posture solves: what is left of it is a proof.
//!
//!   min s   s.t.  ‖p_C − p_C*‖ ≤ s,  ‖Σ f − ẑ‖ ≤ s,  ‖Σ p × f − c × ẑ‖ ≤ s,  f ∈ K_μ
//!                 R_J a = R a,   ‖R_J Rot(a, q̄) b − R b‖ ≤ 2 sin(h/2)      (b ⊥ a, joint within q̄ ± h)
//!                 ‖R u‖ ≤ 1                                                  (nine directions u)
//!
//! over the rotation R of every body, of which only that it shortens nothing is kept [dai2019]: positions, the
//! centre of mass c and, with the contacts at their places, the moments are linear in R and f. A body that a
//! contact puts has the contact's rotation, the joint next to it then turns in a plane, and its torque is linear
//! in f. The engine is not believed: from its dual solution z, moved into the dual cones, follows
//!
//!   s ≥ −b·z − Σ |c + Aᵀz|_j X_j − ε Σ |z_e|
//!
//! with a bound X_j of every variable, and ε what the equalities e may be off by.
#![allow(non_snake_case)]

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::{Isometry3, Matrix3, Matrix3xX, Point3, Rotation3, Unit, Vector3};
use robot_model::JointKind;

use crate::contact::Freedom;
use crate::iterate::Context;
use crate::outcome::{Constraint, Violation};

/// Smallest violation that counts, m and parts of the weight: over what postures may be off their contacts by
/// (1e-5 m, 1e-4 rad), times the length of a limb.
const CERTAIN: f64 = 1e-3;
/// ε, and what distances between directions may be over their bounds: what joints and contacts may be off by.
const SLACK: f64 = 1e-4;
/// No point bears more than so many times the weight.
const FORCE_MAX: f64 = 100.0;

/// Three linear forms of the variables; the constant is the last column.
type Form = Matrix3xX<f64>;
/// Columns of a rotation.
type Turn = [Form; 3];

/// R v.
fn along(R: &Turn, v: &Vector3<f64>) -> Form {
    &R[0] * v.x + &R[1] * v.y + &R[2] * v.z
}

/// The cone program: rows b − A x in cones, and the bounds of the variables.
struct Cones {
    n: usize,
    /// Row, column, value.
    a: Vec<(usize, usize, f64)>,
    b: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    /// First rows of the cones that s is the top of.
    violations: Vec<(usize, Constraint)>,
    bound: Vec<f64>,
}

impl Cones {
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

    fn constant(&self, v: &Vector3<f64>) -> Form {
        let mut form = Form::zeros(self.n + 1);
        form.set_column(self.n, v);
        form
    }

    fn variables(&self, first: usize) -> Form {
        let mut form = Form::zeros(self.n + 1);
        form.fixed_view_mut::<3, 3>(0, first).fill_with_identity();
        form
    }

    fn zero(&mut self, form: &Form, rows: &[usize]) {
        rows.iter().for_each(|&k| self.row(form, k));
        self.cones.push(SupportedConeT::ZeroConeT(rows.len()));
    }

    /// ‖form‖ ≤ bound.
    fn within(&mut self, form: &Form, bound: f64) {
        self.b.push(bound);
        (0..3).for_each(|k| self.row(form, k));
        self.cones.push(SupportedConeT::SecondOrderConeT(4));
    }

    /// ‖form‖ ≤ s.
    fn violated(&mut self, form: &Form, constraint: Constraint) {
        self.violations.push((self.b.len(), constraint));
        self.a.push((self.b.len(), 0, -1.0));
        self.within(form, 0.0);
    }

    /// The constraint that is violated most, and how much is violated at least.
    fn least_violation(self) -> Option<Violation> {
        let (m, n) = (self.b.len(), self.n);
        let rows = self.a.iter().map(|e| e.0).collect();
        let columns = self.a.iter().map(|e| e.1).collect();
        let values = self.a.iter().map(|e| e.2).collect();
        let a = CscMatrix::new_from_triplets(m, n, rows, columns, values);
        let mut cost = vec![0.0; n];
        cost[0] = 1.0;
        let settings = DefaultSettings {
            verbose: false,
            ..DefaultSettings::default()
        };
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
                    z[first..first + size].iter_mut().for_each(|z| *z = z.max(0.0));
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
        unsure += left.iter().zip(&self.bound).map(|(r, x)| r.abs() * x).sum::<f64>();
        let amount = -gain - unsure;
        let most = self.violations.into_iter();
        let (_, constraint) = most.max_by(|a, b| z[a.0].total_cmp(&z[b.0]))?;
        (amount > CERTAIN).then_some(Violation { constraint, amount })
    }
}

/// Contacts, all at fixed places, that the robot does not reach and balance on at once.
pub(super) fn unreachable(ctx: &Context) -> Option<Violation> {
    let (robot, contacts) = (ctx.robot(), &ctx.problem.contacts);
    let ball = |i: usize| ctx.contacts[i].radius.is_some();
    if (0..contacts.len()).any(|i| contacts[i].freedom != Freedom::Fixed && !ball(i))
        || contacts.iter().any(|c| c.area().is_some())
    {
        return None;
    }
    let bodies = &robot.bodies;
    let slides = |b: usize| bodies[b].kind == JointKind::Prismatic;
    let is_held = |b: usize| b > 0 && ctx.layout.column[b].is_none();
    let mut put: Vec<Option<Isometry3<f64>>> = vec![None; bodies.len()];
    for (i, (contact, model)) in contacts.iter().zip(&ctx.contacts).enumerate() {
        if !ball(i) && !slides(model.body) {
            let X_BC = &robot.patches[contact.patch].X_BC;
            put[model.body] = Some(contact.X_WC * X_BC.inverse());
        }
    }
    // The variables: s; where the base is; rotations; slides; where what is held has its centre of mass; forces.
    let mut n = 4;
    let mut column = vec![0; bodies.len()];
    for b in 0..bodies.len() {
        column[b] = n;
        let parent_held = bodies[b].parent.is_some_and(is_held);
        n += match (is_held(b), slides(b), put[b]) {
            (true, ..) if parent_held => 0,
            (true, ..) | (_, true, _) => 3,
            (_, _, Some(_)) => 0,
            _ => 9,
        };
    }
    let points = || {
        let loaded = (0..contacts.len()).filter(|&i| contacts[i].loaded);
        loaded.flat_map(|i| ctx.contacts[i].force_points.iter().map(move |v| (i, v)))
    };
    let first_force = n;
    n += 3 * points().count();
    let mut bound = vec![1.0; n];
    bound[first_force..].fill(2.0 * FORCE_MAX);
    let mut cones = Cones {
        n,
        a: Vec::new(),
        b: Vec::new(),
        cones: Vec::new(),
        violations: Vec::new(),
        bound,
    };

    // 1. Bodies from the base outward: rotations and places.
    let middle = contacts.iter().map(|c| c.X_WC.translation.vector);
    let middle = middle.sum::<Vector3<f64>>() / contacts.len() as f64;
    let mut com = Form::zeros(n + 1);
    let mut turns: Vec<Turn> = Vec::with_capacity(bodies.len());
    let mut places: Vec<Form> = Vec::with_capacity(bodies.len());
    let none = || [Form::zeros(0), Form::zeros(0), Form::zeros(0)];
    let constant_turn = |cones: &Cones, R: &Matrix3<f64>| {
        [0, 1, 2].map(|k| cones.constant(&R.column(k).into_owned()))
    };
    let units = || (0..3).map(|k| Vector3::ith(k, 1.0));
    for (b, body) in bodies.iter().enumerate() {
        if body.parent.is_some_and(is_held) {
            turns.push(none());
            places.push(Form::zeros(0));
            continue;
        }
        let place = match body.parent {
            None => cones.variables(1),
            Some(p) => &places[p] + along(&turns[p], &body.X_PJ.translation.vector),
        };
        if is_held(b) {
            let (mass, radius_m) = held(ctx, b);
            let at = cones.variables(column[b]);
            cones.within(&at, 1.0);
            com += (&place + at * radius_m) * (mass / robot.mass_kg);
            turns.push(none());
            places.push(place);
            continue;
        }
        // The joint's frame, in which the body turns.
        let joint = body.parent.map(|p| {
            let R = body.X_PJ.rotation.to_rotation_matrix();
            units().map(|e| along(&turns[p], &(R * e))).collect::<Vec<_>>()
        });
        let joint: Option<Turn> = joint.and_then(|columns| columns.try_into().ok());
        let (turn, place) = match (joint, put[b]) {
            (Some(joint), _) if slides(b) => {
                let by = cones.variables(column[b]);
                cones.within(&by, 1.0);
                let most_m = body.lower.abs().max(body.upper.abs()) + SLACK;
                (joint, place + by * most_m)
            }
            (joint, at) => {
                let turn = match at {
                    Some(X) => constant_turn(&cones, X.rotation.to_rotation_matrix().matrix()),
                    None => [0, 3, 6].map(|k| cones.variables(column[b] + k)),
                };
                if at.is_none() {
                    shortens_nothing(&mut cones, &turn);
                }
                if let Some(joint) = joint {
                    let parent_put = body.parent.is_some_and(|p| put[p].is_some());
                    hinge(&mut cones, ctx, b, [&joint, &turn], [parent_put, at.is_some()]);
                }
                (turn, place)
            }
        };
        com += (&place + along(&turn, &body.com_B)) * (body.mass_kg / robot.mass_kg);
        turns.push(turn);
        places.push(place);
    }
    let reach_m: f64 = bodies.iter().map(|b| b.X_PJ.translation.vector.norm()).sum();
    cones.bound[1..4].fill(2.0 * reach_m + 10.0);

    // 2. Contacts at their places.
    for (i, (contact, model)) in contacts.iter().zip(&ctx.contacts).enumerate() {
        let p_BC = &robot.patches[contact.patch].X_BC.translation.vector;
        let off = &places[model.body] + along(&turns[model.body], p_BC)
            - cones.constant(&(contact.X_WC.translation.vector - middle));
        cones.violated(&off, Constraint::Closure(i));
    }

    // 3. Forces in their cones that balance the weight, about the middle of the contacts.
    let (mut force, mut moment) = (cones.constant(&-Vector3::z()), Form::zeros(n + 1));
    moment.row_mut(0).copy_from(&-com.row(1));
    moment.row_mut(1).copy_from(&com.row(0));
    let mut loads: Vec<[Form; 2]> = vec![[Form::zeros(n + 1), Form::zeros(n + 1)]; contacts.len()];
    for (k, (i, v)) in points().enumerate() {
        let model = &ctx.contacts[i];
        let f = cones.variables(first_force + 3 * k);
        cones.b.push(0.0);
        cones.a.push((cones.b.len() - 1, first_force + 3 * k + 2, -model.mu));
        (0..2).for_each(|k| cones.row(&f, k));
        cones.cones.push(SupportedConeT::SecondOrderConeT(3));
        let f_W = model.axes * f;
        let p = contacts[i].X_WC * Point3::new(v.x, v.y, -model.radius.unwrap_or(0.0));
        loads[i][1] += (p.coords - middle).cross_matrix() * &f_W;
        loads[i][0] += f_W;
    }
    for [f, m] in &loads {
        force += f;
        moment += m;
    }
    cones.violated(&force, Constraint::Equilibrium);
    cones.violated(&moment, Constraint::Balance);

    // 4. Torques of the joints next to contacts.
    for (model, [f, m]) in ctx.contacts.iter().zip(&loads) {
        let (b, body) = (model.body, &bodies[model.body]);
        let limit = body.effort * ctx.config.torque_use;
        let Some(X_WB) = put[b].filter(|_| limit > 0.0 && limit.is_finite()) else {
            continue;
        };
        if ctx.contacts.iter().filter(|other| robot.supports(b, other.body)).count() > 1 {
            continue;
        }
        // Weights beyond the joint, as far as they may be from it.
        let (mass, radius_m) = held(ctx, b);
        let limit_m = limit / ctx.weight + mass / robot.mass_kg * radius_m;
        let o = X_WB.translation.vector - middle;
        let torque = (m - o.cross_matrix() * f).tr_mul(&(X_WB.rotation * body.axis));
        for side in [-1.0, 1.0] {
            let mut row = Form::zeros(n + 1);
            row.row_mut(0).copy_from(&(side * torque.transpose()));
            row[(0, n)] += limit_m * (1.0 + CERTAIN);
            cones.row(&row, 0);
        }
        cones.cones.push(SupportedConeT::NonnegativeConeT(2));
    }
    cones.least_violation()
}

/// ‖R u‖ ≤ 1.
fn shortens_nothing(cones: &mut Cones, R: &Turn) {
    for i in 0..3 {
        cones.within(&R[i], 1.0);
        for j in i + 1..3 {
            for side in [-1.0, 1.0] {
                cones.within(&((&R[i] + &R[j] * side) * FRAC_1_SQRT_2), 1.0);
            }
        }
    }
}

/// A body that turns about its axis in the frame of its joint, within the joint's limits; whether either of the
/// two frames is known.
fn hinge(
    cones: &mut Cones,
    ctx: &Context,
    b: usize,
    [joint, turn]: [&Turn; 2],
    known: [bool; 2],
) {
    if known == [true, true] {
        return;
    }
    let body = &ctx.robot().bodies[b];
    let (lower, upper) = ctx.joint_bounds(b);
    let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower) + SLACK);
    let axis = body.axis;
    let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs()));
    let side = Vector3::ith(least.unwrap_or(0), 1.0).cross(&axis).normalize();
    let sides = [side, axis.cross(&side)];
    let to_middle = Rotation3::from_axis_angle(&Unit::new_normalize(axis), middle);
    let at_middle = sides.map(|b| along(joint, &(to_middle * b)));
    let turned = sides.map(|b| along(turn, &b));
    let off_axis = along(joint, &axis) - along(turn, &axis);
    cones.zero(&off_axis, &[0, 1, 2]);
    if half < PI {
        for k in 0..2 {
            let most = 2.0 * (0.5 * half).sin() + SLACK;
            cones.within(&(&at_middle[k] - &turned[k]), most);
        }
    }
    // In a plane that is known a turn is two numbers.
    let n = cones.n;
    let (fixed, free, axis) = match known {
        [true, _] => (at_middle, turned, along(joint, &axis)),
        [_, true] => (turned, at_middle, along(turn, &axis)),
        _ => return,
    };
    let constant = |form: &Form| form.column(n).into_owned();
    let onto = |v: Vector3<f64>, form: &Form| (v.transpose() * form).transpose();
    let [u, v] = [constant(&fixed[0]), constant(&fixed[1])];
    let axis = constant(&axis);
    let mut rows = Form::zeros(n + 1);
    let [uu, uv] = [onto(u, &free[0]), onto(u, &free[1])];
    let [vu, vv] = [onto(v, &free[0]), onto(v, &free[1])];
    rows.row_mut(0).tr_copy_from(&(&uu - vv));
    rows.row_mut(1).tr_copy_from(&(uv + vu));
    cones.zero(&rows, &[0, 1]);
    for k in 0..2 {
        rows.row_mut(k).tr_copy_from(&onto(axis, &free[k]));
    }
    cones.zero(&rows, &[0, 1]);
    if half < PI {
        rows.row_mut(2).tr_copy_from(&uu);
        rows[(2, n)] -= half.cos() - SLACK;
        cones.row(&rows, 2);
        cones.cones.push(SupportedConeT::NonnegativeConeT(1));
    }
}

/// The mass that a body's joint carries, kg, and how far its centre of mass may be from the joint, m.
fn held(ctx: &Context, b: usize) -> (f64, f64) {
    let bodies = &ctx.robot().bodies;
    let (mut mass, mut moment) = (0.0, 0.0);
    for i in ctx.robot().subtree(b) {
        let mut far_m = bodies[i].com_B.norm();
        let mut at = i;
        while let Some(parent) = bodies[at].parent.filter(|_| at != b) {
            far_m += super::length_m(ctx, at);
            at = parent;
        }
        if bodies[b].kind == JointKind::Prismatic {
            far_m += bodies[b].lower.abs().max(bodies[b].upper.abs());
        }
        mass += bodies[i].mass_kg;
        moment += bodies[i].mass_kg * far_m;
    }
    (mass, if mass > 0.0 { moment / mass } else { 0.0 })
}
