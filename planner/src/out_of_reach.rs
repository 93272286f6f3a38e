//! Goals that no way leads to, whatever the postures: a proof by lengths alone.
//!
//! The robot always holds on to something, so that whoever comes from some faces to others holds
//! both at once somewhere: two limbs and what is between them span that distance. And a patch that
//! must touch at the goal is no farther from the base than its limb is long:
//!
//!   d(face, face') ≤ r_a + r_b,   d(face, goal) ≤ r_a + tolerance
//!
//! Boxes stand for the faces, so that distances are too short and the proof is one.
#![allow(non_snake_case)]

use nalgebra::Vector3;
use plan::Change;
use posture::FaceIndex;
use robot_model::PatchId;

use crate::context::SearchContext;
use crate::result::Blocked;

/// The box about a face in W, m.
struct Extent {
    face: FaceIndex,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Extent {
    fn new(context: &SearchContext, face: FaceIndex) -> Self {
        let corners = context.request.environment[face].vertices_W();
        let (mut low, mut high) = (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(-f64::INFINITY),
        );
        for p in &corners {
            (low, high) = (low.inf(&p.coords), high.sup(&p.coords));
        }
        Self { face, low, high }
    }

    /// Its distance from another box, m.
    fn apart_m(&self, other: &Self) -> f64 {
        let gap = (self.low - other.high).sup(&(other.low - self.high));
        gap.map(|x| x.max(0.0)).norm()
    }

    /// Its distance from a place, m, over the coordinates that the place has.
    fn distance_m(&self, place: &[Option<f64>; 3]) -> f64 {
        let gap =
            |k: usize| place[k].map_or(0.0, |x| (self.low[k] - x).max(x - self.high[k]).max(0.0));
        Vector3::new(gap(0), gap(1), gap(2)).norm()
    }
}

/// Why the goal is out of reach; nothing where lengths alone do not say.
pub(crate) fn out_of_reach(context: &SearchContext) -> Option<Blocked> {
    let request = context.request;
    let used = || request.robot.patch_ids().filter(|&p| context.is_used(p));
    let start = request.start.contacts.iter().map(|c| c.1);
    let touched = used().flat_map(|p| request.usable[p.index()].iter().copied());
    let mut faces: Vec<FaceIndex> = touched.chain(start.clone()).collect();
    faces.sort_unstable();
    faces.dedup();
    let extents: Vec<Extent> = faces.iter().map(|&f| Extent::new(context, f)).collect();
    // Two limbs at most; a robot of one limb has its own length.
    let mut reaches: Vec<f64> = used().map(|p| context.reach_m(p)).collect();
    reaches.sort_by(|a, b| b.total_cmp(a));
    let span_m: f64 = reaches.iter().take(2).sum();

    // Every face that can be come to from the start's.
    let is_start = |i: &usize| start.clone().any(|face| face == faces[*i]);
    let (mut open, mut rest): (Vec<usize>, Vec<usize>) = (0..faces.len()).partition(is_start);
    let mut come_to: Vec<bool> = vec![false; extents.len()];
    while let Some(i) = open.pop() {
        come_to[i] = true;
        let is_near = |j: &usize| extents[i].apart_m(&extents[*j]) <= span_m;
        let (near, far) = rest.into_iter().partition(is_near);
        open.extend::<Vec<usize>>(near);
        rest = far;
    }

    let goal = &request.goal;
    let name = |i: usize| &request.environment[extents[i].face].id;
    let blocked = |patch: PatchId, near_m: f64, wanted: &dyn Fn(usize) -> f64| {
        let usable = |i: &usize| context.may_touch(patch, extents[*i].face);
        let serve = |i: &usize| usable(i) && wanted(*i) <= near_m;
        if (0..extents.len()).any(|i| come_to[i] && serve(&i)) {
            return None;
        }
        let words = &request.robot.patches[patch].name;
        let nearest = |i: &usize, j: &usize| wanted(*i).total_cmp(&wanted(*j));
        let reason = if let Some(there) = (0..extents.len()).find(serve) {
            let from = (0..extents.len()).filter(|i| come_to[*i]);
            let gap = |i: &usize| extents[*i].apart_m(&extents[there]);
            let from = from.min_by(|i, j| gap(i).total_cmp(&gap(j)))?;
            format!(
                "{} is {:.2} m from {}, the nearest face that can be come to, and two limbs span {span_m:.2} m",
                name(there),
                gap(&from),
                name(from)
            )
        } else {
            let nearest = (0..extents.len()).filter(usable).min_by(nearest);
            let far = nearest.map_or_else(
                || "there is none".to_owned(),
                |i| format!("the nearest, {}, is {:.2} m from it", name(i), wanted(i)),
            );
            format!("no face is within {near_m:.2} m of the goal for {words}: {far}")
        };
        Some(Blocked {
            change: Change::Goal,
            held: String::new(),
            reason,
            amount: None,
            distance_m: 0.0,
            proof: true,
        })
    };
    let place = &goal.base.position_m;
    let by_place = goal.patches.iter().find_map(|&patch| {
        let near_m = context.reach_m(patch) + goal.base.tolerance_m;
        blocked(patch, near_m, &|i| extents[i].distance_m(place))
    });
    by_place.or_else(|| {
        goal.contacts.iter().find_map(|&(patch, face)| {
            let other = |i: usize| {
                if extents[i].face == face {
                    0.0
                } else {
                    f64::INFINITY
                }
            };
            blocked(patch, 0.0, &other)
        })
    })
}
