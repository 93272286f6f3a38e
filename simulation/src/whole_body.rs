//! The whole-body controller: accelerations and contact forces from one quadratic program.
//!
//!   min Σ w ‖A v̇ + b − a*‖² + Σ w_c ‖f_c − f_plan‖²      x = [v̇, f]
//!   s.t.  M_b v̇ + h_b = J_bᵀ f                          floating base
//!         |M_a v̇ + h_a − J_aᵀ f| ≤ 0.9 τ_max            joints
//!         f_x cos β + f_y sin β ≤ 0.7 μ cos(π/8) f_z    friction at every corner, eight sides of the cone;
//!                                                       1.15 times the plan's part of μ where that is more
//!
//! Forces act at the corners of each closed patch, drawn in by a margin: a corner outside the real
//! patch fells the robot. Torques follow as τ = M_a v̇ + h_a − J_aᵀ f.

mod cost;
mod tasks;

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{Configuration, Robot};

use crate::Error;
#[cfg(feature = "mujoco")]
use crate::clock::Capture;
use crate::corners::Corners;
use crate::dynamics::Dynamics;
use crate::physics::Physics;
use crate::qp::{RowSet, Solver};
use crate::reference::{ReferenceContact, ReferenceState};
#[cfg(feature = "mujoco")]
pub(crate) use tasks::kept;
use tasks::{Offset, contact_axes};

/// Time between two solutions, s.
pub(crate) const PERIOD_S: f64 = 0.002;
/// Part of the coefficients of friction that the controller counts on: as much as motions use where they can. A
/// floor that is wet or dusty keeps three quarters, of which a plane that is 1° off takes a twentieth. Where the plan
/// itself takes more, that and what a push asks for beside it.
const FRICTION_USE: f64 = 0.7;
const SPARE: f64 = 1.15;
/// Part of the torque limits that it uses: drives keep a little for what they do not know of. Plans use less, unless
/// they are set to use more; those cannot be executed.
const TORQUE_USE: f64 = 0.9;
/// Sides of the cone that it keeps to, whose edges are on it.
const SIDES: usize = 8;
/// Distance by which the corners, at which forces act, lie inside the patch, m.
const CORNER_INSET_M: f64 = 0.005;
/// Height of the centre of mass over its contacts, at least, for the rate at which the robot falls, m.
#[cfg(feature = "mujoco")]
const LEG_MIN_M: f64 = 0.05;
/// Forces enter the program in this unit, N: it is of the size of accelerations then.
const FORCE_UNIT_N: f64 = 100.0;

/// The controller of one robot, with its memory.
pub struct WholeBodyController<'a> {
    robot: &'a Robot,
    physics: Physics,
    corners: Vec<Corners>,
    solver: Solver,
    /// The robot as it is.
    now: Dynamics,
    /// The robot as it should be.
    reference: Dynamics,
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    rows: RowSet,
    torques: Vec<f64>,
    /// How far each patch was off its reference when it was last closed.
    offsets: Vec<Offset>,
    /// Where each closed patch was when it closed.
    held_W: Vec<Option<Vector3<f64>>>,
}

impl<'a> WholeBodyController<'a> {
    /// A controller.
    ///
    /// # Errors
    /// [`Error::Robot`] where a patch is too small for the corners' inset.
    pub fn new(robot: &'a Robot, physics: &Physics) -> Result<Self, Error> {
        let corners = |patch| Corners::new(patch, CORNER_INSET_M);
        let start = robot.neutral();
        Ok(Self {
            robot,
            physics: *physics,
            corners: robot
                .patches
                .iter()
                .map(corners)
                .collect::<Result<_, _>>()?,
            solver: Solver::default(),
            now: Dynamics::new(robot, &start),
            reference: Dynamics::new(robot, &start),
            hessian: DMatrix::zeros(0, 0),
            gradient: DVector::zeros(0),
            rows: RowSet::default(),
            torques: vec![0.0; robot.nj()],
            offsets: vec![Offset::default(); robot.patches.len()],
            held_W: vec![None; robot.patches.len()],
        })
    }

    /// The joint torques at a state; `touching` says which patches do, by the robot's patches.
    ///
    /// Shapes: v nv, result nj.  Units: N·m (N where prismatic).
    /// # Errors
    /// [`Error::Controller`] where the program has no solution.
    pub fn torques(
        &mut self,
        configuration: &Configuration,
        v: &DVector<f64>,
        wanted: &ReferenceState,
        touching: &[bool],
    ) -> Result<&[f64], Error> {
        let robot = self.robot;
        let nv = robot.nv();
        self.now.update(robot, configuration, v);
        let planned = (&wanted.configuration, &wanted.v);
        self.reference.update_motion(robot, planned.0, planned.1);
        for j in 6..nv {
            self.now.M[(j, j)] += self.physics.armature_of(robot.bodies[j - 5].effort);
            self.now.h[j] += self.physics.damping_of(&robot.bodies[j - 5]) * v[j];
        }
        // A patch that lands early bears from then on.
        let contacts = wanted.contacts.iter().chain(&wanted.landing);
        let closed: Vec<&ReferenceContact> = contacts.filter(|c| touching[c.patch]).collect();
        let J = self.corner_jacobian(&closed);
        let n = nv + J.nrows();
        self.cost(configuration, v, wanted, &closed, n);
        self.constraints(&closed, &J);
        let x = self
            .solver
            .solve(&self.hessian, self.gradient.as_slice(), &self.rows)?;
        let v_dot = DVector::from_column_slice(&x[..nv]);
        let f = DVector::from_column_slice(&x[nv..nv + J.nrows()]) * FORCE_UNIT_N;
        let whole = &self.now.M * v_dot + &self.now.h - J.tr_mul(&f);
        self.torques.copy_from_slice(&whole.as_slice()[6..]);
        Ok(&self.torques)
    }

    /// The part that a patch in the air keeps of what it was off its reference where it stood; 1 where it stands.
    #[cfg(feature = "mujoco")]
    pub(crate) fn kept_of(&self, patch: usize) -> f64 {
        self.offsets[patch].left
    }

    /// Where the capture point was when torques were last asked for: the centre of mass, and its velocity over the
    /// rate of a pendulum of its height over the contacts.
    #[cfg(feature = "mujoco")]
    pub(crate) fn capture(&self, wanted: &ReferenceState) -> Capture {
        let (now, reference) = (&self.now, &self.reference);
        let com_W = &now.kinematics.com_W;
        let heights = wanted
            .contacts
            .iter()
            .map(|c| com_W.z - c.X_WC.translation.z);
        let height_m = heights.fold(LEG_MIN_M, f64::max);
        let rate = (robot_model::GRAVITY_M_S2 / height_m).sqrt();
        let velocity_W = now.com_velocity_W - reference.com_velocity_W;
        let off_W = com_W - reference.kinematics.com_W + velocity_W / rate;
        Capture {
            off_W: off_W.xy(),
            velocity_W: reference.com_velocity_W.xy(),
        }
    }

    /// Jacobian of all corners of the closed contacts in the contacts' own axes, 3k × nv: the
    /// dual forces are in C's axes, where the friction pyramid is.
    fn corner_jacobian(&self, closed: &[&ReferenceContact]) -> DMatrix<f64> {
        let count: usize = closed.iter().map(|c| self.corners[c.patch].count()).sum();
        let mut J = DMatrix::zeros(3 * count, self.robot.nv());
        let mut row = 0;
        for contact in closed {
            let patch = &self.robot.patches[contact.patch];
            let kinematics = &self.now.kinematics;
            let X_WC = kinematics.X_WC(patch);
            let R_CW = contact_axes(&X_WC, contact, patch.point_radius_m().is_some()).transpose();
            for p_W in self.corners[contact.patch].points_W(&X_WC, contact) {
                let mut block = DMatrix::zeros(3, self.robot.nv());
                kinematics.point_jacobian(self.robot, patch.body, &p_W, &mut block);
                J.rows_mut(row, 3).copy_from(&(R_CW * block));
                row += 3;
            }
        }
        J
    }

    /// Floating base, torque limits, friction.
    fn constraints(&mut self, closed: &[&ReferenceContact], J: &DMatrix<f64>) {
        let nv = self.robot.nv();
        let (M, h, rows) = (&self.now.M, &self.now.h, &mut self.rows);
        rows.clear();
        for i in 0..nv {
            let (lower, upper) = if i < 6 {
                (-h[i], -h[i])
            } else {
                let effort = TORQUE_USE * self.robot.bodies[i - 5].effort;
                if !effort.is_finite() {
                    continue;
                }
                (-effort - h[i], effort - h[i])
            };
            for j in 0..nv {
                rows.entry(j, M[(i, j)]);
            }
            for k in 0..J.nrows() {
                rows.entry(nv + k, -J[(k, i)] * FORCE_UNIT_N);
            }
            rows.end(lower, upper);
        }
        let mut at = nv;
        let half = std::f64::consts::PI / SIDES as f64;
        for contact in closed {
            let mu = contact.friction * FRICTION_USE.max(SPARE * contact.friction_use()).min(1.0);
            for _ in 0..self.corners[contact.patch].count() {
                for side in 0..SIDES {
                    let (sin, cos) = (half * (2 * side + 1) as f64).sin_cos();
                    rows.entry(at, -cos);
                    rows.entry(at + 1, -sin);
                    rows.entry(at + 2, mu * half.cos());
                    rows.end(0.0, f64::INFINITY);
                }
                at += 3;
            }
        }
    }
}
