//! Links that are too near to each other or to the environment where fixed contacts put them: what the
//! rest of the robot does changes nothing of that.

use crate::constraint::Clearances;
use crate::contact::Freedom;
use crate::iterate::Context;
use crate::rows::{Rows, Tag};

/// Smallest violation that counts, m: what postures may be off their contacts by, over the length of a link,
/// is a third of it.
const CERTAIN_M: f64 = 3e-4;

pub(super) fn worst(ctx: &Context) -> Option<(Tag, f64)> {
    let mut it = ctx.start(ctx.problem.guess);
    let mut is_put = vec![false; ctx.robot().bodies.len()];
    for (contact, model) in ctx.problem.contacts.iter().zip(&ctx.contacts) {
        if contact.freedom == Freedom::Fixed && model.radius.is_none() {
            let X_BC = &ctx.robot().patches[contact.patch].X_BC;
            it.kinematics.X_WB[model.body] = contact.X_WC * X_BC.inverse();
            is_put[model.body] = true;
        }
    }
    let (mut clearances, mut rows) = (Clearances::default(), Rows::new(0));
    rows.clear(false);
    clearances.rows(ctx, &it, &mut rows);
    let shape_is_put = |shape: usize| is_put[ctx.robot().collision.shapes()[shape].body];
    let settled = (0..rows.len()).filter(|&i| match rows.tag[i] {
        Tag::SelfClearance(a, b) => shape_is_put(a) && shape_is_put(b),
        Tag::Clearance(a, _) => shape_is_put(a),
        _ => false,
    });
    let worst = settled.max_by(|&i, &j| rows.violation(i).total_cmp(&rows.violation(j)))?;
    let amount = rows.violation(worst);
    (amount > CERTAIN_M).then_some((rows.tag[worst], amount))
}
