//! Equations of motion of a floating-base robot.
//!
//!   M(q) v̇ + h(q, v) = (0, τ) + Σ Jᵀ f        v = [v_B, ω_B, joint rates…], all in W
//!
//! h holds Coriolis, centrifugal and gravity terms. Composite bodies give M, a recursion with
//! v̇ = 0 gives h and the bias accelerations J̇v.
//! Source: \[featherstone2008\] sections 5.3 and 6.2, written out in W about body origins.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_model::{Configuration, GRAVITY_M_S2, JointKind, Kinematics, Robot};

/// Poses, velocities, mass matrix and bias forces of a robot at one state.
///
/// Units: m, rad, s, kg, N, N·m.  Frames: all in W.
#[derive(Clone, Debug)]
pub struct Dynamics {
    /// Poses, axes and centres of mass.
    pub kinematics: Kinematics,
    /// Angular velocity of each body.
    pub omega_W: Vec<Vector3<f64>>,
    /// Velocity of each body's origin.
    pub velocity_W: Vec<Vector3<f64>>,
    /// Angular acceleration of each body where v̇ = 0.
    pub bias_alpha_W: Vec<Vector3<f64>>,
    /// Acceleration of each body's origin where v̇ = 0.
    pub bias_acceleration_W: Vec<Vector3<f64>>,
    /// Velocity of the centre of mass.
    pub com_velocity_W: Vector3<f64>,
    /// Acceleration of the centre of mass where v̇ = 0.
    pub com_bias_W: Vector3<f64>,
    /// M, nv × nv.
    pub M: DMatrix<f64>,
    /// h, nv.
    pub h: DVector<f64>,
    /// Inertia of what each body's joint carries, about that part's centre of mass.
    composite: Vec<Matrix3<f64>>,
    force: Vec<Vector3<f64>>,
    moment: Vec<Vector3<f64>>,
}

impl Dynamics {
    /// The dynamics of `robot` at rest at `configuration`.
    pub fn new(robot: &Robot, configuration: &Configuration) -> Self {
        let n = robot.bodies.len();
        let nv = robot.nv();
        let mut dynamics = Dynamics {
            kinematics: Kinematics::new(robot, configuration),
            omega_W: vec![Vector3::zeros(); n],
            velocity_W: vec![Vector3::zeros(); n],
            bias_alpha_W: vec![Vector3::zeros(); n],
            bias_acceleration_W: vec![Vector3::zeros(); n],
            com_velocity_W: Vector3::zeros(),
            com_bias_W: Vector3::zeros(),
            M: DMatrix::zeros(nv, nv),
            h: DVector::zeros(nv),
            composite: vec![Matrix3::zeros(); n],
            force: vec![Vector3::zeros(); n],
            moment: vec![Vector3::zeros(); n],
        };
        dynamics.update(robot, configuration, &DVector::zeros(nv));
        dynamics
    }

    /// Moves to another state of the same robot, without allocating.
    ///
    /// Shapes: v nv.
    pub fn update(&mut self, robot: &Robot, configuration: &Configuration, v: &DVector<f64>) {
        self.update_motion(robot, configuration, v);
        self.update_bias_forces(robot);
        self.update_mass_matrix(robot);
    }

    /// Poses, velocities and bias accelerations only; M and h stay as they were.
    ///
    /// Shapes: v nv.
    pub fn update_motion(
        &mut self,
        robot: &Robot,
        configuration: &Configuration,
        v: &DVector<f64>,
    ) {
        assert_eq!(v.len(), robot.nv(), "one entry a velocity");
        self.kinematics.update(robot, configuration);
        self.com_velocity_W = Vector3::zeros();
        self.com_bias_W = Vector3::zeros();
        for (i, body) in robot.bodies.iter().enumerate() {
            match body.parent {
                None => {
                    self.velocity_W[i] = Vector3::new(v[0], v[1], v[2]);
                    self.omega_W[i] = Vector3::new(v[3], v[4], v[5]);
                    self.bias_alpha_W[i] = Vector3::zeros();
                    self.bias_acceleration_W[i] = Vector3::zeros();
                }
                Some(parent) => {
                    let r = self.kinematics.origin_W[i] - self.kinematics.origin_W[parent];
                    let omega = self.omega_W[parent];
                    let rate = self.kinematics.axis_W[i] * v[5 + i];
                    self.velocity_W[i] = self.velocity_W[parent] + omega.cross(&r);
                    self.omega_W[i] = omega;
                    self.bias_alpha_W[i] = self.bias_alpha_W[parent];
                    self.bias_acceleration_W[i] = self.bias_acceleration_W[parent]
                        + self.bias_alpha_W[parent].cross(&r)
                        + omega.cross(&omega.cross(&r));
                    if body.kind == JointKind::Prismatic {
                        self.velocity_W[i] += rate;
                        self.bias_acceleration_W[i] += omega.cross(&rate) * 2.0;
                    } else {
                        self.omega_W[i] += rate;
                        self.bias_alpha_W[i] += omega.cross(&rate);
                    }
                }
            }
            let share = body.mass_kg / robot.mass_kg;
            let com = self.kinematics.X_WB[i].rotation * body.com_B;
            self.com_velocity_W += (self.velocity_W[i] + self.omega_W[i].cross(&com)) * share;
            self.com_bias_W += self.point_bias_from_origin(i, &com) * share;
        }
    }

    /// Velocity of the point of `body` that is at `p_W` now.
    pub fn point_velocity(&self, body: usize, p_W: &Vector3<f64>) -> Vector3<f64> {
        let r = p_W - self.kinematics.origin_W[body];
        self.velocity_W[body] + self.omega_W[body].cross(&r)
    }

    /// J̇v of the point of `body` that is at `p_W` now.
    pub fn point_bias(&self, body: usize, p_W: &Vector3<f64>) -> Vector3<f64> {
        self.point_bias_from_origin(body, &(p_W - self.kinematics.origin_W[body]))
    }

    fn point_bias_from_origin(&self, body: usize, r: &Vector3<f64>) -> Vector3<f64> {
        let omega = self.omega_W[body];
        self.bias_acceleration_W[body]
            + self.bias_alpha_W[body].cross(r)
            + omega.cross(&omega.cross(r))
    }

    /// h: inertial forces and weights of every body, summed toward the base.
    fn update_bias_forces(&mut self, robot: &Robot) {
        let up = Vector3::z() * GRAVITY_M_S2;
        for (i, body) in robot.bodies.iter().enumerate() {
            let rotation = self.kinematics.X_WB[i].rotation.to_rotation_matrix();
            let com = rotation * body.com_B;
            let inertia = rotation * body.inertia_B * rotation.transpose();
            let force = (self.point_bias_from_origin(i, &com) + up) * body.mass_kg;
            let omega = self.omega_W[i];
            let spin = inertia * self.bias_alpha_W[i] + omega.cross(&(inertia * omega));
            self.force[i] = force;
            self.moment[i] = spin + com.cross(&force);
            // The composite of the body alone, about its own centre of mass.
            self.composite[i] = inertia;
        }
        for (i, body) in robot.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let axis = &self.kinematics.axis_W[i];
                self.h[5 + i] = match body.kind {
                    JointKind::Prismatic => axis.dot(&self.force[i]),
                    _ => axis.dot(&self.moment[i]),
                };
                let r = self.kinematics.origin_W[i] - self.kinematics.origin_W[parent];
                let (force, moment) = (self.force[i], self.moment[i]);
                self.force[parent] += force;
                self.moment[parent] += moment + r.cross(&force);
            }
        }
        self.h.fixed_rows_mut::<3>(0).copy_from(&self.force[0]);
        self.h.fixed_rows_mut::<3>(3).copy_from(&self.moment[0]);
    }

    /// M, from the composite body that each joint carries.
    fn update_mass_matrix(&mut self, robot: &Robot) {
        self.gather_composites(robot);
        let Dynamics { kinematics, M, .. } = self;
        M.fill(0.0);
        let mass = kinematics.subtree_mass[0];
        let c = kinematics.com_W - kinematics.origin_W[0];
        let cross = c.cross_matrix();
        M.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&(Matrix3::identity() * mass));
        M.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-cross * mass));
        M.fixed_view_mut::<3, 3>(3, 0).copy_from(&(cross * mass));
        M.fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&(self.composite[0] - cross * cross * mass));
        for (i, body) in robot.bodies.iter().enumerate().skip(1) {
            let axis = kinematics.axis_W[i];
            let com = kinematics.subtree_com_W[i];
            let (force, spin) = match body.kind {
                JointKind::Prismatic => (axis * kinematics.subtree_mass[i], Vector3::zeros()),
                _ => (
                    axis.cross(&(com - kinematics.origin_W[i])) * kinematics.subtree_mass[i],
                    self.composite[i] * axis,
                ),
            };
            let mut k = i;
            while let Some(parent) = robot.bodies[k].parent {
                let towards = &kinematics.axis_W[k];
                let moment = spin + (com - kinematics.origin_W[k]).cross(&force);
                let value = match robot.bodies[k].kind {
                    JointKind::Prismatic => towards.dot(&force),
                    _ => towards.dot(&moment),
                };
                M[(5 + k, 5 + i)] = value;
                M[(5 + i, 5 + k)] = value;
                k = parent;
            }
            let moment = spin + (com - kinematics.origin_W[0]).cross(&force);
            for axis in 0..3 {
                M[(axis, 5 + i)] = force[axis];
                M[(5 + i, axis)] = force[axis];
                M[(3 + axis, 5 + i)] = moment[axis];
                M[(5 + i, 3 + axis)] = moment[axis];
            }
        }
    }

    /// Turns `composite` from the bodies' own inertias into those of what their joints carry.
    fn gather_composites(&mut self, robot: &Robot) {
        let Dynamics {
            kinematics,
            composite,
            ..
        } = self;
        // Each body's own part, shifted to the centre of mass of its subtree.
        for (i, body) in robot.bodies.iter().enumerate() {
            let com = kinematics.X_WB[i].rotation * body.com_B + kinematics.origin_W[i];
            composite[i] += shifted(body.mass_kg, &(com - kinematics.subtree_com_W[i]));
        }
        for (i, body) in robot.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                let offset = kinematics.subtree_com_W[i] - kinematics.subtree_com_W[parent];
                let moved = composite[i] + shifted(kinematics.subtree_mass[i], &offset);
                composite[parent] += moved;
            }
        }
    }
}

/// Inertia of a point mass at `r` (parallel axes).
fn shifted(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * mass
}
