//! Shortening: contacts and steps that the way can do without are taken out of it.
//!
//! A contact that was made at one stance and released at a later one is left out if every posture
//! between exists without it; a foot that was put elsewhere at one and leaves again at a later one stays
//! where it was, if every posture between exists with it there. The postures are solved again with all
//! places fixed, so the rest of the way stays as it is.

use std::sync::Arc;

use posture::{Contact, FaceIndex, Outcome};
use robot_model::PatchId;

use crate::Error;
use crate::context::SearchContext;
use crate::footing::Footing;
use crate::node::Node;
use crate::node_construction::rolled_off;
use crate::nominal_posture::nominal_posture;
use plan::Change;

/// Strides by which a foot that stays is behind another one at most: legs hardly reach farther.
const BEHIND_STRIDES: f64 = 1.5;

/// The way without the contacts and steps that it can do without, and how many problems were solved for it;
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
        match Dropped::at(context, &way, made) {
            Some(dropped) => {
                let (shorter, tried) = dropped.without(context, config, &way)?;
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

/// What may be left out of a way.
struct Dropped {
    patch: PatchId,
    /// The first stance that is left out, and the next one that is not.
    first: usize,
    next: usize,
    /// The stance that releases the patch.
    released: usize,
    /// Where the patch stays, if it is a foot.
    stays: Option<(Contact, Footing)>,
}

impl Dropped {
    /// What stance `made` begins to hold and a later one releases: a hand, or a foot at another place than before.
    fn at(context: &SearchContext, way: &[Node], made: usize) -> Option<Self> {
        let Change::Add { patch, .. } = &way[made].change else {
            return None;
        };
        let patch = context.request.robot.patch_id(patch).ok()?;
        let released = (made + 1..way.len()).find(|&i| !way[i].holds(patch))?;
        if context.foot(patch).is_none() {
            return Some(Self {
                patch,
                first: made,
                next: made + 1,
                released,
                stays: None,
            });
        }
        let before = &way[made.checked_sub(2)?];
        let stays = before.contacts.iter().find(|c| c.patch == patch)?;
        let footing = before.footing[patch.index()]?;
        // Only what the other feet do not leave far behind.
        let behind_m = |node: &Node| {
            let feet = node.feet(context).into_iter();
            feet.map(|f| (f.along_m - footing.along_m).abs())
                .fold(0.0, f64::max)
        };
        let far_m = BEHIND_STRIDES * context.stride_m;
        let mut between = way[made..=released].iter();
        between.all(|node| behind_m(node) <= far_m).then(|| Self {
            patch,
            first: made - 1,
            next: made + 1,
            released,
            stays: Some((stays.clone(), footing)),
        })
    }

    /// The way without it, if every posture between exists.
    fn without(
        &self,
        context: &SearchContext,
        config: &posture::Config,
        way: &[Node],
    ) -> Result<(Option<Vec<Node>>, usize), Error> {
        // A contact that is left out is not released either.
        let end = self.released + usize::from(self.stays.is_some());
        let mut shorter: Vec<Node> = way[..self.first].to_vec();
        for (tried, node) in way[self.next..end].iter().enumerate() {
            let next = self.moved(context, node);
            let Some(last) = shorter
                .last()
                .filter(|_| next.touching.iter().any(|c| c.loaded))
            else {
                return Ok((None, tried));
            };
            let reference = nominal_posture(context, &next.touching, next.along_m(context));
            let problem = context.problem(next.touching.clone(), &reference, &last.posture.q);
            let mut config = config.clone();
            config.solver.upright = Some(context.upright(&reference));
            let Outcome::Feasible(posture) = posture::solve(&problem, &config)? else {
                return Ok((None, tried + 1));
            };
            if rolled_off(context, &next.touching, &posture).is_some() {
                return Ok((None, tried + 1));
            }
            shorter.push(Node {
                posture: Arc::new(*posture),
                ..next
            });
        }
        let tried = shorter.len() - self.first;
        shorter.extend_from_slice(&way[self.released + 1..]);
        Ok((Some(shorter), tried))
    }

    /// A stance with the patch nowhere, or where it stays; its posture is to be found.
    fn moved(&self, context: &SearchContext, node: &Node) -> Node {
        let mut node = node.clone();
        let Some((stays, footing)) = &self.stays else {
            node.contacts.retain(|c| c.patch != self.patch);
            node.touching.retain(|c| c.patch != self.patch);
            return node;
        };
        let own = node.contacts.iter_mut().chain(&mut node.touching);
        for contact in own.filter(|c| c.patch == self.patch) {
            *contact = stays.clone().loaded(contact.loaded);
        }
        node.footing[self.patch.index()] = Some(*footing);
        let name = |face: FaceIndex| context.request.environment[face].id.clone();
        if let Change::Remove { patch, face } = &mut node.change
            && context.request.robot.patches[self.patch].name == *patch
        {
            *face = stays.face.map(name).unwrap_or_default();
        }
        node
    }
}
