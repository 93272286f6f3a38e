//! What bodies need that go along a path, per s̈ and per ṡ², and what the joints must exert for it.
//!
//!   f_b = m_b c̈_b,   n_b = I_b α_b + ω_b × I_b ω_b + (c_b − o_b) × f_b
//!   τ_b = a_b·Σ_{beyond b} (n + (o − o_b) × f)   (revolute),   a_b·Σ f   (prismatic)
//!
//! Source: \[featherstone2008\] section 5.3, written out in W about body origins.

use nalgebra::Vector3;
use robot_model::{JointKind, Kinematics, Robot};

/// A force, and its moment about the body's origin, N and N·m, in W.
pub(crate) type Wrench = (Vector3<f64>, Vector3<f64>);

/// How a body goes along a path, in W.
#[derive(Clone, Copy)]
struct Going {
    /// Velocities over ṡ, of the body's origin and about it.
    linear: Vector3<f64>,
    omega: Vector3<f64>,
    /// Accelerations over ṡ² that are not those velocities' own.
    bend: Vector3<f64>,
    alpha: Vector3<f64>,
}

impl Going {
    /// Velocity and acceleration of the point at `r` from the origin.
    fn point(&self, r: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let across = self.omega.cross(r);
        [
            self.linear + across,
            self.bend + self.alpha.cross(r) + self.omega.cross(&across),
        ]
    }
}

/// A robot that goes along a path, at one place of it, with its memory.
#[derive(Default)]
pub(crate) struct PathDynamics {
    bodies: Vec<Going>,
    /// What every body needs per s̈ and per ṡ².
    forces: Vec<[Wrench; 2]>,
    /// How fast the fastest centre of mass of a body moves, over ṡ.
    pub speed: f64,
}

impl PathDynamics {
    /// Moves to a place where velocities are `v` ṡ and accelerations `v` s̈ + `a` ṡ².
    ///
    /// Shapes: v, a nv, as [`robot_model::Configuration`] has them.
    pub fn update(&mut self, robot: &Robot, kinematics: &Kinematics, [v, a]: [&[f64]; 2]) {
        let three = |x: &[f64], k: usize| Vector3::new(x[k], x[k + 1], x[k + 2]);
        self.bodies.clear();
        self.forces.clear();
        self.speed = 0.0;
        for (i, body) in robot.bodies.iter().enumerate() {
            let going = match body.parent {
                None => Going {
                    linear: three(v, 0),
                    omega: three(v, 3),
                    bend: three(a, 0),
                    alpha: three(a, 3),
                },
                Some(parent) => {
                    let r = kinematics.origin_W[i] - kinematics.origin_W[parent];
                    let axis = &kinematics.axis_W[i];
                    let (rate, change) = (axis * v[5 + i], axis * a[5 + i]);
                    let Going { omega, alpha, .. } = self.bodies[parent];
                    let [linear, bend] = self.bodies[parent].point(&r);
                    let turned = omega.cross(&rate);
                    match body.kind {
                        JointKind::Prismatic => Going {
                            linear: linear + rate,
                            omega,
                            bend: bend + change + turned * 2.0,
                            alpha,
                        },
                        _ => Going {
                            linear,
                            omega: omega + rate,
                            bend,
                            alpha: alpha + change + turned,
                        },
                    }
                }
            };
            let R = kinematics.X_WB[i].rotation.to_rotation_matrix();
            let com = R * body.com_B;
            let inertia =
                |turn: &Vector3<f64>| R * (body.inertia_B * R.inverse_transform_vector(turn));
            let [velocity, acceleration] = going.point(&com);
            let (force, bend) = (velocity * body.mass_kg, acceleration * body.mass_kg);
            let spin = inertia(&going.omega);
            let turn = inertia(&going.alpha) + going.omega.cross(&spin);
            self.forces.push([
                (force, spin + com.cross(&force)),
                (bend, turn + com.cross(&bend)),
            ]);
            self.speed = self.speed.max(velocity.norm());
            self.bodies.push(going);
        }
    }

    /// How fast the point of `body` that is at `r` from its origin moves, over ṡ.
    pub fn point_speed(&self, body: usize, r: &Vector3<f64>) -> f64 {
        self.bodies[body].point(r)[0].norm()
    }

    /// Sums what bodies need toward the base, and writes what each joint exerts for it, N·m or N, per s̈ and per ṡ²
    /// as the second and third of its parts; what the base needs and nothing gives is left.
    pub fn joint_torques(
        &mut self,
        robot: &Robot,
        kinematics: &Kinematics,
        out: &mut [[f64; 3]],
    ) -> [Wrench; 2] {
        for (i, body) in robot.bodies.iter().enumerate().rev() {
            let Some(parent) = body.parent else { continue };
            let r = kinematics.origin_W[i] - kinematics.origin_W[parent];
            for k in 0..2 {
                let (force, moment) = self.forces[i][k];
                let along = match body.kind {
                    JointKind::Prismatic => force,
                    _ => moment,
                };
                out[i - 1][1 + k] = kinematics.axis_W[i].dot(&along);
                let whole = &mut self.forces[parent][k];
                whole.0 += force;
                whole.1 += moment + r.cross(&force);
            }
        }
        self.forces[0]
    }
}
