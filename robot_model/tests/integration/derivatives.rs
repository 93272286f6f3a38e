//! Every derivative against central differences along `Configuration::integrate`.

use nalgebra::{DMatrix, DVector, Point3, Vector3};
use proptest::prelude::*;
use robot_model::collision::{Other, Proximity};
use robot_model::{Configuration, Kinematics, Robot};

use crate::support;

/// Steps of 1e-6 leave 1e-12 of truncation and 1e-10 of rounding on values near one.
const STEP: f64 = 1e-6;
const TOLERANCE: f64 = 1e-7;

/// ∂f/∂v by central differences; a column a velocity.
fn differences<const N: usize>(
    robot: &Robot,
    at: &Configuration,
    f: impl Fn(&Kinematics) -> [f64; N],
) -> DMatrix<f64> {
    let mut slope = DMatrix::zeros(N, robot.nv());
    for column in 0..robot.nv() {
        let mut step = DVector::zeros(robot.nv());
        step[column] = STEP;
        let ahead = f(&Kinematics::new(robot, &at.integrate(&step)));
        let behind = f(&Kinematics::new(robot, &at.integrate(&-step)));
        for row in 0..N {
            slope[(row, column)] = (ahead[row] - behind[row]) / (2.0 * STEP);
        }
    }
    slope
}

fn assert_near(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> Result<(), TestCaseError> {
    let scale = expected.amax().max(1.0);
    let error = (found - expected).amax();
    let is_near = error < TOLERANCE * scale;
    prop_assert!(is_near, "off by {error}:\n{found}\n{expected}");
    Ok(())
}

proptest! {
    #![proptest_config(support::cases(32))]

    #[test]
    fn jacobians_are_derivatives(
        at in support::configuration(&support::test_tree()),
        p in prop::array::uniform3(-0.5..0.5_f64),
        body in 0..5_usize,
    ) {
        let robot = support::test_tree();
        prop_assert_eq!(robot.bodies.len(), 5);
        let kinematics = Kinematics::new(&robot, &at);
        let p_B = Point3::from(p);
        let mut J = DMatrix::zeros(3, robot.nv());

        let p_W = (kinematics.X_WB[body] * p_B).coords;
        kinematics.point_jacobian(&robot, body, &p_W, &mut J);
        let slope = differences(&robot, &at, |k| (k.X_WB[body] * p_B).into());
        assert_near(&J, &slope)?;

        let n = Vector3::new(0.48, -0.6, 0.64);
        let mut row = vec![0.0; robot.nv()];
        kinematics.add_point_row(&robot, body, &p_W, &n, -2.0, &mut row);
        let expected = -2.0 * n.transpose() * &J;
        assert_near(&DMatrix::from_row_slice(1, robot.nv(), &row), &DMatrix::from_rows(&[expected]))?;

        // The rotation vector from here to there, in W.
        kinematics.angular_jacobian(&robot, body, &mut J);
        let R_0 = kinematics.X_WB[body].rotation;
        let slope = differences(&robot, &at, |k| {
            (k.X_WB[body].rotation * R_0.inverse()).scaled_axis().into()
        });
        assert_near(&J, &slope)?;

        kinematics.com_jacobian(&robot, &mut J);
        assert_near(&J, &differences(&robot, &at, |k| k.com_W.into()))?;
    }

    #[test]
    fn gravity_torques_are_the_slope_of_potential_energy(
        at in support::configuration(&support::test_tree())
    ) {
        let robot = support::test_tree();
        let mut g = DVector::zeros(robot.nv());
        Kinematics::new(&robot, &at).gravity_torques(&robot, &mut g);
        let slope = differences(&robot, &at, |k| [k.potential_energy()]);
        assert_near(&DMatrix::from_row_slice(1, robot.nv(), g.as_slice()), &slope)?;
    }

    /// ḋ = n·(v_pa − v_pb), for separated and overlapping pairs of shapes.
    #[test]
    fn distance_gradients_are_those_of_the_witness_points(
        at in support::configuration(&support::test_tree())
    ) {
        let robot = support::test_tree();
        let find = |k: &Kinematics| {
            let mut near: Vec<Proximity> = Vec::new();
            robot.collision.self_proximities(k, f64::INFINITY, &mut near);
            near
        };
        let kinematics = Kinematics::new(&robot, &at);
        let near = find(&kinematics);
        prop_assert_eq!(near.len(), robot.collision.pairs().len());
        for (i, proximity) in near.iter().enumerate() {
            let Other::Shape(b) = proximity.b else { continue };
            let n = proximity.normal_W;
            let mut row = vec![0.0; robot.nv()];
            let (a, p_a, p_b) = (proximity.a.body, proximity.p_a_W, proximity.p_b_W);
            kinematics.add_point_row(&robot, a, &p_a, &n, 1.0, &mut row);
            kinematics.add_point_row(&robot, b.body, &p_b, &n, -1.0, &mut row);
            let slope = differences(&robot, &at, |k| [find(k)[i].distance]);
            let ahead = differences(&robot, &at, |k| find(k)[i].normal_W.into());
            // Where the normal jumps within a step, the distance has a kink and no gradient;
            // a smooth normal turns by no more than a few times the step.
            prop_assume!(ahead.amax() < 1e2);
            // GJK stops at a relative 5e-8, which the step divides by.
            let error = (DMatrix::from_row_slice(1, robot.nv(), &row) - slope).amax();
            prop_assert!(error < 2e-2, "pair {i}: off by {error}");
        }
    }
}
