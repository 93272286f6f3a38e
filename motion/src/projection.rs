//! The configuration nearest to a reference on which contacts are closed, the patch in the air is
//! at its pose and the centre of mass above its place.
//!
//!   min ½ ‖δ‖²_{W⁻¹} + ½ ‖s‖²   s.t.   r(q_ref ⊕ δ) + e s = 0,   lower ≤ q ≤ upper,   d ≥ d_min
//!
//! r = (p − p*, log R R*ᵀ) a patch, (c − c*)_xy; e is zero but for the orientation of a patch that
//! is far from both its ends. Sequential linearisation; the QP in dual form, the equations by
//! Cholesky, the few inequalities by an active set.

use crate::dense::{cholesky, cholesky_solve, dot};
use crate::equations::{Equations, Target};
use crate::inequalities::Inequalities;
use crate::near::Near;
use nalgebra::{DVector, Point3, Vector3};
use posture::Upright;
use robot_model::{Configuration, Kinematics, Robot};

/// Largest change of a coordinate in one step, rad or m.
const STEP_MAX: f64 = 0.5;
/// Iterations at most.
const ITERATIONS_MAX: usize = 24;
/// The distances are measured every so many iterations.
const LOOK_EVERY: usize = 3;
/// Newton steps that close a sample at most, and the residual, m and rad, below which one takes the rows of the
/// step before it.
const CLOSING: usize = 4;
const SAME_ROWS: f64 = 1e-4;
/// Below this residual the equations hold, m and rad: rows that nearly depend on each other leave a few 1e-9.
const CLOSED: f64 = 1e-7;
/// A step longer than this part of the one before it is damped.
const SHRINK: f64 = 0.5;
/// Where the reference is damped by more than this, a step longer than this part of the one before it is the last:
/// what is asked contradicts itself here.
const DAMPED: f64 = 0.8;
const STUCK: f64 = 0.8;
/// A step below this (rad, m) no longer changes the solution.
const STILL: f64 = 1e-5;
/// A tilt this near to its bound becomes an inequality, rad.
const NEAR_TILT: f64 = 0.2;

/// What a projection is asked for.
#[derive(Clone, Copy)]
pub(crate) struct Ask<'a> {
    pub robot: &'a Robot,
    pub target: &'a Target,
    pub bounds: &'a Bounds<'a>,
    /// √W: how readily each coordinate moves.
    pub weight: &'a [f64],
}

/// The inequalities: joint bounds, tilt and distances.
pub(crate) struct Bounds<'a> {
    /// Lower and upper bound of every joint.
    pub joints: &'a [(f64, f64)],
    /// How far the base may tilt, where there is a bound.
    pub upright: Option<Upright>,
    /// Distances to keep: nothing, or a list that is filled at every iterate.
    pub near: Option<&'a Look<'a>>,
}

impl Bounds<'_> {
    /// No inequalities.
    pub const NONE: Self = Self {
        joints: &[],
        upright: None,
        near: None,
    };
}

/// Appends the distances that are to be kept near a configuration.
pub(crate) type Look<'a> = dyn Fn(&Kinematics, &mut Vec<Near>) + 'a;

/// Working memory.
#[derive(Default)]
pub(crate) struct Projection {
    equations: Equations,
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

impl Projection {
    /// Moves `q` to the solution near it; the residual of the equations that is left.
    pub fn solve(
        &mut self,
        ask: &Ask,
        reference: &Configuration,
        q: &mut Configuration,
        kinematics: &mut Kinematics,
    ) -> f64 {
        let mut moved = f64::INFINITY;
        // Part of the distance from the reference that is left as it is; 0 converges fastest.
        let mut damping = 0.0;
        for iteration in 0..ITERATIONS_MAX {
            kinematics.update(ask.robot, q);
            let residual = self.equations.update(ask.robot, ask.target, kinematics);
            if !residual.is_finite() || (residual < CLOSED && moved < STILL) {
                return residual;
            }
            match ask.bounds.near {
                Some(near) if iteration % LOOK_EVERY == 0 => {
                    self.near.clear();
                    near(kinematics, &mut self.near);
                }
                Some(_) => {}
                None => self.near.clear(),
            }
            let mut delta = reference.difference(q);
            delta *= 1.0 - damping;
            if !self.quadratic(ask, q, &delta, kinematics) {
                return residual;
            }
            let last = moved;
            moved = self.step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if moved > STEP_MAX {
                let scale = STEP_MAX / moved;
                self.step.iter_mut().for_each(|s| *s *= scale);
            }
            q.integrate_in_place(&self.step);
            if damping > DAMPED && moved > STUCK * last {
                break;
            }
            if iteration > 1 && moved > SHRINK * last {
                damping = 0.5 * (1.0 + damping);
            }
        }
        kinematics.update(ask.robot, q);
        self.equations.update(ask.robot, ask.target, kinematics)
    }

    /// Takes what is left of the equations' residual away by least-norm steps from `q`, whose kinematics these
    /// are; there are to be no bounds. A patch that may turn keeps to how it has turned.
    pub fn close(&mut self, ask: &Ask, q: &mut Configuration, kinematics: &mut Kinematics) {
        for step in 0..CLOSING {
            let left = self.equations.update(ask.robot, ask.target, kinematics);
            let same_rows = step > 0 && left < SAME_ROWS;
            if left < CLOSED || !(same_rows || self.linearise(ask, kinematics)) {
                return;
            }
            self.lambda.clear();
            let rows = self.equations.r.iter().zip(&self.equations.freedom);
            self.lambda
                .extend(rows.map(|(r, free)| if *free > 0.0 { 0.0 } else { -r }));
            self.least_norm(ask.robot.nv());
            self.step.clear();
            let steps = self.y.iter().zip(ask.weight);
            self.step.extend(steps.map(|(y, w)| y * w));
            q.integrate_in_place(&self.step);
            kinematics.update(ask.robot, q);
        }
    }

    /// Writes the step to the solution of the problem linearised at `q`, which is `delta` away from
    /// what it is to be near to; false where the rows depend on each other.
    fn quadratic(
        &mut self,
        ask: &Ask,
        q: &Configuration,
        delta: &DVector<f64>,
        kinematics: &Kinematics,
    ) -> bool {
        if !self.linearise(ask, kinematics) {
            return false;
        }
        // J δ = J δ_now − r.
        let n = ask.robot.nv();
        self.lambda.clear();
        for (row, r) in self.equations.J.chunks_exact(n).zip(&self.equations.r) {
            self.lambda.push(dot(row, delta.as_slice()) - r);
        }
        self.least_norm(n);
        self.bind(ask, q, delta, kinematics);
        self.step.clear();
        let steps = self.y.iter().zip(ask.weight).zip(delta.iter());
        self.step.extend(steps.map(|((y, w), d)| y * w - d));
        self.step.iter().all(|s| s.is_finite())
    }

    /// Writes the rows of the equations and the factor of their products; false where they depend on each other.
    fn linearise(&mut self, ask: &Ask, kinematics: &Kinematics) -> bool {
        let weight = ask.weight;
        let equations = &mut self.equations;
        equations.linearise(ask.robot, ask.target, kinematics);
        let (m, n) = (equations.r.len(), ask.robot.nv());
        self.scaled.clear();
        for row in equations.J.chunks_exact(n) {
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
            self.A[i * m + i] += equations.freedom[i] * equations.freedom[i] + 1e-9;
        }
        cholesky(&mut self.A, m)
    }

    /// Writes the least-norm solution of the linearised equations, whose right side λ is.
    fn least_norm(&mut self, n: usize) {
        cholesky_solve(&self.A, self.equations.r.len(), &mut self.lambda);
        self.y.clear();
        self.y.resize(n, 0.0);
        for (row, l) in self.scaled.chunks_exact(n).zip(&self.lambda) {
            self.y.iter_mut().zip(row).for_each(|(y, j)| *y += l * j);
        }
    }

    /// Moves the solution of the equations onto the bounds that it violates.
    fn bind(
        &mut self,
        ask: &Ask,
        q: &Configuration,
        delta: &DVector<f64>,
        kinematics: &Kinematics,
    ) {
        let &Ask {
            robot,
            bounds,
            weight,
            ..
        } = ask;
        let (m, n) = (self.equations.r.len(), robot.nv());
        let set = &mut self.inequalities;
        set.clear();
        for (j, (lower, upper)) in bounds.joints.iter().enumerate() {
            let k = 6 + j;
            if weight[k] == 0.0 {
                continue;
            }
            let reference = q.joints[j] - delta[k];
            set.bound(k, weight[k], [lower - reference, upper - reference]);
        }
        // The base turns back by φ about the axis that it tilts about: θ(φ) = θ − a·φ.
        if let Some(upright) = bounds.upright {
            let z = q.R_WB * Vector3::z();
            let axis = z.cross(&upright.z_W).try_normalize(1e-9);
            let room = upright.tilt_max_rad - upright.tilt_rad(&q.R_WB);
            if let Some(axis) = axis.filter(|_| room < NEAR_TILT) {
                let row = set.push(n, 0.0);
                for k in 0..3 {
                    row[3 + k] = axis[k] * weight[3 + k];
                }
                let turn = axis.dot(&delta.fixed_rows::<3>(3));
                let then = dot(row, &self.y);
                set.set_room(room + then - turn);
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
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn a_base_that_leans_too_far_is_set_upright_over_its_foot() {
        let robot = scenes::builtin_robot("hrp2").unwrap();
        let robot = robot.load(&robot_model::Config::default()).unwrap();
        let foot = robot.patch_id("left_foot").unwrap();
        let mut reference = Configuration::zero(robot.nj());
        reference.R_WB = UnitQuaternion::from_euler_angles(0.1, 0.3, 0.0);
        let mut kinematics = Kinematics::new(&robot, &reference);
        let target = Target {
            patches: vec![(foot, kinematics.X_WC(&robot.patches[foot]), None)],
            turn_freedom: 0.0,
            com_W: kinematics.com_W,
        };
        let weight = vec![1.0; robot.nv()];
        let mut tilt_rad = |upright: Option<Upright>| {
            let bounds = Bounds {
                upright,
                ..Bounds::NONE
            };
            let ask = Ask {
                robot: &robot,
                target: &target,
                bounds: &bounds,
                weight: &weight,
            };
            let mut q = reference.clone();
            let mut projection = Projection::default();
            let left = projection.solve(&ask, &reference, &mut q, &mut kinematics);
            assert!(left < 1e-6, "{left}");
            (q.R_WB * Vector3::z()).angle(&Vector3::z())
        };
        assert!(tilt_rad(None) > 0.3);
        let upright = Upright {
            z_W: Vector3::z(),
            tilt_max_rad: 0.1,
        };
        let tilt = tilt_rad(Some(upright));
        assert!((tilt - 0.1).abs() < 1e-4, "{tilt}");
    }

    #[test]
    #[allow(clippy::unwrap_used)]
    fn a_solution_stays_where_it_is_where_its_patch_may_turn() {
        let robot = scenes::builtin_robot("hrp2").unwrap();
        let robot = robot.load(&robot_model::Config::default()).unwrap();
        let [left, right] = ["left_foot", "right_foot"].map(|foot| robot.patch_id(foot).unwrap());
        let reference = robot.resting();
        let mut kinematics = Kinematics::new(&robot, &reference);
        let pose = |k: &Kinematics, patch| k.X_WC(&robot.patches[patch]);
        let mut away = pose(&kinematics, right);
        away.translation.vector += Vector3::new(0.1, 0.0, 0.15);
        away.rotation = UnitQuaternion::from_euler_angles(0.0, 0.5, 0.3) * away.rotation;
        let target = Target {
            patches: vec![(left, pose(&kinematics, left), None), (right, away, None)],
            turn_freedom: 0.5,
            com_W: kinematics.com_W,
        };
        let weight = vec![1.0; robot.nv()];
        let ask = Ask {
            robot: &robot,
            target: &target,
            bounds: &Bounds::NONE,
            weight: &weight,
        };
        let mut q = reference.clone();
        let mut projection = Projection::default();
        projection.solve(&ask, &reference, &mut q, &mut kinematics);
        let turned = pose(&kinematics, right).rotation.angle_to(&away.rotation);
        assert!(turned > 0.05, "it turns from its pose: {turned}");
        let mut again = q.clone();
        projection.solve(&ask, &reference, &mut again, &mut kinematics);
        assert!(q.difference(&again).amax() < 1e-5);
        // It is put back to its place, and not turned back to its pose.
        let mut closed = q.clone();
        closed.p_WB.x += 1e-3;
        kinematics.update(&robot, &closed);
        projection.close(&ask, &mut closed, &mut kinematics);
        let X_WC = pose(&kinematics, right);
        assert!((X_WC.translation.vector - away.translation.vector).norm() < 1e-6);
        let still = X_WC.rotation.angle_to(&away.rotation);
        assert!((still - turned).abs() < 0.1 * turned, "{still} {turned}");
    }
}
