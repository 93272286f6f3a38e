//! Where feet stand under the posture that is wanted at the goal.
//!
//! The joints that are wanted, and the nominal posture's where none are, place the feet about the base; the
//! base is turned so that what they stand on is level. At the end of the way the feet are put there, and a
//! foot that stands elsewhere has to step once more: to a posture of all joints each foot's place fits one
//! way only.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use robot_model::{Configuration, ContactPatch, Kinematics, PatchId, Robot};

use crate::request::Request;
use crate::route::{Pose, heading, wrap};

/// Feet nearer to their place and heading than this stand there, m and rad.
const AT_PLACE_M: f64 = 0.02;
const AT_HEADING_RAD: f64 = 0.05;

/// Whether a foot at a place, with a heading where it has one, stands where it is wanted.
pub(crate) fn is_at(
    (at, heading): (Vector3<f64>, f64),
    place_W: &Vector3<f64>,
    yaw: Option<f64>,
) -> bool {
    let turned = yaw.map_or(0.0, |yaw| wrap(yaw - heading).abs());
    (at - place_W).xy().norm() < AT_PLACE_M && turned < AT_HEADING_RAD
}

/// The posture that is wanted, and its feet.
#[derive(Clone)]
pub(crate) struct GoalStance {
    /// Its base over W's origin, heading along x.
    pub q: Configuration,
    /// For each patch, where it is (of a ball its lowest point), and how a sole is turned about the vertical.
    places: Vec<(Vector3<f64>, f64)>,
    /// Whether joints of legs are wanted: those of arms alone let feet stand as they like.
    wants_legs: bool,
}

impl GoalStance {
    /// Of a request that wants joints; nothing where it wants none.
    pub fn new(request: &Request, feet: &[PatchId]) -> Option<Self> {
        let robot = request.robot;
        let wanted = request.goal.joints.as_ref()?;
        let mut q = Configuration::zero(robot.nj());
        q.joints.copy_from(&request.reference.joints);
        for (x, wanted) in q.joints.iter_mut().zip(&wanted.wanted) {
            *x = wanted.unwrap_or(*x);
        }
        let level = level(robot, &Kinematics::new(robot, &q), feet);
        q.R_WB = UnitQuaternion::rotation_between(&level, &Vector3::z()).unwrap_or_default();
        let about_up = |angle| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        q.R_WB = about_up(-heading(&(q.R_WB * Vector3::x()))) * q.R_WB;
        let kinematics = Kinematics::new(robot, &q);
        let place = |patch: &ContactPatch| {
            let X_WC = kinematics.X_WC(patch);
            let radius = patch.point_radius_m().unwrap_or(0.0);
            let lowest = X_WC.translation.vector - radius * Vector3::z();
            (lowest, heading(&(X_WC.rotation * Vector3::x())))
        };
        let places = robot.patches.iter().map(place).collect();
        let bears = |joint: usize| {
            let mut feet = feet.iter().map(|&f| robot.patches[f].body);
            feet.any(|foot| robot.supports(joint + 1, foot))
        };
        let mut joints = wanted.wanted.iter().enumerate();
        Some(Self {
            q,
            places,
            wants_legs: joints.any(|(joint, wanted)| wanted.is_some() && bears(joint)),
        })
    }

    /// Where a foot stands with the base at a pose of the route, and its heading, where the legs' posture is wanted.
    pub fn foot_at(&self, pose: &Pose, foot: PatchId) -> Option<(Vector3<f64>, f64)> {
        let (offset, turned) = self.wants_legs.then_some(self.places[foot.index()])?;
        Some((pose.foot(&offset), pose.heading + turned))
    }

    /// The posture with its base where feet that stand at places would have it, heading as they do on the mean.
    pub fn over(&self, feet: impl Iterator<Item = (PatchId, Vector3<f64>)>) -> Configuration {
        let feet: Vec<(Vector3<f64>, Vector3<f64>)> = feet
            .map(|(foot, stands)| (self.places[foot.index()].0, stands))
            .collect();
        let count = feet.len().max(1) as f64;
        let sum =
            |points: &mut dyn Iterator<Item = Vector3<f64>>| points.sum::<Vector3<f64>>() / count;
        let usual = sum(&mut feet.iter().map(|f| f.0));
        let stands = sum(&mut feet.iter().map(|f| f.1));
        // The turn that brings the feet nearest to where they stand.
        let (mut sin, mut cos) = (0.0, 0.0);
        for (at, is) in &feet {
            let (at, is) = ((at - usual).xy(), (is - stands).xy());
            (sin, cos) = (sin + at.perp(&is), cos + at.dot(&is));
        }
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), sin.atan2(cos));
        let base = Isometry3::from_parts((stands - turn * usual).into(), turn * self.q.R_WB);
        self.q.clone().with_base(&base)
    }
}

/// What is up for the base where its feet stand on level ground: across the plane of their places where there are
/// three, else what their soles have as up.
fn level(robot: &Robot, kinematics: &Kinematics, feet: &[PatchId]) -> Vector3<f64> {
    let poses = feet.iter().map(|&f| kinematics.X_WC(&robot.patches[f]));
    let soles = feet.iter().zip(poses.clone());
    let soles = soles.filter(|(f, _)| robot.patches[**f].point_radius_m().is_none());
    let up: Vector3<f64> = soles.map(|(_, X)| X.rotation * Vector3::z()).sum();
    if let Some(up) = up.try_normalize(1e-6) {
        return up;
    }
    if feet.len() < 3 {
        return Vector3::z();
    }
    let points: Vec<Vector3<f64>> = poses.map(|X| X.translation.vector).collect();
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> = points
        .iter()
        .map(|p| (p - middle) * (p - middle).transpose())
        .sum();
    let eigen = spread.symmetric_eigen();
    let across = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imin())
        .into_owned();
    if across.z < 0.0 { -across } else { across }
}
