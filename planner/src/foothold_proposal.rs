//! Where a patch should touch a face.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use posture::{Area, Contact, FaceIndex, Freedom};
use robot_model::PatchId;
use surfaces::ConvexPolygon;

use crate::context::{FootState, SearchContext, hindmost};
use crate::node::{Node, SAME_PLACE_M};

/// A place where a patch should touch a face, and how far it may be moved from there.
#[derive(Clone, Debug)]
pub(crate) struct Foothold {
    pub patch: PatchId,
    pub face: FaceIndex,
    /// The point of the face, in W.
    pub place: Point3<f64>,
    /// Heading of a foot.
    pub yaw_rad: Option<f64>,
    /// Progress along the guide path that was aimed at, m.
    pub along_m: f64,
    /// The convex part of the face about the place in which the patch may be, in the face's frame.
    area: ConvexPolygon,
}

impl Foothold {
    /// The contact that is asked for, not loaded yet.
    pub fn contact(&self, context: &SearchContext) -> Contact {
        let request = context.request;
        let X_WF = request.environment[self.face].X_WF;
        let at = Isometry3::from_parts(self.place.into(), X_WF.rotation);
        let at = request.robot.patches[self.patch].touching(&at);
        let area = Area {
            X_WF,
            polygon: self.area.clone(),
            toward: Some(self.place),
            yaw_rad: self.yaw_rad,
        };
        Contact {
            freedom: Freedom::Within(Box::new(area)),
            ..Contact::at(request.robot, self.patch, at)
                .on(self.face)
                .loaded(false)
        }
    }
}

/// The place on a face that a patch would like best, if it is within reach at all: a stride ahead of
/// the hindmost of the other feet (for a hand, of the foremost that stands), along the guide path,
/// at the patch's usual offset, moved onto the face.
pub(crate) fn propose(
    context: &SearchContext,
    node: &Node,
    feet: &[FootState],
    patch: PatchId,
    face: FaceIndex,
) -> Option<Foothold> {
    let request = context.request;
    let guide = &request.guide;
    let support = match context.foot(patch) {
        Some(foot) => hindmost(feet, foot),
        None => feet
            .iter()
            .filter(|f| !f.in_air)
            .map(|f| f.along_m)
            .max_by(f64::total_cmp)
            .unwrap_or(f64::NEG_INFINITY),
    };
    let (_, heading) = guide.at(support);
    let normal = request.environment[face].normal_W();
    let stride_m = context.stride_on(patch, &normal, heading);
    let along_m = (support + stride_m).min(guide.length_m());
    let wanted = guide.foot_at(along_m, context.offset(patch)).into();
    let foothold = onto(context, patch, face, &wanted, along_m)?;
    within_reach(context, node, &foothold).then_some(foothold)
}

/// Whether a contact could be within reach of every one that stays: two limbs and what is between
/// them.
fn within_reach(context: &SearchContext, node: &Node, foothold: &Foothold) -> bool {
    let request = context.request;
    let X_WF = &request.environment[foothold.face].X_WF;
    // A ball's centre is over the place that it touches.
    let over = request.robot.patches[foothold.patch].touching(&Isometry3::identity());
    let centre = foothold.place + X_WF.rotation * over.translation.vector;
    let X_over = X_WF * over;
    node.contacts.iter().all(|held| {
        let reach = context.reach_m(foothold.patch) + context.reach_m(held.patch);
        let p = Point3::from(held.X_WC.translation.vector);
        let p_F = X_over.inverse_transform_point(&p);
        let beside = foothold.area.signed_distance(&p_F.xy()).max(0.0);
        (centre - p).norm() <= reach || beside.hypot(p_F.z) <= reach
    })
}

/// Places on the face about one where the patch does touch, [`SAME_PLACE_M`] away from it along the
/// path and across: for where no motion leads to that one.
pub(crate) fn alternatives(context: &SearchContext, held: &Contact) -> Vec<Foothold> {
    let Some(face) = held.face else {
        return Vec::new();
    };
    let place = context.place_W(held);
    let (along_m, _) = context.progress(held.patch, &place);
    let heading = context.request.guide.at(along_m).1;
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
    [-Vector3::x(), -Vector3::y(), Vector3::y(), Vector3::x()]
        .iter()
        .filter_map(|way| {
            let wanted = Point3::from(place + turn * way * SAME_PLACE_M);
            let beside = onto(context, held.patch, face, &wanted, along_m)?;
            let moved = (beside.place.coords - place).norm() > 0.5 * SAME_PLACE_M;
            moved.then_some(beside)
        })
        .collect()
}

/// The nearest place on a face to a point, the patch's middle at least its half width from the
/// edge; none on a face that is smaller. A foot looks along the path; how a hand lies does not
/// matter.
fn onto(
    context: &SearchContext,
    patch: PatchId,
    face: FaceIndex,
    wanted: &Point3<f64>,
    along_m: f64,
) -> Option<Foothold> {
    let request = context.request;
    let environment = request.environment;
    let p_F = environment[face].X_WF.inverse_transform_point(wanted).xy();
    let places = context.room(patch, face).iter().map(|r| r.nearest(&p_F));
    let nearest = places.min_by(|a, b| (a - p_F).norm().total_cmp(&(b - p_F).norm()))?;
    let place = environment[face].point_W(&nearest);
    let heading = request.guide.at(along_m).1;
    let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
    Some(Foothold {
        patch,
        face,
        place,
        yaw_rad: context.foot(patch).map(|_| heading),
        along_m,
        area: environment.area_around(face, &place, &ahead)?,
    })
}
