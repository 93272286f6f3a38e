//! Where a patch should touch a face: first the place a stride ahead, then others, one at a time.

use nalgebra::{Isometry3, Point2, Point3, Rotation2, Rotation3, Vector2, Vector3};
use posture::FaceIndex;
use robot_model::PatchId;

use crate::context::SearchContext;
use crate::foothold::Foothold;
use crate::footing::{Footing, hindmost};
use crate::node::Node;
use crate::route::wrap;

/// How a place differs from the one that is wanted most.
struct Variation {
    /// Part of a stride ahead of the others.
    stride: f64,
    /// Further shift along the heading and to the left, in places that count as the same.
    shift: [f64; 2],
    /// Further turn to the left, rad; of soles.
    turn: f64,
}

const fn vary(stride: f64, shift: [f64; 2], turn: f64) -> Variation {
    Variation {
        stride,
        shift,
        turn,
    }
}

/// The order in which places on a face are tried.
const VARIATIONS: [Variation; 12] = [
    vary(1.0, [0.0, 0.0], 0.0),
    vary(1.0, [-1.0, 0.0], 0.0),
    vary(1.0, [0.0, -1.0], 0.0),
    vary(1.0, [0.0, 1.0], 0.0),
    vary(1.0, [1.0, 0.0], 0.0),
    vary(0.5, [0.0, 0.0], 0.0),
    vary(1.0, [0.0, 0.0], 0.3),
    vary(1.0, [0.0, 0.0], -0.3),
    vary(0.0, [0.0, 0.0], 0.0),
    vary(1.4, [0.0, 0.0], 0.0),
    vary(0.5, [0.0, -2.0], 0.0),
    vary(0.5, [0.0, 2.0], 0.0),
];
/// Soles at one place whose headings differ by less are the same, rad.
const SAME_RAD: f64 = 0.1;
/// Price of a metre by which a foot lands across from where it would stand beside another, in contacts: legs
/// that cross are rarely brought past each other.
pub(crate) const CROSSED_PRICE: f64 = 10.0;

/// How far a foot comes nearer to one that stands than half of its usual distance beside it, or past it to
/// its other side, m: where it lands, and where it passes on the straight way from where it stood. Of feet
/// that are side by side.
pub(crate) fn crossed_m(context: &SearchContext, node: &Node, foothold: &Foothold) -> f64 {
    if context.foot(foothold.patch).is_none() {
        return 0.0;
    }
    let heading = context.route.at(foothold.along_m).heading;
    let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
    let left = Vector3::new(-heading.sin(), heading.cos(), 0.0);
    let to = foothold.place.coords;
    let stood = node.touching.iter().find(|c| c.patch == foothold.patch);
    let from = stood.map_or(to, |c| context.place_W(c));
    let held = node.contacts.iter();
    let held =
        held.filter(|held| held.patch != foothold.patch && context.foot(held.patch).is_some());
    let crossed = held.filter_map(|held| {
        let usual = context.offset(foothold.patch) - context.offset(held.patch);
        let stands = context.place_W(held);
        // Where the way is beside the foot that stands.
        let (behind, before) = (ahead.dot(&(stands - from)), ahead.dot(&(to - stands)));
        let part = behind / (behind + before);
        let passes = if behind > 0.0 && before > 0.0 {
            from + (to - from) * part
        } else {
            to
        };
        let crossed =
            |p: Vector3<f64>| 0.5 * usual.y.abs() - left.dot(&(p - stands)) * usual.y.signum();
        let are_beside = usual.y.abs() > usual.x.abs();
        are_beside.then(|| crossed(to).max(crossed(passes)))
    });
    crossed.fold(0.0, f64::max)
}

/// The first place on a face, from variation number `from` on, that is within reach, clear of the
/// feet that stand and none of those before it: a stride ahead of the hindmost of the other feet
/// (for a hand, of the foremost that stands), at the patch's usual offset, moved onto the face.
pub(crate) fn propose(
    context: &SearchContext,
    node: &Node,
    feet: &[Footing],
    patch: PatchId,
    face: FaceIndex,
    from: usize,
) -> Option<Foothold> {
    let landing = context.landing(patch, face)?;
    let X_WF = context.request.environment[face].X_WF;
    let moved_onto = |variation| {
        let foothold = place(context, node, feet, patch, face, variation)?;
        let p_F = X_WF.inverse_transform_point(&foothold.place).xy();
        let place = context.request.environment[face].point_W(&landing.nearest(&p_F)?);
        let ahead = context.route.direction(foothold.along_m);
        let moved = place - foothold.place;
        Some(Foothold {
            place,
            moved_m: ahead.xy().perp(&moved.xy()).abs(),
            ..foothold
        })
    };
    // The room on the face is asked for last: it takes longest.
    let turned_alike = |a: &Foothold, b: &Foothold| match (a.yaw_rad, b.yaw_rad) {
        (Some(a), Some(b)) => wrap(a - b).abs() < SAME_RAD,
        _ => true,
    };
    let is_before = |foothold: &Foothold| {
        let mut places = (0..foothold.variation).filter_map(moved_onto);
        places.any(|other| {
            (other.place - foothold.place).norm() < 0.5 * context.same_place_m()
                && (other.with_room(context, node)).is_some_and(|o| turned_alike(&o, foothold))
        })
    };
    let placed = (from..VARIATIONS.len()).filter_map(moved_onto);
    let near = placed.filter(|foothold| within_reach(context, node, foothold));
    let mut fits = near
        .filter_map(|foothold| foothold.with_room(context, node))
        .filter(|foothold| steps_clear(context, node, foothold) && !is_before(foothold));
    Some(fits.next()?.at_goal(context))
}

/// A wanted place over a face, not yet moved onto it.
fn place(
    context: &SearchContext,
    node: &Node,
    feet: &[Footing],
    patch: PatchId,
    face: FaceIndex,
    variation: usize,
) -> Option<Foothold> {
    let route = &context.route;
    let vary = &VARIATIONS[variation];
    let foot = context.foot(patch);
    if foot.is_none() && variation > 4 {
        return None;
    }
    let support = match foot {
        Some(foot) => hindmost(feet, foot),
        None => feet
            .iter()
            .filter(|f| !f.in_air)
            .map(|f| f.along_m)
            .max_by(f64::total_cmp)
            .unwrap_or(f64::NEG_INFINITY),
    };
    let normal = context.request.environment[face].normal_W();
    let stride_m = vary.stride * context.stride_on(patch, &normal, support);
    let mut along_m = (support + stride_m).min(route.length_m());
    let wanted = |along_m: f64| {
        let heading = route.at(along_m).heading;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
        let shift = Vector3::new(vary.shift[0], vary.shift[1], 0.0);
        let shift = turn * shift * context.same_place_m();
        let at_goal = context.stand_at_goal(patch);
        let at_goal = at_goal.filter(|_| foot.is_some() && along_m >= context.end_m());
        let usual = || (route.foot_at(along_m, context.offset(patch)), heading);
        let (place, heading) = at_goal.unwrap_or_else(usual);
        Foothold {
            patch,
            face,
            place: (place + shift).into(),
            yaw_rad: foot.map(|_| heading + vary.turn),
            along_m,
            moved_m: 0.0,
            variation,
            exact: None,
        }
    };
    // As far ahead as it goes without standing on another foot.
    while foot.is_some() && along_m > support && !steps_clear(context, node, &wanted(along_m)) {
        along_m = (along_m - BACK_M).max(support);
    }
    Some(wanted(along_m))
}

/// Steps in which a place is taken back to where no other foot stands, m.
const BACK_M: f64 = 0.04;
/// Feet farther apart in height than this do not meet, m.
const LEVEL_M: f64 = 0.1;

/// Whether a foot lands clear of those that stand, by what two parts of the robot keep.
fn steps_clear(context: &SearchContext, node: &Node, foothold: &Foothold) -> bool {
    let robot = context.request.robot;
    let shape = &robot.patches[foothold.patch];
    if context.foot(foothold.patch).is_none() || shape.point_radius_m().is_some() {
        return true;
    }
    let turn = Rotation2::new(foothold.yaw_rad.unwrap_or(0.0));
    let lands: Vec<Point2<f64>> = shape
        .polygon
        .iter()
        .map(|p| foothold.place.xy() + turn * p.coords)
        .collect();
    node.contacts.iter().all(|held| {
        let other = &robot.patches[held.patch];
        if context.foot(held.patch).is_none() || other.point_radius_m().is_some() {
            return true;
        }
        let stands: Vec<Point3<f64>> = other
            .polygon
            .iter()
            .map(|p| held.X_WC * Point3::new(p.x, p.y, 0.0))
            .collect();
        (held.X_WC.translation.vector.z - foothold.place.z).abs() > LEVEL_M
            || apart_m(&lands, &stands.iter().map(Point3::xy).collect::<Vec<_>>())
                > context.self_clearance_m
    })
}

/// A distance that two convex polygons are apart at least, m; negative where they overlap.
fn apart_m(a: &[Point2<f64>], b: &[Point2<f64>]) -> f64 {
    let beyond = |a: &[Point2<f64>], b: &[Point2<f64>]| {
        let edges = a.iter().zip(a.iter().cycle().skip(1));
        let apart = edges.filter_map(|(p, q)| {
            let edge = (q - p).try_normalize(1e-12)?;
            let out = Vector2::new(edge.y, -edge.x);
            let nearest = b.iter().map(|v| out.dot(&(v - p)));
            nearest.min_by(f64::total_cmp)
        });
        apart.fold(f64::NEG_INFINITY, f64::max)
    };
    beyond(a, b).max(beyond(b, a))
}

/// Whether a contact could be within reach of every one that stays: two limbs and what is between
/// them.
fn within_reach(context: &SearchContext, node: &Node, foothold: &Foothold) -> bool {
    let request = context.request;
    let X_WF = &request.environment[foothold.face].X_WF;
    // A ball's centre is over the place that it touches.
    let over = request.robot.patches[foothold.patch].touching(&Isometry3::identity());
    let centre = foothold.place + X_WF.rotation * over.translation.vector;
    node.contacts.iter().all(|held| {
        let apart = centre.coords - held.X_WC.translation.vector;
        apart.norm() <= context.reach.span_m(foothold.patch, held.patch)
    })
}
