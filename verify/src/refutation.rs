//! Proofs that contacts have no posture, recomputed.
//!
//! Links too near to each other are measured where their contacts put them (`colliding`); of multipliers the
//! least value of their sum is bounded from below (`multipliers`, `turns`). What is wrong in a proof makes that
//! bound lower, never higher: nothing of it is believed.

mod colliding;
mod multipliers;
mod turns;

use nalgebra::{Matrix3, Matrix4, Vector3};
use plan::{ContactPlace, PlaceFreedom, Proof, Refutation};
use robot_model::{ContactPatch, Robot};

use crate::posture::{column, pose};

/// What must be left, m or parts of the weight: postures are off their contacts by up to 1e-5 m, rounding is far less.
const CERTAIN: f64 = 3e-5;
/// Largest margin and coefficient of friction.
const MARGIN_MAX: f64 = 1e3;

/// By how much a proof holds, m or parts of the weight.
///
/// # Errors
/// Why it does not hold.
pub fn refuted(refutation: &Refutation, robot: &Robot) -> Result<f64, String> {
    let required = &refutation.required;
    let margins = [
        required.friction_use,
        required.torque_use,
        required.joint_rad,
        required.clearance_m,
        required.self_clearance_m,
        required.com_m,
    ];
    if !margins.iter().all(|x| (0.0..=MARGIN_MAX).contains(x)) {
        return Err("the margins make no sense".to_owned());
    }
    let places = refutation.contacts.iter().map(|stated| {
        let mut patches = robot.patches.iter();
        let patch = patches.find(|patch| patch.name == stated.patch);
        let patch = patch.ok_or_else(|| format!("the robot has no patch {:?}", stated.patch))?;
        let X_WC = pose(&stated.X_WC.p, &stated.X_WC.quat_xyzw);
        let friction = (0.0..=MARGIN_MAX).contains(&stated.friction);
        let sane = X_WC.iter().all(|x| x.is_finite()) && friction;
        match sane {
            true => Ok(Place {
                stated,
                patch,
                X_WC,
            }),
            false => Err(format!("{} is nowhere", stated.patch)),
        }
    });
    let claim = Claim {
        robot,
        required,
        places: places.collect::<Result<_, String>>()?,
    };
    let left = match &refutation.proof {
        Proof::Colliding { link, other } => claim.overlap_m(link, other)?,
        Proof::Multipliers(multipliers) => claim.least(multipliers)?,
    };
    match left > CERTAIN && left.is_finite() {
        true => Ok(left),
        false => Err(format!("{left:.1e} is left, {CERTAIN:.0e} must be")),
    }
}

/// A contact, and where it is asked to be.
struct Place<'a> {
    stated: &'a ContactPlace,
    patch: &'a ContactPatch,
    X_WC: Matrix4<f64>,
}

impl Place<'_> {
    /// Where it puts its body; nothing where that may turn.
    fn put(&self) -> Option<Matrix4<f64>> {
        let puts =
            self.stated.freedom == PlaceFreedom::Fixed && self.patch.point_radius_m().is_none();
        let [X_WC, X_BC] = [self.X_WC, self.patch.X_BC.to_homogeneous()];
        puts.then(|| X_WC * X_BC.try_inverse().unwrap_or_else(Matrix4::identity))
    }

    /// Whether it is known where its forces act.
    fn is_settled(&self) -> bool {
        match self.stated.freedom {
            PlaceFreedom::Fixed => true,
            PlaceFreedom::Yaw => self.patch.point_radius_m().is_some(),
            PlaceFreedom::Elsewhere => false,
        }
    }

    fn R(&self) -> Matrix3<f64> {
        self.X_WC.fixed_view::<3, 3>(0, 0).into_owned()
    }

    fn p(&self) -> Vector3<f64> {
        column(&self.X_WC, 3)
    }
}

/// What is said of which contacts.
struct Claim<'a> {
    robot: &'a Robot,
    required: &'a plan::RequiredMargins,
    places: Vec<Place<'a>>,
}

impl Claim<'_> {
    /// Where a contact puts a body.
    fn put(&self, body: usize) -> Option<Matrix4<f64>> {
        let mut on = self.places.iter().filter(|p| p.patch.body == body);
        on.find_map(Place::put)
    }
}
