//! Shortening: contacts that the way can do without are taken out of it.
//!
//! A contact that was made at one stance and released at a later one is left out if every posture
//! between still exists without it. The postures are solved again with all places fixed, so the
//! rest of the way stays as it is.

use std::sync::Arc;

use posture::{Contact, Outcome};

use crate::Error;
use crate::context::SearchContext;
use crate::node::Node;
use crate::nominal_posture::nominal_posture;
use plan::Change;

/// The way without the contacts that it can do without, and how many problems were solved for it;
/// a shorter way counts only if `accept` says so.
///
/// # Errors
/// [`Error::Posture`] where a problem cannot be posed.
pub(crate) fn shorten(
    context: &SearchContext,
    config: &posture::Config,
    mut way: Vec<Node>,
    accept: &mut dyn FnMut(&[Node]) -> Result<bool, Error>,
) -> Result<(Vec<Node>, usize), Error> {
    let mut solved = 0;
    let mut made = 1;
    while made < way.len() {
        match released(context, &way, made) {
            Some(released) => {
                let (shorter, tried) = without(context, config, &way, made, released)?;
                solved += tried;
                match shorter {
                    Some(shorter) if accept(&shorter)? => way = shorter,
                    _ => made += 1,
                }
            }
            None => made += 1,
        }
    }
    Ok((way, solved))
}

/// Where the contact that stance `made` makes is released again, if it is one that the start does
/// not have.
fn released(context: &SearchContext, way: &[Node], made: usize) -> Option<usize> {
    let Change::Add { patch, .. } = &way[made].change else {
        return None;
    };
    let patch = context.request.robot.patch_id(patch).ok()?;
    if context.foot(patch).is_some() {
        return None;
    }
    (made + 1..way.len()).find(|&i| !way[i].holds(patch))
}

/// The way with the contact that is made at `made` and released at `released` left out, if every
/// posture between exists without it.
fn without(
    context: &SearchContext,
    config: &posture::Config,
    way: &[Node],
    made: usize,
    released: usize,
) -> Result<(Option<Vec<Node>>, usize), Error> {
    let Some(dropped) = way[made]
        .contacts
        .iter()
        .map(|c| c.patch)
        .find(|&patch| !way[made - 1].holds(patch))
    else {
        return Ok((None, 0));
    };
    let mut shorter: Vec<Node> = way[..made].to_vec();
    for (tried, node) in way[made + 1..released].iter().enumerate() {
        let stays = |c: &&Contact| c.patch != dropped;
        let touching: Vec<Contact> = node.touching.iter().filter(stays).cloned().collect();
        let Some(last) = shorter.last().filter(|_| touching.iter().any(|c| c.loaded)) else {
            return Ok((None, tried));
        };
        let reference = nominal_posture(context, &touching, node.along_m(context));
        let problem = context.problem(touching.clone(), &reference, &last.posture.q);
        let mut config = config.clone();
        config.solver.upright = Some(context.upright(&reference));
        let Outcome::Feasible(posture) = posture::solve(&problem, &config)? else {
            return Ok((None, tried + 1));
        };
        let mut next = node.clone();
        next.contacts.retain(|c| c.patch != dropped);
        next.touching = touching;
        next.posture = Arc::new(*posture);
        shorter.push(next);
    }
    let tried = shorter.len() - made;
    shorter.extend_from_slice(&way[released + 1..]);
    Ok((Some(shorter), tried))
}
