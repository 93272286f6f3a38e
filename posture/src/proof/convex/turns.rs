//! What is kept of rotations: that they lengthen nothing, and turn about the axes of joints.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use nalgebra::{Rotation3, Unit, Vector3};

use super::SLACK;
use super::cones::{Cones, Form, Turn, along};

/// ‖R u‖ ≤ 1; roughly of the axes alone.
pub(super) fn lengthens_nothing(cones: &mut Cones, R: &Turn) {
    for i in 0..3 {
        cones.within(&R[i], 1.0);
        let others = if cones.is_rough { 3..3 } else { i + 1..3 };
        for j in others {
            for side in [-1.0, 1.0] {
                cones.within(&((&R[i] + &R[j] * side) * FRAC_1_SQRT_2), 1.0);
            }
        }
    }
}

/// A body that turns about an axis in the frame of its joint, within limits; which of the two frames is known.
pub(super) fn hinge(
    cones: &mut Cones,
    axis: Vector3<f64>,
    (lower, upper): (f64, f64),
    [joint, turn]: [&Turn; 2],
    known: [bool; 2],
) {
    if known == [true, true] {
        return;
    }
    let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower) + SLACK);
    let least = axis.iamin();
    let side = Vector3::ith(least, 1.0).cross(&axis).normalize();
    let sides = [side, axis.cross(&side)];
    let to_middle = Rotation3::from_axis_angle(&Unit::new_normalize(axis), middle);
    let at_middle = sides.map(|b| along(joint, &(to_middle * b)));
    let turned = sides.map(|b| along(turn, &b));
    cones.zero(&(along(joint, &axis) - along(turn, &axis)), &[0, 1, 2]);
    if half < PI {
        for k in 0..2 {
            let most = 2.0 * (0.5 * half).sin() + SLACK;
            cones.within(&(&at_middle[k] - &turned[k]), most);
        }
    }
    // In a plane that is known a turn is two numbers.
    let (fixed, free, axis) = match known {
        [true, _] => (at_middle, turned, along(joint, &axis)),
        [_, true] => (turned, at_middle, along(turn, &axis)),
        _ => return,
    };
    let n = cones.n;
    let [u, v, axis] = [&fixed[0], &fixed[1], &axis].map(|form| form.column(n).into_owned());
    let onto = |v: &Vector3<f64>, form: &Form| v.transpose() * form;
    let cos = onto(&u, &free[0]);
    let mut rows = Form::zeros(n + 1);
    rows.row_mut(0).copy_from(&(&cos - onto(&v, &free[1])));
    rows.row_mut(1)
        .copy_from(&(onto(&u, &free[1]) + onto(&v, &free[0])));
    cones.zero(&rows, &[0, 1]);
    for (k, free) in free.iter().enumerate() {
        rows.row_mut(k).copy_from(&onto(&axis, free));
    }
    cones.zero(&rows, &[0, 1]);
    if half < PI {
        rows.row_mut(2).copy_from(&cos);
        rows[(2, n)] -= half.cos() - SLACK;
        cones.positive(&rows, &[2]);
    }
}
