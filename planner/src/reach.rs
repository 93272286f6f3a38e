//! How far patches reach: bounds by lengths alone, whatever the joints, and the stride that a leg has on
//! a slope.
//!
//! Between two bodies there is the chain of links that joins them; nothing on it is farther apart than its
//! links are long. The centre of mass is the mean of those of the bodies:
//!
//!   ‖p_C − c‖ = ‖Σ m_i (p_C − c_i)‖ / M ≤ Σ m_i d(C, c_i) / M

use nalgebra::{Point3, Vector2, Vector3};
use robot_model::{ContactPatch, Kinematics, PatchId, Robot};

/// How far the patches of a robot reach.
#[derive(Clone)]
pub(crate) struct Reach {
    /// For each patch, an upper bound of its distance from the base, m.
    base_m: Vec<f64>,
    /// For each two patches, an upper bound of their distance, m.
    span_m: Vec<Vec<f64>>,
    /// For each patch, an upper bound of the distance of its middle from the centre of mass, m.
    com_m: Vec<f64>,
    /// For each patch, the leg that carries it.
    leg: Vec<Leg>,
}

impl Reach {
    /// Of a robot whose nominal posture is `upright`.
    pub fn new(robot: &Robot, upright: &Kinematics) -> Self {
        let base = (0, Vector3::zeros());
        let end = |patch: &ContactPatch| (patch.body, patch.X_BC.translation.vector);
        let patches = || robot.patches.iter();
        let com_m = patches().map(|patch| {
            let middle = patch.X_BC * middle(patch);
            let bodies = robot.bodies.iter().enumerate();
            let parts = bodies.map(|(i, body)| {
                body.mass_kg * apart_m(robot, (patch.body, middle.coords), (i, body.com_B))
            });
            parts.sum::<f64>() / robot.mass_kg
        });
        Self {
            base_m: patches().map(|p| apart_m(robot, base, end(p))).collect(),
            span_m: patches()
                .map(|a| patches().map(|b| apart_m(robot, end(a), end(b))).collect())
                .collect(),
            com_m: com_m.collect(),
            leg: patches().map(|p| Leg::new(robot, upright, p)).collect(),
        }
    }

    /// An upper bound of a patch's distance from the base, m.
    pub fn base_m(&self, patch: PatchId) -> f64 {
        self.base_m[patch.index()]
    }

    /// An upper bound of the distance between two patches, m.
    pub fn span_m(&self, a: PatchId, b: PatchId) -> f64 {
        self.span_m[a.index()][b.index()]
    }

    /// An upper bound of the distance of a patch's middle from the centre of mass, m.
    pub fn com_m(&self, patch: PatchId) -> f64 {
        self.com_m[patch.index()]
    }

    /// The leg that carries a patch.
    pub fn leg(&self, patch: PatchId) -> &Leg {
        &self.leg[patch.index()]
    }
}

/// The middle of a patch's corners, in its frame.
fn middle(patch: &ContactPatch) -> Point3<f64> {
    let sum: Vector2<f64> = patch.polygon.iter().map(|p| p.coords).sum();
    Point3::from((sum / patch.polygon.len().max(1) as f64).push(0.0))
}

/// An upper bound of the distance between points of two bodies, each in its body's frame, m.
fn apart_m(robot: &Robot, a: (usize, Vector3<f64>), b: (usize, Vector3<f64>)) -> f64 {
    // What is left of the way up from either end: its body, the point in it, and the length so far.
    let mut ends = [(a.0, a.1, 0.0), (b.0, b.1, 0.0)];
    while ends[0].0 != ends[1].0 {
        // Parents come before children: the later body is below what both share.
        let lower = usize::from(ends[1].0 > ends[0].0);
        let (body, p, length) = ends[lower];
        let link = &robot.bodies[body];
        let (up, so_far) = (link.parent.unwrap_or(0), length + p.norm() + link.slide_m());
        ends[lower] = (up, link.X_PJ.translation.vector, so_far);
    }
    ends[0].2 + ends[1].2 + (ends[0].1 - ends[1].1).norm()
}

/// A leg, from its first joint to its patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    /// Length stretched out, m.
    pub length_m: f64,
    /// Height of the first joint over the patch in the nominal posture, m.
    pub height_m: f64,
}

impl Leg {
    fn new(robot: &Robot, kinematics: &Kinematics, patch: &ContactPatch) -> Self {
        let mut length_m = patch.X_BC.translation.vector.norm();
        let mut body = patch.body;
        while let Some(parent) = robot.bodies[body].parent.filter(|&p| p != 0) {
            length_m += robot.bodies[body].X_PJ.translation.vector.norm();
            body = parent;
        }
        let foot = kinematics.X_WC(patch).translation.vector;
        Self {
            length_m,
            height_m: (kinematics.origin_W[body].z - foot.z).max(0.0),
        }
    }

    /// How far down a slope of `delta` the foot reaches from below the first joint, at the usual
    /// height over it, m.
    ///
    ///   ‖(s cos δ, h + s sin δ)‖ = L   ⇒   s = √(L² − h² cos² δ) − h sin δ
    pub fn range_m(&self, delta: f64) -> f64 {
        let (sin, cos) = delta.sin_cos();
        let (l, h) = (self.length_m, self.height_m);
        ((l * l - h * h * cos * cos).max(0.0).sqrt() - h * sin).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use robot_model::Configuration;

    use super::*;

    /// Every bound holds in postures all over the joints' ranges, and that of neighbours is sharp.
    #[test]
    fn no_posture_reaches_farther_than_the_bounds() {
        let robot = scenes::robot("hrp2").unwrap();
        let mut q = Configuration::zero(robot.nj());
        let reach = Reach::new(&robot, &Kinematics::new(&robot, &q));
        let (mut widest, mut draw) = (0.0_f64, 0.5_f64);
        for _ in 0..200 {
            for (joint, body) in q.joints.iter_mut().zip(&robot.bodies[1..]) {
                draw = (draw * 997.0 + 0.137).fract();
                *joint = body.lower + draw * (body.upper - body.lower);
            }
            let kinematics = Kinematics::new(&robot, &q);
            let com = kinematics.com_W;
            for a in robot.patch_ids() {
                let patch = &robot.patches[a];
                let X_WC = kinematics.X_WC(patch);
                let p = X_WC.translation.vector;
                assert!(p.norm() <= reach.base_m(a) + 1e-9);
                let middle = X_WC * middle(patch);
                assert!((middle.coords - com).norm() <= reach.com_m(a) + 1e-9);
                for b in robot.patch_ids() {
                    let other = kinematics.X_WC(&robot.patches[b]).translation.vector;
                    assert!((p - other).norm() <= reach.span_m(a, b) + 1e-9);
                    widest = widest.max((p - other).norm() / reach.span_m(a, b).max(1e-9));
                }
            }
        }
        assert!(widest > 0.6, "{widest}");
    }
}
