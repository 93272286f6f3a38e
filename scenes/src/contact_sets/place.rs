//! Surfaces where the patches of a configuration are.

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, Kinematics, PatchKind};
use surfaces::ConvexPolygon;

use super::draw::Draws;
use super::forces::Support;
use super::limbs::Limb;
use super::record::{ContactRecord, Expected, ProblemRecord};
use super::{Limbs, Maker};

/// A touched place: the limb and the pose of the surface there.
pub(super) struct Touch<'a> {
    pub limb: &'a Limb,
    /// Origin at C's, or at the touched point of a ball; z the outward normal.
    pub X_WS: Isometry3<f64>,
}

/// What is left of a patch's half width that is shrunk: this part or this length, m. The posture generator leaves 0.4
/// or 10 mm.
const LEFT_PART: f64 = 0.35;
const LEFT_M: f64 = 0.008;

impl Maker<'_> {
    /// Moves a configuration to a drawn heading and place, the lowest touching patch at z = 0.
    pub fn set_down(&self, q: &mut Configuration, limbs: &[&Limb], draws: &mut Draws) {
        let yaw = draws.between(-std::f64::consts::PI, std::f64::consts::PI);
        q.R_WB = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw) * q.R_WB;
        q.p_WB = Vector3::new(draws.between(-1.0, 1.0), draws.between(-1.0, 1.0), 0.0);
        let kinematics = Kinematics::new(self.robot, q);
        let height = |limb: &&Limb| {
            let patch = &self.robot.patches[limb.patch];
            kinematics.X_WC(patch).translation.z
        };
        let lowest = limbs.iter().map(height).fold(f64::INFINITY, f64::min);
        if lowest.is_finite() {
            q.p_WB.z = -lowest;
        }
    }

    /// The places that the limbs touch at a configuration; under a ball the surface is `under`.
    pub fn touches<'a>(
        &self,
        q: &Configuration,
        limbs: &[&'a Limb],
        under: Under,
        draws: &mut Draws,
    ) -> Vec<Touch<'a>> {
        let kinematics = Kinematics::new(self.robot, q);
        let touch = |&limb: &&'a Limb| {
            let patch = &self.robot.patches[limb.patch];
            let mut X_WS = kinematics.X_WC(patch);
            if let PatchKind::Point { radius_m } = patch.kind {
                let R = under.draw(&(q.p_WB - X_WS.translation.vector), draws);
                let p = X_WS.translation.vector - R * Vector3::new(0.0, 0.0, radius_m);
                X_WS = Isometry3::from_parts(Translation3::from(p), R);
            }
            Touch { limb, X_WS }
        };
        limbs.iter().map(touch).collect()
    }

    /// Where forces act: the patches, shrunk where `inset_m` says so, until [`LEFT_PART`] or [`LEFT_M`] of their
    /// half width is left.
    pub fn supports(&self, touches: &[Touch], inset_m: f64) -> Vec<Support> {
        let support = |touch: &Touch| {
            let patch = &self.robot.patches[touch.limb.patch];
            let whole = ConvexPolygon::new(patch.polygon.clone()).ok();
            let shrunk = whole.and_then(|p| {
                let half_width_m = p.inscribed_circle().1;
                p.inset(inset_m.min(half_width_m - LEFT_M.min(LEFT_PART * half_width_m)))
            });
            let points = shrunk.map_or_else(|| patch.polygon.clone(), |p| p.vertices().to_vec());
            let points = points.iter();
            let in_W = |v: &Point2<f64>| (touch.X_WS * Point3::new(v.x, v.y, 0.0)).coords;
            Support {
                body: patch.body,
                points_W: points.map(in_W).collect(),
                axes: touch.X_WS.rotation.to_rotation_matrix(),
                least_load: 0.0,
            }
        };
        touches.iter().map(support).collect()
    }

    /// The problem of fixed contacts at these places.
    pub fn fixed(&self, touches: &[Touch], mu: f64) -> ProblemRecord {
        ProblemRecord {
            id: serde_json::Value::Null,
            mu: decimals(mu, 3),
            contacts: touches.iter().map(|t| self.contact(t)).collect(),
            surfaces: Vec::new(),
            expected: None,
            reason: None,
            witness: None,
        }
    }

    /// The problem with the configuration that solves it.
    pub fn witnessed(&self, problem: ProblemRecord, q: &Configuration) -> ProblemRecord {
        ProblemRecord {
            expected: Some(Expected::Solvable),
            witness: Some(q.to_q()),
            ..problem
        }
    }

    fn contact(&self, touch: &Touch) -> ContactRecord {
        let patch = &self.robot.patches[touch.limb.patch];
        ContactRecord {
            link: patch.link.clone(),
            patch: Some(patch.name.clone()),
            p: Some(touch.X_WS.translation.vector.into()),
            R: Some(rows(&touch.X_WS.rotation.to_rotation_matrix())),
            // A ball may turn as it likes.
            yaw_free: patch.point_radius_m().is_some(),
            surface: None,
        }
    }
}

/// How a surface under a ball is tilted against the vertical: between these angles, rad.
#[derive(Clone, Copy)]
pub(super) enum Under {
    /// Toward any side.
    Any([f64; 2]),
    /// Toward the robot's middle, up to an angle off it.
    Inward([f64; 2], f64),
}

impl Under {
    /// The rotation of a surface whose z is its normal; `inward` leads to the middle.
    fn draw(self, inward: &Vector3<f64>, draws: &mut Draws) -> UnitQuaternion<f64> {
        match self {
            Under::Any([least, most]) => draws.tilt(least, most),
            Under::Inward([least, most], off) => {
                let azimuth = inward.y.atan2(inward.x) + draws.between(-off, off);
                let axis = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
                UnitQuaternion::new(axis * draws.between(least, most))
            }
        }
    }
}

impl Limbs {
    /// Two feet, or at least three of more.
    pub fn some_feet(&self, draws: &mut Draws) -> Vec<&Limb> {
        let feet: Vec<&Limb> = self.feet.iter().collect();
        let n = match feet.len() {
            0..=3 => feet.len(),
            many => 3 + draws.index(many - 2),
        };
        draws.some(&feet, n)
    }

    /// At least `least` and at most `most` hands, as far as there are any.
    pub fn some_hands(&self, [least, most]: [usize; 2], draws: &mut Draws) -> Vec<&Limb> {
        let hands: Vec<&Limb> = self.hands.iter().collect();
        let n = (least + draws.index(most - least + 1)).min(hands.len());
        draws.some(&hands, n)
    }
}

/// A rotation by rows.
pub(super) fn rows(R: &Rotation3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| R[(i, j)]))
}

/// A number rounded to so many decimals.
pub(super) fn decimals(value: f64, n: i32) -> f64 {
    let scale = 10f64.powi(n);
    (value * scale).round() / scale
}

/// Angle of a frame's z against the vertical, rad.
pub(super) fn tilt(X: &Isometry3<f64>) -> f64 {
    (X.rotation * Vector3::z()).angle(&Vector3::z())
}
