//! How many contact changes lie between contact sets and the goal: as the search estimates them, and
//! at least.

use posture::Contact;

use crate::context::SearchContext;
use crate::footing::{Footing, hindmost};

/// Estimated number of contact changes to the goal, given each foot's last place and whether
/// it is in the air, and how many contacts of other limbs that are wanted are still to be made.
///
/// A foot in the air lands a stride ahead of the hindmost of the others. Of two feet each then
/// passes the other, and one on the ground must leave and land once for every two strides that
/// it is behind; more feet catch up with each other, once for every stride.
pub(crate) fn estimate(context: &SearchContext, feet: &[Footing], missing: usize) -> f64 {
    let end = context.end_m();
    let stride = context.stride_m;
    let advance = if feet.len() > 2 { stride } else { 2.0 * stride };
    let changes = feet.iter().enumerate().map(|(i, foot)| {
        let (along, landing) = if foot.in_air {
            (foot.along_m.max(hindmost(feet, i) + stride), 1.0)
        } else {
            (foot.along_m, 0.0)
        };
        let behind = (end - along).max(0.0);
        // One that stands elsewhere than it has to steps at least once.
        let again = if foot.astray && !foot.in_air {
            2.0
        } else {
            0.0
        };
        landing
            + (2.0 * behind / advance).max(again)
            + context.config.lateral_deviation_price_per_m * foot.lateral_m
    });
    changes.sum::<f64>() + missing as f64
}

/// A number of contact changes that no way from the start to the goal falls short of, by lengths
/// alone.
///
/// A contact is made within a span D of one that is held, so that k of them come at most k D nearer to
/// the goal's place; every foot that must touch there and does not yet leaves where it stands and
/// lands once, the first of them as number ⌈d / D⌉ of all contacts that are made.
pub(crate) fn at_least(context: &SearchContext, start: &[Contact]) -> usize {
    let (goal, robot) = (&context.request.goal, context.request.robot);
    let apart_m = |contact: &Contact| {
        let wanted = goal.base.position_m.iter();
        let pairs = wanted.zip(contact.X_WC.translation.vector.iter());
        let apart: f64 = pairs.filter_map(|(g, x)| g.map(|g| (g - x).powi(2))).sum();
        apart.sqrt() - goal.base.tolerance_m
    };
    let reach_m = |contact: &Contact| context.reach.base_m(contact.patch);
    let must = |contact: &&Contact| goal.patches.contains(&contact.patch);
    let away = |contact: &&Contact| apart_m(contact) > reach_m(contact);
    let leave = start.iter().filter(must).filter(away).count();
    if leave == 0 {
        return 0;
    }
    let serves = |patch: &robot_model::PatchId| {
        context.is_used(*patch) && !context.request.usable[patch.index()].is_empty()
    };
    let patches: Vec<_> = robot.patch_ids().filter(serves).collect();
    let pairs = patches
        .iter()
        .flat_map(|&a| patches.iter().map(move |&b| (a, b)));
    let span_m = pairs.map(|(a, b)| context.reach.span_m(a, b));
    let span_m = span_m.fold(1e-6, f64::max);
    let near_m = start.iter().filter(must).map(reach_m).fold(0.0, f64::max);
    let nearest_m = start.iter().map(apart_m).fold(f64::INFINITY, f64::min);
    let first = ((nearest_m - near_m) / span_m).ceil().max(1.0) as usize;
    let made = first + leave - 1;
    // With feet alone, all of which stand, each is lifted before it lands.
    let only_feet = patches.iter().all(|&p| start.iter().any(|c| c.patch == p));
    made + if only_feet { made } else { leave }
}
