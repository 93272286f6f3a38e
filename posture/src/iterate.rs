//! The variables of the problem and what is computed from them once an iterate.
//!
//! Variables: the configuration on SE(3) × joints and the contact forces, one 3-vector a force
//! point, written in the contact's frame and over the robot's weight. A step δ changes the base
//! position (W), the base orientation (rotation vector in W, from the left), the joints that are
//! free to move, and the forces.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Point2, Rotation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, GRAVITY_M_S2, Kinematics, Robot};
use surfaces::ConvexPolygon;

use crate::least_load::on_balls_alone;
use crate::problem::{Place, Problem};
use crate::rows::{Constraint, Tag};
use crate::{Config, Error};

/// Which variable stands where in a step.
pub(crate) struct Layout {
    /// Column of each body's joint; `None` where the joint is held.
    pub column: Vec<Option<usize>>,
    /// Number of columns of the configuration.
    pub nq: usize,
    /// First column of each force point, contact by contact; empty where not loaded.
    pub force: Vec<Vec<usize>>,
    /// Number of columns.
    pub n: usize,
}

/// A contact with everything that does not change between iterates.
pub(crate) struct ContactModel {
    pub body: usize,
    /// Radius of the ball of a point patch, m.
    pub radius: Option<f64>,
    /// Vertices of the patch in C.
    pub vertices: Vec<Point2<f64>>,
    /// Points where forces act, in C: the patch shrunk by the CoM margin, or the one of a ball.
    pub force_points: Vec<Point2<f64>>,
    /// Axes in W in which the forces are written: two tangents and the normal.
    pub axes: Matrix3<f64>,
    /// Largest tangential force over the normal one, along each tangent: the pyramid inscribed
    /// in the cone.
    pub mu_axis: f64,
}

/// Shrinks a patch by `inset_m`, at most to 40 % of its half width.
pub(crate) fn force_points(polygon: &[Point2<f64>], inset_m: f64) -> Vec<Point2<f64>> {
    let Ok(patch) = ConvexPolygon::new(polygon.to_vec()) else {
        return polygon.to_vec();
    };
    let c = patch.centroid();
    let half_width = patch
        .half_planes()
        .iter()
        .map(|h| h.b - h.n.dot(&c.coords))
        .fold(f64::MAX, f64::min);
    let inset = inset_m.min(0.6 * half_width);
    patch
        .inset(inset)
        .map_or_else(|| polygon.to_vec(), |p| p.vertices().to_vec())
}

impl Layout {
    /// Holds the joints that matter to nothing: no contact beyond them and little mass.
    pub fn new(problem: &Problem, contacts: &[ContactModel]) -> Self {
        let robot = problem.robot;
        const SMALL_MASS: f64 = 0.03;
        let mut subtree: Vec<f64> = robot.bodies.iter().map(|b| b.mass_kg).collect();
        let mut carries = vec![false; robot.bodies.len()];
        for contact in contacts {
            carries[contact.body] = true;
        }
        for i in (1..robot.bodies.len()).rev() {
            if let Some(p) = robot.bodies[i].parent {
                subtree[p] += subtree[i];
                carries[p] |= carries[i];
            }
        }
        let mut column = vec![None; robot.bodies.len()];
        let mut next = 6;
        for i in 1..robot.bodies.len() {
            if carries[i] || subtree[i] > SMALL_MASS * robot.mass_kg {
                column[i] = Some(next);
                next += 1;
            }
        }
        let nq = next;
        let mut force = Vec::new();
        for (contact, model) in problem.contacts.iter().zip(contacts) {
            let mut columns = Vec::new();
            if contact.loaded {
                for _ in &model.force_points {
                    columns.push(next);
                    next += 3;
                }
            }
            force.push(columns);
        }
        Self {
            column,
            nq,
            force,
            n: next,
        }
    }
}

impl ContactModel {
    pub fn new(problem: &Problem, index: usize, config: &Config) -> Result<Self, Error> {
        let contact = &problem.contacts[index];
        let patch = &problem.robot.patches[contact.patch];
        let axes = match &contact.place {
            Place::Fixed { X_WC, .. } => X_WC.rotation.to_rotation_matrix().into_inner(),
            Place::OnSurface { surface, .. } => problem.environment.surfaces[*surface]
                .X_WS
                .rotation
                .to_rotation_matrix()
                .into_inner(),
        };
        // How a ball is turned does not matter.
        let axes = match patch.point_radius_m() {
            Some(_) => robot_model::pyramid_axes_W(&axes),
            None => axes,
        };
        Ok(Self {
            body: patch.body,
            radius: patch.point_radius_m(),
            vertices: patch.polygon.clone(),
            force_points: force_points(&patch.polygon, config.com_margin_m),
            axes,
            mu_axis: contact.friction * config.friction_use / std::f64::consts::SQRT_2,
        })
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
pub(crate) struct Dropped {
    /// Contacts that are only drawn to their places; empty for none.
    pub places: Vec<bool>,
    /// Forces and moments need not balance.
    pub equilibrium: bool,
}

impl Dropped {
    /// Whether a contact need not be at its place.
    pub fn place(&self, contact: usize) -> bool {
        self.places.get(contact).copied().unwrap_or(false)
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
    /// The robot's weight, N.
    pub weight: f64,
    /// What is left out.
    pub dropped: Dropped,
}

impl<'a> Context<'a> {
    pub fn new(problem: &'a Problem<'a>, config: &'a Config) -> Result<Self, Error> {
        let contacts = (0..problem.contacts.len())
            .map(|i| ContactModel::new(problem, i, config))
            .collect::<Result<Vec<_>, _>>()?;
        let layout = Layout::new(problem, &contacts);
        let on_balls_alone = on_balls_alone(problem, &contacts, config);
        let weight = problem.robot.mass_kg * GRAVITY_M_S2;
        Ok(Self {
            problem,
            config,
            contacts,
            layout,
            on_balls_alone,
            weight,
            dropped: Dropped::default(),
        })
    }

    pub fn robot(&self) -> &Robot {
        self.problem.robot
    }

    /// How far inside a side of a contact's friction pyramid an upward force of one is.
    pub fn pyramid_of_up(&self, contact: usize, axis: usize, sign: f64) -> f64 {
        let model = &self.contacts[contact];
        let up = model.axes.row(2);
        model.mu_axis * up[2] + sign * up[axis]
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
                Constraint::Clearance(link(a), self.problem.environment.body_names[b].clone())
            }
            Tag::BaseGoal => Constraint::BaseGoal,
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

    /// Limits of the joint of body `i`, inside by the margin where there is room for it.
    pub fn joint_bounds(&self, i: usize) -> (f64, f64) {
        let body = &self.robot().bodies[i];
        let margin = self
            .config
            .joint_margin_rad
            .min(0.25 * (body.upper - body.lower).max(0.0));
        (body.lower + margin, body.upper - margin)
    }

    /// The iterate after `scale` times the step.
    pub fn step(&self, from: &Iterate, delta: &[f64], scale: f64, to: &mut Iterate) {
        to.q.p_WB = from.q.p_WB + scale * Vector3::new(delta[0], delta[1], delta[2]);
        let turn = scale * Vector3::new(delta[3], delta[4], delta[5]);
        to.q.R_WB = UnitQuaternion::from_rotation_matrix(&Rotation3::new(turn)) * from.q.R_WB;
        to.q.R_WB.renormalize();
        for (i, column) in self.layout.column.iter().enumerate().skip(1) {
            to.q.joints[i - 1] =
                from.q.joints[i - 1] + column.map_or(0.0, |column| scale * delta[column]);
        }
        for ((f, f0), d) in to
            .force
            .iter_mut()
            .zip(&from.force)
            .zip(&delta[self.layout.nq..])
        {
            *f = f0 + scale * d;
        }
        to.kinematics.update(self.robot(), &to.q);
    }

    /// Force in W, over the weight, at the point whose first column is `column`.
    pub fn force_W(&self, it: &Iterate, contact: usize, column: usize) -> Vector3<f64> {
        let k = column - self.layout.nq;
        self.contacts[contact].axes * Vector3::new(it.force[k], it.force[k + 1], it.force[k + 2])
    }

    /// Where a contact is wanted, in W: its fixed place, or the wanted one on its surface, or where
    /// it is.
    pub fn wanted_W(&self, it: &Iterate, contact: usize) -> Vector3<f64> {
        match &self.problem.contacts[contact].place {
            Place::Fixed { X_WC, .. } => {
                self.robot().patches[self.problem.contacts[contact].patch].touched_W(X_WC)
            }
            Place::OnSurface {
                toward: Some(p), ..
            } => p.coords,
            Place::OnSurface { .. } => self.patch_point_W(it, contact, &Point2::origin()),
        }
    }

    /// A point of a contact's patch, in W; of a ball the point that touches, `centre − radius·z`
    /// with z the touched surface's normal.
    pub fn patch_point_W(&self, it: &Iterate, contact: usize, p: &Point2<f64>) -> Vector3<f64> {
        let carried = self.carried_point_W(it, contact, p);
        let model = &self.contacts[contact];
        match model.radius {
            Some(radius) => carried - radius * model.axes.column(2),
            None => carried,
        }
    }

    /// The point of the contact's body that moves as [`Context::patch_point_W`] does, in W: the
    /// point itself, but the centre of a ball, over which the touched point slides as it turns.
    pub fn carried_point_W(&self, it: &Iterate, contact: usize, p: &Point2<f64>) -> Vector3<f64> {
        let X_BC = &self.robot().patches[self.problem.contacts[contact].patch].X_BC;
        let X_WB = &it.kinematics.X_WB[self.contacts[contact].body];
        (X_WB * (X_BC * nalgebra::Point3::new(p.x, p.y, 0.0))).coords
    }

    /// Adds `scale` times the gradient of `direction · p` to a row, p being the point `p_W` of a
    /// body.
    pub fn add_point_gradient(
        &self,
        it: &Iterate,
        body: usize,
        p_W: &Vector3<f64>,
        direction: &Vector3<f64>,
        row: &mut [f64],
    ) {
        let about_base = (p_W - it.q.p_WB).cross(direction);
        for k in 0..3 {
            row[k] += direction[k];
            row[3 + k] += about_base[k];
        }
        let mut b = body;
        while let Some(parent) = self.robot().bodies[b].parent {
            if let Some(column) = self.layout.column[b] {
                let axis = &it.kinematics.axis_W[b];
                row[column] += match self.robot().bodies[b].kind {
                    robot_model::JointKind::Prismatic => axis.dot(direction),
                    _ => axis
                        .cross(&(p_W - it.kinematics.origin_W[b]))
                        .dot(direction),
                };
            }
            b = parent;
        }
    }

    /// Adds the gradient of `direction · φ` to a row, φ being the rotation (in W) of a body.
    pub fn add_rotation_gradient(
        &self,
        it: &Iterate,
        body: usize,
        direction: &Vector3<f64>,
        row: &mut [f64],
    ) {
        for k in 0..3 {
            row[3 + k] += direction[k];
        }
        let mut b = body;
        while let Some(parent) = self.robot().bodies[b].parent {
            if let Some(column) = self.layout.column[b]
                && self.robot().bodies[b].kind != robot_model::JointKind::Prismatic
            {
                row[column] += it.kinematics.axis_W[b].dot(direction);
            }
            b = parent;
        }
    }

    /// Adds the gradient of `direction · c` to a row, c being the centre of mass.
    pub fn add_com_gradient(&self, it: &Iterate, direction: &Vector3<f64>, row: &mut [f64]) {
        let kin = &it.kinematics;
        let about_base = (kin.com_W - it.q.p_WB).cross(direction);
        for k in 0..3 {
            row[k] += direction[k];
            row[3 + k] += about_base[k];
        }
        for (b, column) in self.layout.column.iter().enumerate().skip(1) {
            let Some(column) = *column else { continue };
            let share = kin.subtree_mass[b] / self.robot().mass_kg;
            row[column] += share
                * match self.robot().bodies[b].kind {
                    robot_model::JointKind::Prismatic => kin.axis_W[b].dot(direction),
                    _ => kin.axis_W[b]
                        .cross(&(kin.subtree_com_W[b] - kin.origin_W[b]))
                        .dot(direction),
                };
        }
    }
}
