//! A place where a patch may touch a face.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Rotation3, UnitQuaternion, Vector3};
use posture::{Area, Contact, FaceIndex, Freedom};
use robot_model::PatchId;

use crate::context::SearchContext;
use crate::goal_stance::is_at;
use crate::node::Node;
use crate::sole_room::{has_room, heading_with_room};

/// Price of each place after the first, in contacts.
const VARIATION_PRICE: f64 = 0.25;
/// Price of a metre across the route from the place that is wanted, in contacts: a foot steps onto what is
/// under it rather than beside it.
const MOVED_PRICE: f64 = 2.0;

/// Soles beside each other whose headings differ by less than this are parallel, rad: the next turns outward.
const OUTWARD_RAD: f64 = 0.1;

/// A place where a patch should touch a face, and how far it may be moved from there.
#[derive(Clone, Debug)]
pub(crate) struct Foothold {
    pub patch: PatchId,
    pub face: FaceIndex,
    /// The point of the face, in W.
    pub place: Point3<f64>,
    /// Heading of a foot.
    pub yaw_rad: Option<f64>,
    /// Progress along the route that was aimed at, m.
    pub along_m: f64,
    /// How far across the route the face's room moved it from there, m.
    pub moved_m: f64,
    /// Its number in the order in which places on a face are tried.
    pub variation: usize,
    /// The contact itself, where its place was found together with what follows on it.
    pub exact: Option<Box<Contact>>,
}

impl Foothold {
    /// The contact that is asked for, not loaded yet; nothing where the face has no room for it.
    pub fn contact(&self, context: &SearchContext) -> Option<Contact> {
        let exact = self.exact.as_deref().cloned();
        exact.or_else(|| self.free(context))
    }

    /// As [`Self::contact`], free to move about on the face.
    pub fn free(&self, context: &SearchContext) -> Option<Contact> {
        let request = context.request;
        let area = self.area(context)?;
        let at = Isometry3::from_parts(self.place.into(), area.X_WF.rotation);
        let at = request.robot.patches[self.patch].touching(&at);
        Some(Contact {
            freedom: Freedom::Within(Box::new(area)),
            ..Contact::at(request.robot, self.patch, at)
                .on(self.face, request.environment)
                .loaded(false)
        })
    }

    /// Turned, where it is a sole, as little as it has to be to have room on its face, of two ways toward the soles
    /// that stand, else outward; nothing where it, or a hand, has none whichever way it is turned.
    pub fn with_room(self, context: &SearchContext, node: &Node) -> Option<Self> {
        let shape = &context.request.robot.patches[self.patch];
        if shape.point_radius_m().is_some() {
            return Some(self);
        }
        let area = self.area(context)?;
        let margin_m = context.patch_margin_m;
        let Some(wanted_rad) = self.yaw_rad else {
            return has_room(&shape.polygon, &area, margin_m).then_some(self);
        };
        let stand = node.contacts.iter().filter(|c| c.patch != self.patch);
        let yaw_rad = stand.filter_map(|c| context.yaw(c)).next_back();
        let outward_rad = context.offset(self.patch).y.signum() * OUTWARD_RAD;
        let others_rad = yaw_rad.unwrap_or(wanted_rad) + outward_rad;
        let yaw_rad = heading_with_room(&shape.polygon, &area, margin_m, wanted_rad, others_rad)?;
        Some(Self {
            yaw_rad: Some(yaw_rad),
            ..self
        })
    }

    /// Kept exactly where it is, if that is the place of a foot at the goal and its sole is inside the face there.
    pub fn at_goal(self, context: &SearchContext) -> Self {
        let wanted = context.stand_at_goal(self.patch);
        let at_end = self.along_m >= context.end_m();
        let Some(wanted) = wanted.filter(|_| at_end && self.variation == 0) else {
            return self;
        };
        if !is_at(wanted, &self.place.coords, self.yaw_rad) {
            return self;
        }
        let exact = self.fixed(context, wanted.1).map(Box::new);
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
        let inside = |p: &Point2<f64>| {
            let p = to_F * Point3::new(p.x, p.y, 0.0);
            area.polygon.signed_distance(&p.xy()) <= -context.patch_margin_m
        };
        let contact = Contact::at(request.robot, self.patch, shape.touching(&at));
        let contact = contact.on(self.face, request.environment).loaded(false);
        (shape.point_radius_m().is_some() || shape.polygon.iter().all(inside)).then_some(contact)
    }

    /// The part of its face about the place, long along the way where it can be.
    fn area(&self, context: &SearchContext) -> Option<Area> {
        let X_WF = context.request.environment[self.face].X_WF;
        let heading = context.route.at(self.along_m).heading;
        let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
        let p_F = X_WF.inverse_transform_point(&self.place).xy();
        let along_F = X_WF.inverse_transform_vector(&ahead).xy();
        Some(Area {
            X_WF,
            polygon: context
                .landing(self.patch, self.face)?
                .area(&p_F, &along_F)?,
            toward: Some(self.place),
            yaw_rad: self.yaw_rad,
        })
    }

    /// What it costs not to be at the place that is wanted most, in contacts.
    pub fn price(&self) -> f64 {
        VARIATION_PRICE * self.variation as f64 + MOVED_PRICE * self.moved_m
    }

    /// The number of the variation after this one.
    pub fn next(&self) -> usize {
        self.variation + 1
    }
}
