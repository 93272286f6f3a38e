//! The simulated robot: MuJoCo's state in this project's terms.

use mujoco_rs::prelude::*;
use nalgebra::{DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use robot_model::{Configuration, Robot};

use crate::Error;
use crate::mjcf::{self, Corner};
use crate::physics::{Physics, Scales, Servo};
use crate::world::WorldBody;

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// A collision shape of the robot.
    Shape(usize),
    /// A body of the world.
    World(usize),
}

/// A point at which two shapes touch.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// A shape of the robot.
    pub shape: usize,
    /// What it touches.
    pub other: Side,
    /// Where, in W, m.
    pub p_W: Vector3<f64>,
    /// Unit normal toward `shape`.
    pub normal_W: Vector3<f64>,
    /// How deep they overlap, m; negative where they do not.
    pub depth_m: f64,
    /// Force on `shape`, in W, N.
    pub force_W: Vector3<f64>,
}

/// A robot in its world.
pub struct Plant {
    data: MjData<Box<MjModel>>,
    sides: Vec<Side>,
    bodies: Vec<usize>,
    servo: Servo,
}

impl Plant {
    /// Sets the robot up in its world, at its neutral configuration.
    ///
    /// # Errors
    /// As [`mjcf::model`]; [`Error::MuJoCo`] where the model is refused or
    /// does not come out with the robot's mass and number of velocities.
    pub fn new(
        robot: &Robot,
        world: &[WorldBody],
        physics: &Physics,
        servo: Servo,
        scales: &Scales,
    ) -> Result<Self, Error> {
        let xml = mjcf::model(robot, world, physics, servo, scales)?;
        let model =
            MjModel::from_xml_string(&xml).map_err(|e| Error::MuJoCo(format!("model: {e}")))?;
        let (mass, wanted) = (model.totalmass(), robot.mass_kg * scales.mass);
        if (mass - wanted).abs() > 1e-9 * wanted {
            let cause = format!("the model has a mass of {mass} kg, the robot {wanted} kg");
            return Err(Error::MuJoCo(cause));
        }
        let (nv, wanted) = (model.ffi().nv as usize, robot.nv());
        if nv != wanted {
            let cause = format!("the model has {nv} velocities, the robot {wanted}");
            return Err(Error::MuJoCo(cause));
        }
        let id = |kind: MjtObjBase, name: String| {
            let id = model.name_to_id(kind, &name);
            id.ok_or_else(|| Error::MuJoCo(format!("the model has no {name}")))
        };
        let shapes = robot.collision.shapes().len();
        let corners: Vec<Corner> = mjcf::corners(robot).collect();
        let mut sides = vec![Side::World(0); shapes + world.len() + corners.len()];
        for k in 0..shapes {
            sides[id(MjtObjBase::mjOBJ_GEOM, format!("s{k}"))?] = Side::Shape(k);
        }
        for Corner { name, shape, .. } in corners {
            sides[id(MjtObjBase::mjOBJ_GEOM, name)?] = Side::Shape(shape);
        }
        for k in 0..world.len() {
            sides[id(MjtObjBase::mjOBJ_GEOM, format!("w{k}"))?] = Side::World(k);
        }
        let bodies = (0..robot.bodies.len())
            .map(|i| id(MjtObjBase::mjOBJ_BODY, format!("b{i}")))
            .collect::<Result<_, _>>()?;
        let data = MjData::try_new(Box::new(model)).map_err(|e| Error::MuJoCo(e.to_string()))?;
        Ok(Self {
            data,
            sides,
            bodies,
            servo,
        })
    }

    /// Puts the robot at rest at a configuration.
    pub fn reset(&mut self, configuration: &Configuration) {
        self.data.reset();
        let q = &configuration.R_WB;
        let qpos = self.data.qpos_mut();
        qpos[..3].copy_from_slice(configuration.p_WB.as_slice());
        qpos[3..7].copy_from_slice(&[q.w, q.i, q.j, q.k]);
        qpos[7..].copy_from_slice(configuration.joints.as_slice());
        self.data.forward();
    }

    /// Reads the state: configuration and v = [v_B, ω_B, joint rates…], v_B and ω_B in W.
    pub fn state(&self, configuration: &mut Configuration, v: &mut DVector<f64>) {
        let (qpos, qvel) = (self.data.qpos(), self.data.qvel());
        configuration.p_WB = Vector3::new(qpos[0], qpos[1], qpos[2]);
        configuration.R_WB =
            UnitQuaternion::new_normalize(Quaternion::new(qpos[3], qpos[4], qpos[5], qpos[6]));
        configuration.joints.copy_from_slice(&qpos[7..]);
        v.copy_from_slice(qvel);
        // MuJoCo's angular velocity of a free joint is in the body's axes.
        let omega_W = configuration.R_WB * Vector3::new(qvel[3], qvel[4], qvel[5]);
        v.fixed_rows_mut::<3>(3).copy_from(&omega_W);
    }

    /// Sets the servos: position, velocity and torque that they add.
    ///
    ///   ctrl = q + (τ + kv·q̇)/kp
    ///
    /// Shapes: nj each.
    pub fn command(&mut self, joints: &[f64], rates: &[f64], torques: &[f64]) {
        let Servo { kp, kv } = self.servo;
        for (j, ctrl) in self.data.ctrl_mut().iter_mut().enumerate() {
            *ctrl = joints[j] + (torques[j] + kv * rates[j]) / kp;
        }
    }

    /// Pushes the base at its centre of mass with a force in W, N, until told otherwise.
    pub fn push(&mut self, force_W: &Vector3<f64>) {
        let at = self.bodies[0];
        self.data.xfrc_applied_mut()[at] = [force_W.x, force_W.y, force_W.z, 0.0, 0.0, 0.0];
    }

    /// One time step. `false` where the simulation became unstable.
    pub fn step(&mut self) -> bool {
        self.data.step();
        // MuJoCo resets a state that is not finite, which shows in its clock.
        self.data.qpos().iter().all(|x| x.is_finite())
    }

    /// Torque of each actuator, N·m; nj.
    pub fn torques(&self) -> &[f64] {
        self.data.actuator_force()
    }

    /// Everything that touches, written over `touches`.
    pub fn touches(&self, touches: &mut Vec<Touch>) {
        touches.clear();
        for (k, contact) in self.data.contact().iter().enumerate() {
            if contact.exclude != 0 {
                continue;
            }
            let side = |id| self.sides.get(usize::try_from(id).ok()?).copied();
            let [Some(first), Some(second)] = contact.geom.map(side) else {
                continue;
            };
            // Rows of the frame: the normal, from the first shape to the second, and tangents.
            let frame = Matrix3::from_row_slice(&contact.frame);
            let f = self.data.contact_force(k);
            let on_second = frame.transpose() * Vector3::new(f[0], f[1], f[2]);
            let normal: Vector3<f64> = frame.row(0).transpose();
            let (shape, other, sign) = match (first, second) {
                (other, Side::Shape(shape)) => (shape, other, 1.0),
                (Side::Shape(shape), other) => (shape, other, -1.0),
                _ => continue,
            };
            touches.push(Touch {
                shape,
                other,
                p_W: Vector3::from(contact.pos),
                normal_W: normal * sign,
                depth_m: -contact.dist,
                force_W: on_second * sign,
            });
        }
    }

    /// MuJoCo's data, for pictures.
    #[cfg(feature = "render")]
    pub(crate) fn data_mut(&mut self) -> &mut MjData<Box<MjModel>> {
        &mut self.data
    }
}
