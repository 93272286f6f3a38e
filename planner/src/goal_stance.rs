//! Where feet stand under the posture that is wanted at the goal.
//!
//! The joints that are wanted, and the nominal posture's where none are, place the feet about the base; the
//! base is turned so that what they stand on is level. At the end of the way the feet are put there, and a
//! foot that stands elsewhere has to step once more: to a posture of all joints each foot's place fits one
//! way only.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use posture::{Contact, JointGoal};
use robot_model::{Configuration, ContactPatch, Kinematics, PatchId, Robot};

use crate::context::{SearchContext, heading};
use crate::foothold::Foothold;
use crate::request::Request;
use crate::route::wrap;

/// Feet nearer to their place and heading than this stand there, m and rad.
const AT_PLACE_M: f64 = 0.02;
const AT_HEADING_RAD: f64 = 0.05;

/// The posture that is wanted, and its feet.
#[derive(Clone)]
pub(crate) struct GoalStance {
    /// Its base over W's origin, heading along x.
    pub q: Configuration,
    /// For each patch, where it is (of a ball its lowest point), and how a sole is turned about the vertical.
    places: Vec<(Vector3<f64>, f64)>,
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
        Some(Self { q, places })
    }

    /// Where a patch is about the base, and how it is turned.
    pub fn place(&self, patch: PatchId) -> (Vector3<f64>, f64) {
        self.places[patch.index()]
    }

    /// The posture with its base where the contacts would have it, heading as they do on the mean.
    pub fn over(&self, context: &SearchContext, contacts: &[Contact]) -> Configuration {
        let feet = contacts.iter().filter(|c| context.foot(c.patch).is_some());
        let feet: Vec<(Vector3<f64>, Vector3<f64>)> = feet
            .map(|c| (self.place(c.patch).0, context.place_W(c)))
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

impl SearchContext<'_> {
    /// Where a foot stands at the end of the way, and its heading, where a posture is wanted there.
    pub fn stand_at_goal(&self, patch: PatchId) -> Option<(Vector3<f64>, f64)> {
        let (offset, turned) = self.goal_stance.as_ref()?.place(patch);
        let end_m = self.route.length_m();
        let place = self.route.foot_at(end_m, &offset);
        Some((place, self.route.at(end_m).heading + turned))
    }

    /// Whether a foot at a place stands where the posture that is wanted at the goal has it; nothing where none is wanted.
    pub fn has_arrived(
        &self,
        patch: PatchId,
        place_W: &Vector3<f64>,
        yaw: Option<f64>,
    ) -> Option<bool> {
        self.foot(patch)?;
        let (at, heading) = self.stand_at_goal(patch)?;
        let turned = yaw.map_or(0.0, |yaw| wrap(yaw - heading).abs());
        Some((at - place_W).xy().norm() < AT_PLACE_M && turned < AT_HEADING_RAD)
    }

    /// The posture problem's joints at the goal, and that posture over the contacts.
    pub fn wanted_over(&self, contacts: &[Contact]) -> Option<(&JointGoal, Configuration)> {
        let joints = self.request.goal.joints.as_ref()?;
        Some((joints, self.goal_stance.as_ref()?.over(self, contacts)))
    }
}

impl Foothold {
    /// Kept exactly where it is, if that is the place of a foot at the goal and its sole is inside the face there.
    pub fn at_goal(self, context: &SearchContext) -> Self {
        let wanted = context.stand_at_goal(self.patch);
        let at_end = self.along_m >= context.end_m();
        let Some((at, heading)) = wanted.filter(|_| at_end && self.variation == 0) else {
            return self;
        };
        let is_there = (at - self.place.coords).xy().norm() < AT_PLACE_M
            && self
                .yaw_rad
                .is_none_or(|yaw| wrap(yaw - heading).abs() < AT_HEADING_RAD);
        if !is_there {
            return self;
        }
        let exact = self.fixed(context, heading);
        Self { exact, ..self }
    }

    /// The contact at its place, turned to a heading; nothing where its sole sticks out of the face.
    fn fixed(&self, context: &SearchContext, heading: f64) -> Option<Contact> {
        let request = context.request;
        let shape = &request.robot.patches[self.patch];
        let area = self.area(context)?;
        let rotation = match shape.point_radius_m() {
            // How a ball is turned does not matter.
            Some(_) => area.X_WF.rotation,
            None => {
                let up = area.X_WF.rotation * Vector3::z();
                let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
                let ahead = (ahead - up * up.dot(&ahead)).try_normalize(1e-6)?;
                let axes = Matrix3::from_columns(&[ahead, up.cross(&ahead), up]);
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
            }
        };
        let at = Isometry3::from_parts(self.place.into(), rotation);
        let to_F = area.X_WF.inverse() * at;
        let inside = |p: &nalgebra::Point2<f64>| {
            let p = to_F * nalgebra::Point3::new(p.x, p.y, 0.0);
            area.polygon.signed_distance(&p.xy()) <= -context.patch_margin_m
        };
        let contact = Contact::at(request.robot, self.patch, shape.touching(&at));
        let contact = contact.on(self.face, request.environment).loaded(false);
        (shape.point_radius_m().is_some() || shape.polygon.iter().all(inside)).then_some(contact)
    }
}
