//! The variables of the problem, and what is computed from them once per iterate.
//!
//! Variables: the configuration on SE(3) × joints and the contact forces, one 3-vector a force
//! point, written in the contact's frame and over the robot's weight. A step δ changes the base
//! position (W), the base orientation (rotation vector in W, from the left), the joints that are
//! free to move, and the forces.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};

use crate::Config;
use crate::layout::{ContactModel, Layout};
use crate::least_load::on_balls_alone;
use crate::problem::Problem;
use crate::rows::{Constraint, Tag};

/// A pyramid inscribed in the friction cone: t·f_t ≤ part μ f_z for each side's tangential direction t, in the
/// contact's axes.
pub(crate) struct Pyramid {
    pub sides: Vec<[f64; 2]>,
    pub part: f64,
}

impl Pyramid {
    /// Sides of the fine one.
    const SIDES: usize = 24;

    /// Four sides, edges along the axes' diagonals: up to 29 % of the friction is lost across the load.
    pub fn coarse() -> Self {
        Self {
            sides: vec![[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]],
            part: FRAC_1_SQRT_2,
        }
    }

    /// At most 0.9 % is lost.
    pub fn fine() -> Self {
        let side = |k| {
            let (sin, cos) = (TAU * k as f64 / Self::SIDES as f64).sin_cos();
            [cos, sin]
        };
        Self {
            sides: (0..Self::SIDES).map(side).collect(),
            part: (PI / Self::SIDES as f64).cos(),
        }
    }
}

/// An iterate: the variables and what follows from them.
#[derive(Clone)]
pub(crate) struct Iterate {
    pub q: Configuration,
    /// Forces in the order of the columns, over the weight, in the contacts' axes.
    pub force: Vec<f64>,
    pub kinematics: Kinematics,
}

/// Constraints that are left out, to find out which of them matter.
#[derive(Clone, Debug, Default)]
pub(crate) struct Relaxed {
    /// Contacts that are only drawn to their places, contact by contact; empty for none.
    pub places: Vec<bool>,
    /// Whether forces and moments need not balance.
    pub equilibrium: bool,
}

impl Relaxed {
    /// Whether a contact need not be at its place.
    pub fn place(&self, contact: usize) -> bool {
        self.places.get(contact).copied().unwrap_or(false)
    }

    /// Whether every constraint is kept.
    pub fn is_nothing(&self) -> bool {
        !self.equilibrium && !self.places.contains(&true)
    }
}

/// What stays the same during one solve.
pub(crate) struct Context<'a> {
    pub problem: &'a Problem<'a>,
    pub config: &'a Config,
    pub contacts: Vec<ContactModel>,
    pub layout: Layout,
    /// Whether the centre of mass keeps its margin by what every ball bears.
    pub on_balls_alone: bool,
    /// What stands for the friction cones.
    pub pyramid: Pyramid,
    /// The robot's weight, N.
    pub weight: f64,
    /// What is left out.
    pub relaxed: Relaxed,
}

impl<'a> Context<'a> {
    /// With coarse friction pyramids.
    pub fn new(problem: &'a Problem<'a>, config: &'a Config, relaxed: Relaxed) -> Self {
        let models = (0..problem.contacts.len()).map(|i| ContactModel::new(problem, i, config));
        let contacts: Vec<ContactModel> = models.collect();
        Self {
            problem,
            config,
            layout: Layout::new(problem, &contacts),
            on_balls_alone: on_balls_alone(problem, &contacts, config),
            contacts,
            pyramid: Pyramid::coarse(),
            weight: problem.robot.mass_kg * GRAVITY_M_S2,
            relaxed,
        }
    }

    pub fn robot(&self) -> &Robot {
        self.problem.robot
    }

    /// By how much an upward force of one fulfils t·f_t ≤ μ f_z at a contact.
    pub fn up_inside(&self, contact: usize, [x, y]: [f64; 2], mu: f64) -> f64 {
        let up = self.contacts[contact].axes.row(2);
        mu * up[2] - x * up[0] - y * up[1]
    }

    /// What a row speaks of, with names.
    pub fn constraint(&self, tag: Tag) -> Constraint {
        let link = |shape: usize| self.robot().collision.shapes()[shape].link.clone();
        match tag {
            Tag::Closure(i) => Constraint::Closure(i),
            Tag::Inclusion(i) => Constraint::Inclusion(i),
            Tag::Equilibrium => Constraint::Equilibrium,
            Tag::Balance => Constraint::Balance,
            Tag::Friction(i) => Constraint::Friction(i),
            Tag::Torque(b) => Constraint::Torque(b),
            Tag::SelfClearance(a, b) => Constraint::SelfClearance(link(a), link(b)),
            Tag::Clearance(a, b) => {
                Constraint::Clearance(link(a), self.problem.environment.body_name(b).to_owned())
            }
            Tag::BaseGoal => Constraint::BaseGoal,
            Tag::BaseTilt => Constraint::BaseTilt,
        }
    }

    /// The iterate at a guess, with the weight shared evenly by the loaded contacts. Joints are
    /// moved inside their limits.
    pub fn start(&self, guess: &Configuration) -> Iterate {
        let mut q = guess.clone();
        for (i, body) in self.robot().bodies.iter().enumerate().skip(1) {
            let (lower, upper) = self.joint_bounds(i);
            if body.lower < body.upper {
                q.joints[i - 1] = q.joints[i - 1].clamp(lower, upper);
            }
        }
        let count: usize = self.layout.force.iter().map(Vec::len).sum();
        let mut force = vec![0.0; 3 * count];
        for f in force.chunks_exact_mut(3) {
            f[2] = 1.0 / count as f64;
        }
        let kinematics = Kinematics::new(self.robot(), &q);
        Iterate {
            q,
            force,
            kinematics,
        }
    }

    /// Limits of the joint of body `i`, inside by the margin where there is room for it, and where it must be about a
    /// value, no farther from that; a margin that leaves no room there gives way.
    pub fn joint_bounds(&self, i: usize) -> (f64, f64) {
        let body = &self.robot().bodies[i];
        let margin = body.kept_margin(self.config.joint_margin_rad);
        let (lower, upper) = (body.lower + margin, body.upper - margin);
        let Some((wanted, tolerance)) = self.problem.wanted(i) else {
            return (lower, upper);
        };
        let (least, most) = (wanted - tolerance, wanted + tolerance);
        (lower.max(least).min(most), upper.min(most).max(least))
    }

    /// Writes the iterate after a step to `to`.
    pub fn step(&self, from: &Iterate, delta: &[f64], to: &mut Iterate) {
        to.q.p_WB = from.q.p_WB + Vector3::new(delta[0], delta[1], delta[2]);
        let turn = Vector3::new(delta[3], delta[4], delta[5]);
        to.q.R_WB = UnitQuaternion::from_rotation_matrix(&Rotation3::new(turn)) * from.q.R_WB;
        to.q.R_WB.renormalize();
        for (i, column) in self.layout.column.iter().enumerate().skip(1) {
            to.q.joints[i - 1] = from.q.joints[i - 1] + column.map_or(0.0, |column| delta[column]);
        }
        let forces = from.force.iter().zip(&delta[self.layout.nq..]);
        for (f, (f0, d)) in to.force.iter_mut().zip(forces) {
            *f = f0 + d;
        }
        to.kinematics.update(self.robot(), &to.q);
    }
}
