//! The equations of motion against energy, gravity and differences.

use nalgebra::DVector;
use robot_model::{Body, Configuration, Robot};
use simulation::dynamics::Dynamics;

use crate::robot::hrp2;

fn moving(robot: &Robot) -> (Configuration, DVector<f64>) {
    let mut configuration = robot.resting();
    let nv = robot.nv();
    let turn = DVector::from_fn(nv, |k, _| 0.2 * (k as f64 * 0.9).cos());
    configuration.integrate_in_place(turn.as_slice());
    (
        configuration,
        DVector::from_fn(nv, |k, _| (k as f64 * 1.7).sin()),
    )
}

#[test]
fn kinetic_energy_is_that_of_the_bodies() {
    let robot = hrp2();
    let (configuration, v) = moving(&robot);
    let mut dynamics = Dynamics::new(&robot, &configuration);
    dynamics.update(&robot, &configuration, &v);
    let whole = 0.5 * (v.transpose() * &dynamics.M * &v)[0];
    let energy = |(i, body): (usize, &Body)| {
        let X_WB = dynamics.kinematics.X_WB[i];
        let com = X_WB.rotation * body.com_B + X_WB.translation.vector;
        let omega = X_WB.rotation.inverse() * dynamics.omega_W[i];
        let speed = dynamics.point_velocity(i, &com);
        0.5 * (body.mass_kg * speed.norm_squared() + omega.dot(&(body.inertia_B * omega)))
    };
    let parts: f64 = robot.bodies.iter().enumerate().map(energy).sum();
    assert!((whole - parts).abs() < 1e-9 * parts, "{whole} {parts}");
}

#[test]
fn at_rest_the_bias_is_gravity() {
    let robot = hrp2();
    let (configuration, _) = moving(&robot);
    let dynamics = Dynamics::new(&robot, &configuration);
    let mut g = DVector::zeros(robot.nv());
    dynamics.kinematics.gravity_torques(&robot, &mut g);
    assert!((&dynamics.h - g).norm() < 1e-9);
}

#[test]
fn bias_accelerations_are_derivatives_of_velocities() {
    let robot = hrp2();
    let (configuration, v) = moving(&robot);
    let mut dynamics = Dynamics::new(&robot, &configuration);
    dynamics.update(&robot, &configuration, &v);
    let step = 1e-6;
    let at = |sign: f64| {
        let mut d = dynamics.clone();
        d.update(&robot, &configuration.integrate(&(&v * (sign * step))), &v);
        d
    };
    let (before, after) = (at(-1.0), at(1.0));
    let com = (after.com_velocity_W - before.com_velocity_W) / (2.0 * step);
    assert!((com - dynamics.com_bias_W).norm() < 1e-6);
    for i in 0..robot.bodies.len() {
        let a = (after.velocity_W[i] - before.velocity_W[i]) / (2.0 * step);
        assert!((a - dynamics.bias_acceleration_W[i]).norm() < 1e-5, "{i}");
        let alpha = (after.omega_W[i] - before.omega_W[i]) / (2.0 * step);
        assert!((alpha - dynamics.bias_alpha_W[i]).norm() < 1e-5, "{i}");
    }
}

/// d/dt (½ vᵀMv + U) = 0 without forces: v̇ = −M⁻¹h keeps the energy.
#[test]
fn free_motion_keeps_its_energy() {
    let robot = hrp2();
    let (configuration, v) = moving(&robot);
    let energy = |q: &Configuration, v: &DVector<f64>| {
        let mut d = Dynamics::new(&robot, q);
        d.update(&robot, q, v);
        0.5 * (v.transpose() * &d.M * v)[0] + d.kinematics.potential_energy()
    };
    let mut dynamics = Dynamics::new(&robot, &configuration);
    dynamics.update(&robot, &configuration, &v);
    let cholesky = dynamics.M.clone().cholesky().expect("positive definite");
    let acceleration = -cholesky.solve(&dynamics.h);
    let step = 1e-6;
    let at = |sign: f64| {
        let q = configuration.integrate(&(&v * (sign * step)));
        energy(&q, &(&v + &acceleration * (sign * step)))
    };
    let power = (at(1.0) - at(-1.0)) / (2.0 * step);
    assert!(power.abs() < 1e-3, "{power} W");
}
