//! Goals that no way leads to, whatever the postures: proofs by lengths and by weight.
//!
//! The robot always holds on to something, so that whoever comes from some faces to others holds
//! both at once somewhere: two limbs and what is between them span that distance. And a patch that
//! must touch at the goal is no farther from the base than its limb is long:
//!
//!   d(face, face') ≤ max d(C_a, C_b),   d(face, goal) ≤ r_a + tolerance
//!
//! Where feet alone touch anything, a foot lands while the others carry the weight, and the centre of
//! mass is over what they stand on, of one foot over its sole, of several within their hull or, where
//! they are at different heights, beside it by what friction shifts:
//!
//!   d_xy(hull, face') ≤ max ‖p_C − c‖ + ½ Δz tan(slope + atan μ)
//!
//! Boxes stand for the faces, so that distances are too short and the proof is one.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, Vector3};
use posture::{Area, Contact, FaceIndex};
use robot_model::PatchId;
use surfaces::ConvexPolygon;

use crate::context::SearchContext;
use crate::result::Blocked;
use crate::sole_room::has_room;

/// A box along W's axes, m.
#[derive(Clone, Copy)]
struct Extent {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Extent {
    fn new(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let nothing = Self {
            low: Vector3::repeat(f64::INFINITY),
            high: Vector3::repeat(f64::NEG_INFINITY),
        };
        let points = points.into_iter().map(|p| p.coords);
        points.fold(nothing, |b, p| b.with(&Self { low: p, high: p }))
    }

    /// The box about both.
    fn with(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
        }
    }

    /// What lies between it and another one along each axis, m.
    fn gap_m(&self, other: &Self) -> Vector3<f64> {
        let gap = (self.low - other.high).sup(&(other.low - self.high));
        gap.sup(&Vector3::zeros())
    }

    /// Its distance from a place, m, over the coordinates that the place has.
    fn distance_m(&self, place: &[Option<f64>; 3]) -> f64 {
        let gap =
            |k: usize| place[k].map_or(0.0, |x| (self.low[k] - x).max(x - self.high[k]).max(0.0));
        Vector3::new(gap(0), gap(1), gap(2)).norm()
    }
}

/// The faces that any patch may touch, and how far the robot comes over them.
struct Faces<'a> {
    context: &'a SearchContext<'a>,
    faces: Vec<FaceIndex>,
    extents: Vec<Extent>,
    /// Which of them the robot stands on.
    start: Vec<bool>,
    /// The longest distance of places that two patches touch, m.
    span_m: f64,
    /// How far a patch touches from its middle at most, m: the radius of a ball.
    ball_m: f64,
}

/// Why the goal is out of reach from the contacts of the start; nothing where lengths and weight alone
/// do not say.
pub(crate) fn out_of_reach(context: &SearchContext, start: &[Contact]) -> Option<Blocked> {
    let faces = Faces::new(context, start);
    let span_m = faces.span_m;
    let limbs = format!("two limbs span {span_m:.2} m");
    let by_lengths = faces.missed(&faces.come_to(), &limbs);
    // What weight says costs more, and is asked where the base has no way.
    by_lengths.or_else(|| {
        context.gap.as_ref()?;
        let (come_to, reach_m) = faces.stepped_to()?;
        let feet = format!("a foot lands within {reach_m:.2} m of what carries the weight");
        faces.missed(&come_to, &feet)
    })
}

impl<'a> Faces<'a> {
    fn new(context: &'a SearchContext<'a>, start: &[Contact]) -> Self {
        let request = context.request;
        let used = || request.robot.patch_ids().filter(|&p| context.is_used(p));
        let touched = used().flat_map(|p| request.usable[p.index()].iter().copied());
        let stood = || start.iter().filter_map(|c| c.face);
        let mut faces: Vec<FaceIndex> = touched.chain(stood()).collect();
        faces.sort_unstable();
        faces.dedup();
        let extent = |&face: &FaceIndex| {
            // A patch that stands at the start may stick out of its face.
            let on = start.iter().filter(|c| c.face == Some(face));
            let soles = on.flat_map(|c| {
                let patch = request.robot.patches[c.patch].polygon.iter();
                patch.map(|p| c.X_WC * Point3::new(p.x, p.y, 0.0))
            });
            Extent::new(
                request.environment[face]
                    .vertices_W()
                    .into_iter()
                    .chain(soles),
            )
        };
        let pairs = used().flat_map(|a| used().map(move |b| (a, b)));
        let spans = pairs.map(|(a, b)| context.reach.span_m(a, b));
        let balls = used().filter_map(|p| request.robot.patches[p].point_radius_m());
        let ball_m = balls.fold(0.0, f64::max);
        Self {
            context,
            extents: faces.iter().map(extent).collect(),
            start: faces
                .iter()
                .map(|face| stood().any(|s| s == *face))
                .collect(),
            span_m: spans.fold(0.0, f64::max) + 2.0 * ball_m,
            ball_m,
            faces,
        }
    }

    /// The faces that two limbs come to, one after the other, from the start's.
    fn come_to(&self) -> Vec<bool> {
        let mut come_to = self.start.clone();
        let mut open: Vec<usize> = (0..come_to.len()).filter(|&i| come_to[i]).collect();
        while let Some(i) = open.pop() {
            let (extent, span) = (&self.extents[i], Vector3::repeat(self.span_m));
            let (low, high) = (extent.low - span, extent.high + span);
            let environment = self.context.request.environment;
            for face in environment.faces_near(&low.into(), &high.into()) {
                let Ok(j) = self.faces.binary_search(&face) else {
                    continue;
                };
                if !come_to[j] && extent.gap_m(&self.extents[j]).norm() <= self.span_m {
                    come_to[j] = true;
                    open.push(j);
                }
            }
        }
        come_to
    }

    /// The faces that feet alone come to, and from how far from the others' support a foot lands at
    /// most, m; nothing where other patches touch faces too.
    fn stepped_to(&self) -> Option<(Vec<bool>, f64)> {
        let (context, request) = (self.context, self.context.request);
        let mut others = request.robot.patch_ids().filter(|&p| context.is_used(p));
        if others.any(|p| context.foot(p).is_none() && !request.usable[p.index()].is_empty()) {
            return None;
        }
        let feet = || context.feet.iter().copied();
        // For each face the boxes about the places where feet land, and how far from the support.
        let places: Vec<Vec<(Extent, f64)>> = self
            .faces
            .iter()
            .map(|&face| {
                let X_WF = &request.environment[face].X_WF;
                let land = |foot: PatchId| {
                    let middles = context.landing(foot, face)?.middles();
                    let points: Vec<Point3<f64>> =
                        middles.map(|p| X_WF * Point3::new(p.x, p.y, 0.0)).collect();
                    let reach_m = context.reach.com_m(foot) + self.ball_m;
                    (!points.is_empty()).then(|| (Extent::new(points), reach_m))
                };
                feet().filter_map(land).collect()
            })
            .collect();
        let mut come_to = self.start.clone();
        loop {
            let known = || (0..come_to.len()).filter(|&i| come_to[i]);
            // One sole, or the hull of all that may stand.
            let support: Vec<Extent> = match context.feet.len() {
                0..=2 => known().map(|i| self.extents[i]).collect(),
                _ => known()
                    .map(|i| self.extents[i])
                    .reduce(|a, b| a.with(&b))
                    .into_iter()
                    .collect(),
            };
            let shift_m = if context.feet.len() > 2 {
                self.shift_m(known(), &support)
            } else {
                0.0
            };
            let lands = |j: &usize| {
                places[*j].iter().any(|(place, reach_m)| {
                    support.iter().any(|support| {
                        let gap = support.gap_m(place);
                        gap.xy().norm() <= reach_m + shift_m && gap.norm() <= self.span_m
                    })
                })
            };
            let new: Vec<usize> = (0..come_to.len())
                .filter(|j| !come_to[*j] && lands(j))
                .collect();
            if new.is_empty() {
                let reach_m = feet().map(|foot| context.reach.com_m(foot));
                return Some((come_to, reach_m.fold(0.0, f64::max) + self.ball_m + shift_m));
            }
            new.into_iter().for_each(|j| come_to[j] = true);
        }
    }

    /// How far friction on faces of different heights shifts the centre of mass beside the hull of what
    /// stands on them, m.
    fn shift_m(&self, known: impl Iterator<Item = usize>, support: &[Extent]) -> f64 {
        let (robot, environment) = (self.context.request.robot, self.context.request.environment);
        let feet = self.context.feet.iter();
        let mu = feet
            .map(|&foot| robot.patches[foot].friction)
            .fold(0.0, f64::max);
        let slope = known.map(|i| {
            environment[self.faces[i]]
                .normal_W()
                .z
                .clamp(-1.0, 1.0)
                .acos()
        });
        let steepest = slope.fold(0.0, f64::max) + mu.atan();
        let height_m = support
            .iter()
            .map(|s| s.high.z - s.low.z)
            .fold(0.0, f64::max);
        let height_m = height_m.min(self.span_m);
        match height_m > 1e-6 {
            true if steepest >= FRAC_PI_2 => f64::INFINITY,
            true => 0.5 * height_m * steepest.tan(),
            false => 0.0,
        }
    }

    /// What the goal wants that is on none of the faces that are come to, because of what `limit` says.
    fn missed(&self, come_to: &[bool], limit: &str) -> Option<Blocked> {
        let (context, goal) = (self.context, &self.context.request.goal);
        let place = &goal.base.position_m;
        let by_place = goal.patches.iter().find_map(|&patch| {
            let near_m = context.reach.base_m(patch) + self.ball_m + goal.base.tolerance_m;
            let wanted = |i: usize| self.extents[i].distance_m(place);
            self.unserved(come_to, limit, patch, near_m, &wanted)
        });
        by_place.or_else(|| {
            goal.contacts.iter().find_map(|&(patch, face)| {
                let request = context.request;
                if !request.usable[patch.index()].contains(&face) {
                    let (face, patch) = (
                        &request.environment[face].id,
                        &request.robot.patches[patch].name,
                    );
                    let reason =
                        format!("{face} is not for {patch}: its roles ask for other faces");
                    return Some(Blocked::of_goal(reason, true));
                }
                // What is held from the start is not asked for its margins.
                let is_held = request.start.contacts.contains(&(patch, face));
                if !is_held && !self.has_room(patch, face) {
                    let patch = &request.robot.patches[patch].name;
                    let face = &request.environment[face].id;
                    let margin_mm = 1e3 * context.patch_margin_m;
                    let reason = format!(
                        "{face} has no room for {patch}, whichever way it is turned, with {margin_mm:.0} mm around it"
                    );
                    return Some(Blocked::of_goal(reason, true));
                }
                let wanted = |i: usize| {
                    if self.faces[i] == face {
                        0.0
                    } else {
                        f64::INFINITY
                    }
                };
                self.unserved(come_to, limit, patch, 0.0, &wanted)
            })
        })
    }

    /// Whether a patch fits into the hull of a face; a ball always does.
    fn has_room(&self, patch: PatchId, face: FaceIndex) -> bool {
        let request = self.context.request;
        let (shape, face) = (&request.robot.patches[patch], &request.environment[face]);
        let corners_W = face.vertices_W().into_iter();
        let corners = corners_W.map(|p| face.X_WF.inverse_transform_point(&p).xy());
        let hull = ConvexPolygon::hull(&corners.collect::<Vec<_>>());
        let Some(polygon) = hull.ok().filter(|_| shape.point_radius_m().is_none()) else {
            return true;
        };
        let hull = Area {
            X_WF: face.X_WF,
            polygon,
            toward: None,
            yaw_rad: None,
        };
        has_room(&shape.polygon, &hull, self.context.patch_margin_m)
    }

    /// Why a patch comes to no face that is within `near_m` of what is wanted.
    fn unserved(
        &self,
        come_to: &[bool],
        limit: &str,
        patch: PatchId,
        near_m: f64,
        wanted: &dyn Fn(usize) -> f64,
    ) -> Option<Blocked> {
        let request = self.context.request;
        let all = || 0..self.faces.len();
        let name = |i: usize| &request.environment[self.faces[i]].id;
        let usable = |i: &usize| self.context.may_touch(patch, self.faces[*i]);
        let serve = |i: &usize| usable(i) && wanted(*i) <= near_m;
        if all().any(|i| come_to[i] && serve(&i)) {
            return None;
        }
        // Of the faces that would serve and those that are come to, the nearest two.
        let gap_m = |i: usize, j: usize| self.extents[i].gap_m(&self.extents[j]).norm();
        let from = |j: usize| {
            let from = all().filter(|i| come_to[*i]);
            from.min_by(|a, b| gap_m(*a, j).total_cmp(&gap_m(*b, j)))
                .map(|i| (i, j))
        };
        let pairs = all().filter(serve).filter_map(from);
        let nearest = pairs.min_by(|a, b| gap_m(a.0, a.1).total_cmp(&gap_m(b.0, b.1)));
        let reason = if let Some((i, j)) = nearest {
            format!(
                "{} is {:.2} m from {}, the nearest face that can be come to, and {limit}",
                name(j),
                gap_m(i, j),
                name(i)
            )
        } else {
            let nearest = all()
                .filter(usable)
                .min_by(|i, j| wanted(*i).total_cmp(&wanted(*j)));
            let far = nearest.map_or_else(
                || "there is none".to_owned(),
                |i| format!("the nearest, {}, is {:.2} m from it", name(i), wanted(i)),
            );
            let words = &request.robot.patches[patch].name;
            format!("no face is within {near_m:.2} m of the goal for {words}: {far}")
        };
        Some(Blocked::of_goal(reason, true))
    }
}
