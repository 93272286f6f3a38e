//! How deep a limb reaches, joint values that bring its end to a place, and how well it moves there.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};

use super::limb::Limb;
use crate::{Configuration, Kinematics, Robot};

/// Rounds of the coordinate ascent.
const ROUNDS: usize = 12;
/// Iterations of the descent to a place.
const ITERATIONS: usize = 60;
/// Longest change of a joint in one of them, rad or m.
const STEP_MAX: f64 = 0.3;
/// How near the place is near enough, m and rad.
const NEAR: f64 = 1e-7;
/// Length at which an angle counts as a distance, m/rad.
const ARM_M: f64 = 0.2;

/// The end of a limb: what is brought to places.
#[derive(Clone, Debug, PartialEq)]
pub struct Tip {
    /// The body.
    pub body: usize,
    /// Frame C at the end, in the body.
    pub X_BC: Isometry3<f64>,
    /// Whether C's z is to be brought upright, and its x ahead, too.
    pub flat: bool,
}

impl Tip {
    /// The point of a limb's last body that is farthest from its joint.
    pub fn of(robot: &Robot, limb: &Limb) -> Self {
        let body = limb.end();
        let shapes = robot.collision.shapes().iter().filter(|s| s.body == body);
        let far = |d: Vector3<f64>| {
            let points = shapes
                .clone()
                .map(|s| s.X_BG * s.geometry.support(&(s.X_BG.rotation.inverse() * d)));
            points.max_by(|a, b| a.coords.dot(&d).total_cmp(&b.coords.dot(&d)))
        };
        let axes = (0..6).map(|k| Vector3::ith(k % 3, if k < 3 { 1.0 } else { -1.0 }));
        let points = axes.filter_map(far);
        let tip = points.max_by(|a, b| a.coords.norm().total_cmp(&b.coords.norm()));
        let p = tip.unwrap_or_else(|| Point3::from(robot.bodies[body].com_B));
        Self {
            body,
            X_BC: Isometry3::translation(p.x, p.y, p.z),
            flat: false,
        }
    }

    /// Where it is in W, m.
    pub fn p_W(&self, kinematics: &Kinematics) -> Vector3<f64> {
        (kinematics.X_WB[self.body] * self.X_BC).translation.vector
    }
}

/// The configuration, all other joints neutral and the base at the origin, in which the tip is
/// deepest, and how deep: coordinate ascent, whose every step is exact, as the height is
/// a + b cos q + c sin q.
pub fn deepest(robot: &Robot, limb: &Limb, tip: &Tip) -> (Configuration, f64) {
    let depth = |q: &Configuration| -tip.p_W(&Kinematics::new(robot, q)).z;
    let mut best = (robot.neutral(), f64::NEG_INFINITY);
    for mut q in limb.starts(robot, &robot.neutral(), 8) {
        for _ in 0..ROUNDS {
            for &body in &limb.bodies {
                let (j, of) = (body - 1, &robot.bodies[body]);
                let mut at = |value: f64| {
                    q.joints[j] = value;
                    depth(&q)
                };
                let quarter = std::f64::consts::FRAC_PI_2;
                let (zero, half) = (at(0.0), at(2.0 * quarter));
                let (a, b) = (0.5 * (zero + half), 0.5 * (zero - half));
                let top = (at(quarter) - a).atan2(b);
                let turn = std::f64::consts::TAU;
                let tops = [top - turn, top, top + turn].map(|t| t.clamp(of.lower, of.upper));
                let values = tops.into_iter().chain([of.lower, of.upper]);
                let best = values.max_by(|x, y| at(*x).total_cmp(&at(*y)));
                q.joints[j] = best.unwrap_or(0.0);
            }
        }
        let deep = depth(&q);
        if deep > best.1 + 1e-6 {
            best = (q, deep);
        }
    }
    best
}

/// Rows of the limb's joints: the tip's place and, where it is flat, its turn.  Shapes: 3 or 6 × n.
fn jacobian(robot: &Robot, limb: &Limb, tip: &Tip, kinematics: &Kinematics) -> DMatrix<f64> {
    let p_W = tip.p_W(kinematics);
    let mut J = DMatrix::zeros(if tip.flat { 6 } else { 3 }, robot.nv());
    kinematics.point_jacobian(robot, tip.body, &p_W, &mut J.rows_mut(0, 3));
    if tip.flat {
        kinematics.angular_jacobian(robot, tip.body, &mut J.rows_mut(3, 3));
    }
    J.select_columns(&limb.bodies.iter().map(|b| b + 5).collect::<Vec<_>>())
}

/// Brings the tip to a place, or to a pose where it is flat, by the limb's joints alone; `None` where
/// descent from `start` does not find such values within the limits.
pub fn place(
    robot: &Robot,
    limb: &Limb,
    tip: &Tip,
    X_WC: &Isometry3<f64>,
    start: &Configuration,
) -> Option<Configuration> {
    let mut q = start.clone();
    let mut kinematics = Kinematics::new(robot, &q);
    for _ in 0..ITERATIONS {
        let is = kinematics.X_WB[tip.body] * tip.X_BC;
        let off = X_WC.translation.vector - is.translation.vector;
        let turn = (X_WC.rotation * is.rotation.inverse()).scaled_axis();
        let mut error = DVector::zeros(if tip.flat { 6 } else { 3 });
        error.rows_mut(0, 3).copy_from(&off);
        if tip.flat {
            error.rows_mut(3, 3).copy_from(&(turn * ARM_M));
        }
        if error.amax() < NEAR {
            return Some(q);
        }
        let mut J = jacobian(robot, limb, tip, &kinematics);
        if tip.flat {
            J.rows_mut(3, 3).scale_mut(ARM_M);
        }
        // A joint at a limit that the error pushes against stays there.
        let g = J.tr_mul(&error);
        for (k, &body) in limb.bodies.iter().enumerate() {
            let (value, of) = (q.joints[body - 1], &robot.bodies[body]);
            if (value >= of.upper && g[k] > 0.0) || (value <= of.lower && g[k] < 0.0) {
                J.column_mut(k).fill(0.0);
            }
        }
        let damping = 1e-5 + 1e-2 * error.norm_squared();
        let gram = J.tr_mul(&J) + DMatrix::identity(J.ncols(), J.ncols()) * damping;
        let step = gram.cholesky()?.solve(&J.tr_mul(&error));
        let scale = (STEP_MAX / step.amax().max(1e-12)).min(1.0);
        for (k, &body) in limb.bodies.iter().enumerate() {
            let of = &robot.bodies[body];
            let value = &mut q.joints[body - 1];
            *value = (*value + scale * step[k]).clamp(of.lower, of.upper);
        }
        kinematics.update(robot, &q);
    }
    None
}

/// How well the limb moves its tip there: the volume that the tip's velocities span for joint rates
/// in a ball, of a flat one those that do not turn it.
///
///   w = √(det J Jᵀ / det R Rᵀ),   R the rows of J that turn
///
/// Of a limb with fewer joints than rows the volume of what there is.
pub fn dexterity(robot: &Robot, limb: &Limb, tip: &Tip, q: &Configuration) -> f64 {
    let J = jacobian(robot, limb, tip, &Kinematics::new(robot, q));
    let volume = |J: &DMatrix<f64>| J.clone().singular_values().iter().product::<f64>();
    if !tip.flat {
        return volume(&J);
    }
    volume(&J) / volume(&J.rows(3, 3).into_owned()).max(1e-9)
}
