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

use std::ops::Range;

use nalgebra::{DVector, Isometry3, Matrix3, UnitQuaternion, Vector3};
use plan::Multipliers;
use robot_model::{Configuration, JointKind, Kinematics};

use crate::contact::Freedom;
use crate::iterate::Context;
use crate::outcome::{Constraint, Violation};
use cones::{Cones, Form, Least, Turn, along};
use turns::{hinge, lengthens_nothing};

mod cones;
mod forces;
mod multipliers;
mod turns;

/// Smallest violation that counts, m and parts of the weight: over what postures may be off their contacts by
/// (1e-5 m), and forces off the weight; what directions may be off by, over the length of a limb, is in [`SLACK`].
const CERTAIN: f64 = 1e-4;
/// Part of a torque's limit that directions of axes which are off may make of the forces.
const TORQUE: f64 = 1e-3;
/// What directions may be off by (1e-4 rad), twice.
const SLACK: f64 = 2e-4;
/// No point bears more than so many times the weight.
const FORCE_MAX: f64 = 100.0;

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
                    place += by * (body.apart_m() + SLACK);
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
                by.dot(&body.axis) * body.apart_m()
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
            far_m += bodies[at].apart_m();
            at = parent;
        }
        if bodies[b].kind == JointKind::Prismatic {
            far_m += bodies[b].apart_m();
        }
        mass += bodies[i].mass_kg;
        moment += bodies[i].mass_kg * far_m;
    }
    (mass, if mass > 0.0 { moment / mass } else { 0.0 })
}
