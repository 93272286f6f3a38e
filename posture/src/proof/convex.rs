//! The least violation of a convex problem that every posture solves: what is left of it is a proof, and where
//! nothing is left its solution is a place to begin.
//!
//!   min s   s.t.  ‖p_C − p_C*‖ ≤ s,  ‖Σ f − ẑ‖ ≤ s,  ‖Σ p × f − c × ẑ‖ ≤ s,  f ∈ K_μ
//!                 R_J a = R a,   ‖R_J Rot(a, q̄) b − R b‖ ≤ 2 sin(h/2)      (b ⊥ a, joint within q̄ ± h)
//!                 ‖R u‖ ≤ 1                                                  (nine directions u)
//!
//! over the rotation R of every body, of which only that it lengthens nothing is kept: positions, the centre of
//! mass c and, with the contacts at their places, the moments are linear in R and f. A body that a contact puts
//! has the contact's rotation, the joint next to it then turns in a plane, and its torque is linear in f.

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::{AddAssign, Range};

use nalgebra::{
    DVector, Isometry3, Matrix3, Point2, Point3, Rotation3, Unit, UnitQuaternion, Vector3,
};
use plan::Multipliers;
use robot_model::{Configuration, JointKind, Kinematics};

use crate::contact::Freedom;
use crate::iterate::Context;
use crate::outcome::{Constraint, Violation};
use cones::{Cones, Form, Least, Turn, along};

mod cones;

/// Smallest violation that counts, m and parts of the weight: over what postures may be off their contacts by
/// (1e-5 m, 1e-4 rad), times the length of a limb.
const CERTAIN: f64 = 1e-3;
/// What directions may be off by, twice.
const SLACK: f64 = 2e-4;
/// No point bears more than so many times the weight.
const FORCE_MAX: f64 = 100.0;

/// Part of the torques' limits that a seed may use with the axes of another configuration.
const SPARING: f64 = 0.95;

/// What the convex problem says.
pub(crate) enum Answer {
    /// That the robot does not reach the contacts and balance on them at once.
    Refuted(Violation),
    /// Where a search may begin.
    Seed(Configuration),
}

/// The answer where all that bears is at fixed places, for joints within ranges; near a configuration always a
/// seed, with the torques of all joints as they are there.
pub(super) fn answer(
    ctx: &Context,
    ranges: &[(f64, f64)],
    near: Option<&Kinematics>,
) -> Option<Answer> {
    let (chain, least) = Chain::solved(ctx, ranges, near)?;
    if near.is_none() && least.violation.amount > CERTAIN {
        return Some(Answer::Refuted(least.violation));
    }
    let mut x = least.x;
    x.push(1.0);
    let seed = x
        .iter()
        .all(|x| x.is_finite())
        .then(|| chain.configuration(&x.into()));
    seed.map(Answer::Seed)
}

/// What multiplies the conditions that no posture fulfils at once.
pub(super) fn multipliers(ctx: &Context, ranges: &[(f64, f64)]) -> Option<Multipliers> {
    let (chain, least) = Chain::solved(ctx, ranges, None)?;
    Some(chain.multipliers(&least.z))
}

/// Whether it is known where all forces act.
fn is_settled(ctx: &Context) -> bool {
    let contacts = ctx.problem.contacts.iter().zip(&ctx.contacts);
    let mut loaded = contacts.filter(|(contact, _)| contact.loaded);
    loaded.all(|(contact, model)| match contact.freedom {
        Freedom::Fixed => true,
        Freedom::Yaw => model.radius.is_some(),
        Freedom::Within(_) => false,
    })
}

/// The bodies, from the base outward, in forms of the variables: s; where the base is; rotations; slides; where
/// what is held has its centre of mass; forces.
struct Chain<'a> {
    ctx: &'a Context<'a>,
    cones: Cones,
    /// Bodies that contacts put.
    put: Vec<Option<Isometry3<f64>>>,
    /// First variable of each body, and of the forces.
    column: Vec<usize>,
    first_force: usize,
    /// What places are measured from: the middle of the contacts.
    middle: Vector3<f64>,
    /// Of each body: its joint's frame, in which it turns; itself; its place. Empty beyond what is held.
    joints: Vec<Option<Turn>>,
    turns: Vec<Option<Turn>>,
    places: Vec<Form>,
    /// Of each body: the rows that tie its rotation to its parent's, and the two of its joint's torque.
    hinges: Vec<Range<usize>>,
    torques: Vec<Option<usize>>,
}

impl<'a> Chain<'a> {
    /// The problem with its solution, where all that bears is at fixed places.
    fn solved(
        ctx: &'a Context<'a>,
        ranges: &[(f64, f64)],
        near: Option<&Kinematics>,
    ) -> Option<(Self, Least)> {
        if !is_settled(ctx) {
            return None;
        }
        let mut chain = Self::new(ctx);
        chain.cones.is_rough = near.is_some();
        let com = chain.build(ranges);
        chain.close();
        chain.balance(&com, near);
        let least = chain.cones.least_violation()?;
        Some((chain, least))
    }

    fn new(ctx: &'a Context<'a>) -> Self {
        let (robot, contacts) = (ctx.robot(), &ctx.problem.contacts);
        let bodies = &robot.bodies;
        let mut put = vec![None; bodies.len()];
        for (contact, model) in contacts.iter().zip(&ctx.contacts) {
            let is_put = model.radius.is_none() && contact.freedom == Freedom::Fixed;
            if is_put && bodies[model.body].kind != JointKind::Prismatic {
                let X_BC = &robot.patches[contact.patch].X_BC;
                put[model.body] = Some(contact.X_WC * X_BC.inverse());
            }
        }
        let mut n = 4;
        let mut column = Vec::with_capacity(bodies.len());
        for (b, body) in bodies.iter().enumerate() {
            column.push(n);
            let is_three = is_held(ctx, b) || body.kind == JointKind::Prismatic;
            n += match put[b] {
                Some(_) => 0,
                None if is_three => 3,
                None => 9,
            };
        }
        let loaded = ctx.layout.force.iter().map(Vec::len).sum::<usize>();
        let mut cones = Cones::new(n + 3 * loaded);
        let lengths = bodies.iter().map(|b| b.X_PJ.translation.vector.norm());
        cones.bound[1..4].fill(10.0 + 2.0 * lengths.sum::<f64>());
        cones.bound[n..].fill(2.0 * FORCE_MAX);
        let middle = contacts.iter().map(|c| c.X_WC.translation.vector);
        Self {
            ctx,
            cones,
            put,
            column,
            first_force: n,
            middle: middle.sum::<Vector3<f64>>() / contacts.len() as f64,
            joints: vec![None; bodies.len()],
            turns: vec![None; bodies.len()],
            places: vec![Form::zeros(0); bodies.len()],
            hinges: vec![0..0; bodies.len()],
            torques: vec![None; bodies.len()],
        }
    }

    /// The bodies' forms and what keeps them together; the centre of mass.
    fn build(&mut self, ranges: &[(f64, f64)]) -> Form {
        let robot = self.ctx.robot();
        let mut com = Form::zeros(self.cones.n + 1);
        for (b, body) in robot.bodies.iter().enumerate() {
            let mut place = match body.parent {
                None => self.cones.variables(1),
                Some(p) => match &self.turns[p] {
                    Some(turn) => &self.places[p] + along(turn, &body.X_PJ.translation.vector),
                    None => continue,
                },
            };
            if is_held(self.ctx, b) {
                let (mass, radius_m) = held(self.ctx, b);
                let at = self.cones.variables(self.column[b]);
                self.cones.within(&at, 1.0);
                com += (place + at * radius_m) * (mass / robot.mass_kg);
                continue;
            }
            let parent = body.parent.and_then(|p| self.turns[p].as_ref());
            let R_PJ = body.X_PJ.rotation.to_rotation_matrix();
            let joint = parent.map(|R| [0, 1, 2].map(|k| along(R, &(R_PJ * Vector3::ith(k, 1.0)))));
            let turn = match (&joint, &self.put[b]) {
                (Some(joint), _) if body.kind == JointKind::Prismatic => {
                    let by = self.cones.variables(self.column[b]);
                    self.cones.within(&by, 1.0);
                    place += by * (super::length_m(self.ctx, b) + SLACK);
                    joint.clone()
                }
                (_, Some(X)) => {
                    let R = X.rotation.to_rotation_matrix();
                    [0, 1, 2].map(|k| self.cones.constant(&R.matrix().column(k).into_owned()))
                }
                _ => {
                    let turn = [0, 3, 6].map(|k| self.cones.variables(self.column[b] + k));
                    lengthens_nothing(&mut self.cones, &turn);
                    turn
                }
            };
            if let Some(joint) = joint.as_ref().filter(|_| body.kind == JointKind::Revolute) {
                let known =
                    [body.parent, Some(b)].map(|b| b.is_some_and(|b| self.put[b].is_some()));
                let first = self.cones.rows();
                hinge(&mut self.cones, body.axis, ranges[b], [joint, &turn], known);
                self.hinges[b] = first..self.cones.rows();
            }
            com += (&place + along(&turn, &body.com_B)) * (body.mass_kg / robot.mass_kg);
            self.joints[b] = joint;
            self.turns[b] = Some(turn);
            self.places[b] = place;
        }
        com
    }

    /// Contacts at their places.
    fn close(&mut self) {
        let contacts = self.ctx.problem.contacts.iter().zip(&self.ctx.contacts);
        let contacts = contacts.enumerate();
        for (i, (contact, model)) in contacts.filter(|(_, (c, _))| c.area().is_none()) {
            let p_BC = &self.ctx.robot().patches[contact.patch]
                .X_BC
                .translation
                .vector;
            if let Some(turn) = &self.turns[model.body] {
                let wanted = self
                    .cones
                    .constant(&(contact.X_WC.translation.vector - self.middle));
                let off = &self.places[model.body] + along(turn, p_BC) - wanted;
                self.cones.violated(&off, Constraint::Closure(i));
            }
        }
    }

    /// Where a contact bears, from the middle of all.
    fn bearing(&self, i: usize) -> Vec<Vector3<f64>> {
        let model = &self.ctx.contacts[i];
        let points = model
            .force_points
            .iter()
            .take(self.ctx.layout.force[i].len());
        let at = |v: &Point2<f64>| {
            let v = Point3::new(v.x, v.y, -model.radius.unwrap_or(0.0));
            (self.ctx.problem.contacts[i].X_WC * v).coords - self.middle
        };
        points.map(at).collect()
    }

    /// Forces in their cones that balance the weight, within torques.
    fn balance(&mut self, com: &Form, near: Option<&Kinematics>) {
        let n = self.cones.n;
        let (mut force, mut moment) = (self.cones.constant(&-Vector3::z()), Form::zeros(n + 1));
        moment.row_mut(0).copy_from(&-com.row(1));
        moment.row_mut(1).copy_from(&com.row(0));
        let mut first = self.first_force;
        let mut loads = Vec::with_capacity(self.ctx.contacts.len());
        let points: Vec<Vec<Vector3<f64>>> = (0..self.ctx.contacts.len())
            .map(|i| self.bearing(i))
            .collect();
        let least_load = super::load(self.ctx, points.iter().flatten().map(|p| p.xy()));
        for (model, points) in self.ctx.contacts.iter().zip(points) {
            let (mut own_force, mut own_moment) = (Form::zeros(n + 1), Form::zeros(n + 1));
            for p in points {
                let mut f_W = model.axes * self.cones.friction(first, model.mu);
                f_W[(2, n)] += least_load;
                own_moment += p.cross_matrix() * &f_W;
                own_force += f_W;
                first += 3;
            }
            force += &own_force;
            moment += &own_moment;
            loads.push([own_force, own_moment]);
        }
        self.limit_torques(&loads, near);
        self.cones.violated(&force, Constraint::Equilibrium);
        self.cones.violated(&moment, Constraint::Balance);
    }

    /// Torques of the joints of bodies that contacts put; near a configuration those of all joints that bear a
    /// load, with the axes of there, which may be missed by s.
    fn limit_torques(&mut self, loads: &[[Form; 2]], near: Option<&Kinematics>) {
        let (ctx, n) = (self.ctx, self.cones.n);
        let robot = ctx.robot();
        for (b, body) in robot.bodies.iter().enumerate().skip(1) {
            let limit_m = body.effort * ctx.config.torque_use / ctx.weight;
            let limits = limit_m > 0.0 && limit_m.is_finite() && body.kind == JointKind::Revolute;
            let beyond = ctx.contacts.iter().zip(loads);
            let mut beyond = beyond
                .filter(|(model, _)| robot.supports(b, model.body))
                .peekable();
            if !limits || beyond.peek().is_none() {
                continue;
            }
            // The axis; what weights beyond exert about it, over the robot's, or may exert wherever they are.
            let (axis_W, o, weights_m, unsure_m) = match (near, &self.put[b]) {
                (Some(near), _) => {
                    let (axis_W, o) = (near.axis_W[b], near.origin_W[b]);
                    let lever = (near.subtree_com_W[b] - o).cross(&-Vector3::z());
                    let part = near.subtree_mass[b] / robot.mass_kg;
                    (axis_W, o, part * lever.dot(&axis_W), 0.0)
                }
                (None, Some(X)) => {
                    let (mass, radius_m) = held(ctx, b);
                    let unsure_m = mass / robot.mass_kg * radius_m + CERTAIN * limit_m;
                    (X.rotation * body.axis, X.translation.vector, 0.0, unsure_m)
                }
                _ => continue,
            };
            let (part, by_s) = if near.is_some() {
                (SPARING, 1.0)
            } else {
                (1.0, 0.0)
            };
            let arm = (o - self.middle).cross_matrix();
            let mut torque = Form::zeros(n + 1);
            for (_, [f, m]) in beyond {
                let about = m - arm * f;
                torque.row_mut(0).add_assign(axis_W.transpose() * about);
            }
            torque[(0, n)] += weights_m;
            let mut rows = Form::zeros(n + 1);
            for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
                rows.row_mut(k).copy_from(&(torque.row(0) * side));
                rows[(k, n)] += limit_m * part + unsure_m;
                rows[(k, 0)] += by_s;
            }
            self.torques[b] = Some(self.cones.rows());
            self.cones.positive(&rows, &[0, 1]);
        }
    }

    /// What multiplies the conditions, as proofs are written down.
    fn multipliers(&self, z: &[f64]) -> Multipliers {
        let bodies = &self.ctx.robot().bodies;
        let of = |what: Constraint| self.cones.multipliers(z, |other| *other == what);
        let form = |b: usize| {
            // A body that slides has the rotation of what it slides on.
            let (mut parent, mut R) = (bodies[b].parent, UnitQuaternion::identity());
            while let Some(p) = parent.filter(|&p| bodies[p].kind == JointKind::Prismatic) {
                R = bodies[p].X_PJ.rotation * R;
                parent = bodies[p].parent;
            }
            let free = parent.filter(|&p| self.put[p].is_none());
            let form = free.map(|p| self.cones.turn(z, &self.hinges[b], self.column[p]));
            let form = form.unwrap_or_default() * R.to_rotation_matrix();
            [0, 1, 2].map(|r| [0, 1, 2].map(|c| form[(r, c)]))
        };
        let joints = 1..bodies.len();
        Multipliers {
            places: (0..self.ctx.contacts.len())
                .map(|i| of(Constraint::Closure(i)))
                .collect(),
            force: of(Constraint::Equilibrium),
            moment: of(Constraint::Balance),
            about: self.middle.into(),
            torques: joints
                .clone()
                .map(|b| self.torques[b].map_or(0.0, |row| z[row] - z[row + 1]))
                .collect(),
            turns: joints.map(form).collect(),
        }
    }

    /// The configuration nearest to the variables' rotations.
    fn configuration(&self, x: &DVector<f64>) -> Configuration {
        let rotation = |R: &Turn| Matrix3::from_columns(&[&R[0] * x, &R[1] * x, &R[2] * x]);
        let mut q = self.ctx.problem.guess.clone();
        q.p_WB = &self.places[0] * x + self.middle;
        if let Some(R) = &self.turns[0] {
            let R_WB = UnitQuaternion::from_matrix_eps(&rotation(R), 1e-9, 50, q.R_WB);
            q.R_WB = R_WB;
        }
        for (b, body) in self.ctx.robot().bodies.iter().enumerate() {
            let (Some(joint), Some(turn)) = (&self.joints[b], &self.turns[b]) else {
                continue;
            };
            let R_JW = rotation(joint).transpose();
            q.joints[b - 1] = if body.kind == JointKind::Prismatic {
                let by = R_JW * x.fixed_rows::<3>(self.column[b]);
                by.dot(&body.axis) * super::length_m(self.ctx, b)
            } else {
                // The angle q for which tr(Rot(a, q)ᵀ M) is greatest.
                let M = R_JW * rotation(turn);
                let odd = M - M.transpose();
                let sin = Vector3::new(odd[(2, 1)], odd[(0, 2)], odd[(1, 0)]).dot(&body.axis);
                sin.atan2(M.trace() - body.axis.dot(&(M * body.axis)))
            };
        }
        q
    }
}

/// ‖R u‖ ≤ 1; roughly of the axes alone.
fn lengthens_nothing(cones: &mut Cones, R: &Turn) {
    for i in 0..3 {
        cones.within(&R[i], 1.0);
        let others = if cones.is_rough { 3..3 } else { i + 1..3 };
        for j in others {
            for side in [-1.0, 1.0] {
                cones.within(&((&R[i] + &R[j] * side) * FRAC_1_SQRT_2), 1.0);
            }
        }
    }
}

/// A body that turns about an axis in the frame of its joint, within limits; which of the two frames is known.
fn hinge(
    cones: &mut Cones,
    axis: Vector3<f64>,
    (lower, upper): (f64, f64),
    [joint, turn]: [&Turn; 2],
    known: [bool; 2],
) {
    if known == [true, true] {
        return;
    }
    let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower) + SLACK);
    let least = axis.iamin();
    let side = Vector3::ith(least, 1.0).cross(&axis).normalize();
    let sides = [side, axis.cross(&side)];
    let to_middle = Rotation3::from_axis_angle(&Unit::new_normalize(axis), middle);
    let at_middle = sides.map(|b| along(joint, &(to_middle * b)));
    let turned = sides.map(|b| along(turn, &b));
    cones.zero(&(along(joint, &axis) - along(turn, &axis)), &[0, 1, 2]);
    if half < PI {
        for k in 0..2 {
            let most = 2.0 * (0.5 * half).sin() + SLACK;
            cones.within(&(&at_middle[k] - &turned[k]), most);
        }
    }
    // In a plane that is known a turn is two numbers.
    let (fixed, free, axis) = match known {
        [true, _] => (at_middle, turned, along(joint, &axis)),
        [_, true] => (turned, at_middle, along(turn, &axis)),
        _ => return,
    };
    let n = cones.n;
    let [u, v, axis] = [&fixed[0], &fixed[1], &axis].map(|form| form.column(n).into_owned());
    let onto = |v: &Vector3<f64>, form: &Form| v.transpose() * form;
    let cos = onto(&u, &free[0]);
    let mut rows = Form::zeros(n + 1);
    rows.row_mut(0).copy_from(&(&cos - onto(&v, &free[1])));
    rows.row_mut(1)
        .copy_from(&(onto(&u, &free[1]) + onto(&v, &free[0])));
    cones.zero(&rows, &[0, 1]);
    for (k, free) in free.iter().enumerate() {
        rows.row_mut(k).copy_from(&onto(&axis, free));
    }
    cones.zero(&rows, &[0, 1]);
    if half < PI {
        rows.row_mut(2).copy_from(&cos);
        rows[(2, n)] -= half.cos() - SLACK;
        cones.positive(&rows, &[2]);
    }
}

/// Whether a joint is not free to move: its body then carries no contact and little mass.
fn is_held(ctx: &Context, b: usize) -> bool {
    b > 0 && ctx.layout.column[b].is_none()
}

/// The mass that a body's joint carries, kg, and how far its centre of mass may be from the joint, m.
fn held(ctx: &Context, b: usize) -> (f64, f64) {
    let bodies = &ctx.robot().bodies;
    let (mut mass, mut moment) = (0.0, 0.0);
    for i in ctx.robot().subtree(b) {
        let (mut far_m, mut at) = (bodies[i].com_B.norm(), i);
        while let Some(parent) = bodies[at].parent.filter(|_| at != b) {
            far_m += super::length_m(ctx, at);
            at = parent;
        }
        if bodies[b].kind == JointKind::Prismatic {
            far_m += super::length_m(ctx, b);
        }
        mass += bodies[i].mass_kg;
        moment += bodies[i].mass_kg * far_m;
    }
    (mass, if mass > 0.0 { moment / mass } else { 0.0 })
}
