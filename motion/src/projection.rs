//! The configuration nearest to a reference on which contacts are closed, the patch in the air is
//! at its pose and the centre of mass above its place.
//!
//!   min ½ ‖δ‖²_{W⁻¹} + ½ ‖s‖²   s.t.   r(q_ref ⊕ δ) + e s = 0,   lower ≤ q ≤ upper,   d ≥ d_min
//!
//! r = (p − p*, log R R*ᵀ) a patch, (c − c*)_xy; e is zero but for the orientation of a patch that
//! is far from both its ends. Sequential linearisation; the QP in dual form, the equations by
//! Cholesky, the few inequalities by projected Gauss–Seidel.
#![allow(non_snake_case)]

use crate::dense::{cholesky, cholesky_solve, dot};
use crate::inequalities::Inequalities;
use crate::near::Near;
use nalgebra::{DMatrixViewMut, DVector, Isometry3, Point3, Vector3};
use robot_model::{Configuration, Kinematics, PatchId, PatchKind, Robot};

/// Lever arm that turns an angle into a length, m.
const ANGLE_ARM_M: f64 = 0.1;
/// Largest change of a coordinate in one step, rad or m.
const STEP_MAX: f64 = 0.5;
/// Iterations at most.
const ITERATIONS_MAX: usize = 24;
/// Iterations after which the reference no longer counts: what does not settle is at least closed.
const FINISH: usize = 14;
/// The distances are measured every so many iterations.
const LOOK_EVERY: usize = 3;
/// Newton steps that close a sample at most, and the residual below which none is needed, m and rad.
const CLOSING: usize = 3;
const CLOSED: f64 = 1e-7;
/// A step longer than this part of the one before it is damped.
const SHRINK: f64 = 0.5;
/// Below this residual (m, rad) the equations hold.
const DONE: f64 = 1e-9;
/// A step below this (rad, m) no longer changes the solution.
const STILL: f64 = 1e-6;
/// Joint bounds become inequalities where the solution without them comes this near, rad or m.
const NEAR_BOUND: f64 = 0.02;

/// The equations: where patches and the centre of mass are to be.
pub(crate) struct Target {
    /// Patch and wanted pose.
    pub patches: Vec<(PatchId, Isometry3<f64>)>,
    /// How readily the last patch turns from its pose: 0 not at all, 1 as a joint does.
    pub turn_freedom: f64,
    /// Wanted horizontal place of the centre of mass.
    pub com_W: Vector3<f64>,
}

/// The inequalities: joint bounds and distances.
pub(crate) struct Bounds<'a> {
    /// Lower and upper bound of every joint.
    pub joints: &'a [(f64, f64)],
    /// Distances to keep: nothing, or a list that is filled at every iterate.
    pub near: Option<&'a Look<'a>>,
}

/// Appends the distances that are to be kept near a configuration.
pub(crate) type Look<'a> = dyn Fn(&Kinematics, &mut Vec<Near>) + 'a;

/// Working memory.
#[derive(Default)]
pub(crate) struct Projection {
    /// Residual.
    r: Vec<f64>,
    /// Freedom of each row.
    freedom: Vec<f64>,
    /// Rows of J, one after the other.
    J: Vec<f64>,
    /// J √W.
    scaled: Vec<f64>,
    /// Lower triangle of J W Jᵀ + e², then its Cholesky factor.
    A: Vec<f64>,
    lambda: Vec<f64>,
    /// The step from the reference, over √W.
    y: Vec<f64>,
    step: Vec<f64>,
    inequalities: Inequalities,
    near: Vec<Near>,
}

/// Whether a patch is the point of a ball, which may roll.
pub(crate) fn is_point(robot: &Robot, patch: PatchId) -> bool {
    robot.patches[patch].kind != PatchKind::Area
}

/// How far two poses of a patch are apart, m: angles times an arm, but for a patch that may turn.
pub(crate) fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>, turns: bool) -> f64 {
    let apart = (a.translation.vector - b.translation.vector).norm();
    if turns {
        return apart;
    }
    apart.max(ANGLE_ARM_M * a.rotation.angle_to(&b.rotation))
}

impl Projection {
    /// Moves `q` to the solution near it; the residual of the equations that is left.
    ///
    /// `weight` is √W: how readily each coordinate moves.
    pub fn solve(
        &mut self,
        robot: &Robot,
        target: &Target,
        bounds: &Bounds,
        weight: &[f64],
        reference: &Configuration,
        (q, kinematics): (&mut Configuration, &mut Kinematics),
    ) -> f64 {
        let mut moved = f64::INFINITY;
        // Part of the distance from the reference that is left as it is; 0 converges fastest.
        let mut damping = 0.0;
        for iteration in 0..ITERATIONS_MAX {
            kinematics.update(robot, q);
            let residual = self.residual(robot, target, kinematics);
            if !residual.is_finite() || (residual < DONE && moved < STILL) {
                return residual;
            }
            match bounds.near {
                Some(near) if iteration % LOOK_EVERY == 0 => {
                    self.near.clear();
                    near(kinematics, &mut self.near);
                }
                Some(_) => {}
                None => self.near.clear(),
            }
            let mut delta = reference.difference(q);
            delta *= 1.0 - damping;
            if !self.quadratic(robot, target, bounds, weight, q, &delta, kinematics) {
                return residual;
            }
            let last = moved;
            moved = self.step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if moved > STEP_MAX {
                let scale = STEP_MAX / moved;
                self.step.iter_mut().for_each(|s| *s *= scale);
            }
            if iteration >= FINISH {
                // What does not settle is at least closed.
                damping = 1.0;
            } else if iteration > 1 && moved > SHRINK * last {
                damping = 0.5 * (1.0 + damping);
            }
            q.integrate_in_place(&self.step);
        }
        kinematics.update(robot, q);
        self.residual(robot, target, kinematics)
    }

    /// Takes what is left of the equations' residual away by least-norm steps, without bounds.
    pub fn close(
        &mut self,
        robot: &Robot,
        target: &Target,
        weight: &[f64],
        q: &mut Configuration,
        kinematics: &mut Kinematics,
    ) {
        let free = Bounds {
            joints: &[],
            near: None,
        };
        self.near.clear();
        let here = DVector::zeros(robot.nv());
        for _ in 0..CLOSING {
            kinematics.update(robot, q);
            let residual = self.residual(robot, target, kinematics);
            let closed = residual < CLOSED;
            if closed || !self.quadratic(robot, target, &free, weight, q, &here, kinematics) {
                return;
            }
            q.integrate_in_place(&self.step);
        }
        kinematics.update(robot, q);
    }

    /// The largest residual of the equations that are not free at the configuration of
    /// `kinematics`, m and rad.
    pub fn residual(&mut self, robot: &Robot, target: &Target, kinematics: &Kinematics) -> f64 {
        self.r.clear();
        self.freedom.clear();
        let last = target.patches.len().wrapping_sub(1);
        for (i, (patch, wanted)) in target.patches.iter().enumerate() {
            let X_WC = kinematics.X_WC(&robot.patches[*patch]);
            let p = X_WC.translation.vector - wanted.translation.vector;
            self.r.extend(p.iter());
            self.freedom.extend([0.0; 3]);
            if !is_point(robot, *patch) {
                let turn = (X_WC.rotation * wanted.rotation.inverse()).scaled_axis();
                self.r.extend(turn.iter());
                let freedom = if i == last { target.turn_freedom } else { 0.0 };
                self.freedom.extend([freedom; 3]);
            }
        }
        let c = kinematics.com_W - target.com_W;
        self.r.extend([c.x, c.y]);
        self.freedom.extend([0.0; 2]);
        let rows = self.r.iter().zip(&self.freedom);
        let held = rows.filter(|(_, freedom)| **freedom == 0.0);
        held.fold(0.0, |worst, (r, _)| r.abs().max(worst))
    }

    /// Writes the step to the solution of the problem linearised at `q`, which is `delta` away from
    /// what it is to be near to; false where the rows depend on each other.
    #[allow(clippy::too_many_arguments)]
    fn quadratic(
        &mut self,
        robot: &Robot,
        target: &Target,
        bounds: &Bounds,
        weight: &[f64],
        q: &Configuration,
        delta: &DVector<f64>,
        kinematics: &Kinematics,
    ) -> bool {
        let (m, n) = (self.r.len(), robot.nv());
        self.jacobian(robot, target, kinematics);
        self.scaled.clear();
        for row in self.J.chunks_exact(n) {
            let scaled = row.iter().zip(weight).map(|(j, w)| j * w);
            self.scaled.extend(scaled);
        }
        self.A.clear();
        self.A.resize(m * m, 0.0);
        for i in 0..m {
            let row = &self.scaled[i * n..(i + 1) * n];
            for k in 0..=i {
                self.A[i * m + k] = dot(row, &self.scaled[k * n..(k + 1) * n]);
            }
            // Four limbs on the ground can make rows that nearly depend on each other.
            self.A[i * m + i] += self.freedom[i] * self.freedom[i] + 1e-9;
        }
        if !cholesky(&mut self.A, m) {
            return false;
        }
        // The least-norm solution of J δ = J δ_now − r.
        self.lambda.clear();
        for (row, r) in self.J.chunks_exact(n).zip(&self.r) {
            self.lambda.push(dot(row, delta.as_slice()) - r);
        }
        cholesky_solve(&self.A, m, &mut self.lambda);
        self.y.clear();
        self.y.resize(n, 0.0);
        for (row, l) in self.scaled.chunks_exact(n).zip(&self.lambda) {
            self.y.iter_mut().zip(row).for_each(|(y, j)| *y += l * j);
        }
        self.bind(robot, bounds, weight, q, delta, kinematics);
        self.step.clear();
        let steps = self.y.iter().zip(weight).zip(delta.iter());
        self.step.extend(steps.map(|((y, w), d)| y * w - d));
        self.step.iter().all(|s| s.is_finite())
    }

    /// Moves the solution of the equations onto the bounds that it violates.
    fn bind(
        &mut self,
        robot: &Robot,
        bounds: &Bounds,
        weight: &[f64],
        q: &Configuration,
        delta: &DVector<f64>,
        kinematics: &Kinematics,
    ) {
        let (m, n) = (self.r.len(), robot.nv());
        let set = &mut self.inequalities;
        set.clear();
        for (j, (lower, upper)) in bounds.joints.iter().enumerate() {
            let k = 6 + j;
            if weight[k] == 0.0 {
                continue;
            }
            let now = q.joints[j] - delta[k] + self.y[k] * weight[k];
            for (sign, room) in [(1.0, now - lower), (-1.0, upper - now)] {
                if room < NEAR_BOUND {
                    let row = set.push(n, room);
                    row[k] = sign * weight[k];
                }
            }
        }
        // d(δ) = n·(p_a − p_b) + g·(δ − δ_now), the nearest points taken along with their bodies
        for pair in &self.near {
            let row = set.push(n, 0.0);
            let at = |body: usize, p: &Point3<f64>| (kinematics.X_WB[body] * p).coords;
            let p_a = at(pair.a.0, &pair.a.1);
            kinematics.add_point_row(robot, pair.a.0, &p_a, &pair.normal_W, 1.0, row);
            let p_b = match pair.b {
                (Some(body), p) => {
                    let p_b = at(body, &p);
                    kinematics.add_point_row(robot, body, &p_b, &pair.normal_W, -1.0, row);
                    p_b
                }
                (None, p) => p.coords,
            };
            let slack = pair.normal_W.dot(&(p_a - p_b)) - pair.required_m;
            let now = dot(row, delta.as_slice());
            row.iter_mut().zip(weight).for_each(|(g, w)| *g *= w);
            let then = dot(row, &self.y);
            set.set_room(slack + then - now);
        }
        set.solve(n, m, &self.scaled, &self.A, &mut self.y);
    }

    /// Writes the rows of the target: linear and, where the patch may not roll, angular velocity of
    /// every patch, and the horizontal velocity of the centre of mass.
    fn jacobian(&mut self, robot: &Robot, target: &Target, kinematics: &Kinematics) {
        let (m, n) = (self.r.len(), robot.nv());
        self.J.clear();
        // The vertical row of the centre of mass is written too, and then left out.
        self.J.resize((m + 1) * n, 0.0);
        let mut blocks = self.J.chunks_exact_mut(3 * n);
        let mut next = || {
            let block = blocks.next().unwrap_or_default();
            DMatrixViewMut::from_slice_with_strides_mut(block, 3, n, n, 1)
        };
        for (patch, _) in &target.patches {
            let model = &robot.patches[*patch];
            let p = kinematics.X_WC(model).translation.vector;
            kinematics.point_jacobian(robot, model.body, &p, &mut next());
            if !is_point(robot, *patch) {
                kinematics.angular_jacobian(robot, model.body, &mut next());
            }
        }
        kinematics.com_jacobian(robot, &mut next());
        self.J.truncate(m * n);
    }
}
