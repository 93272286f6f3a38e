//! The search along one way of the base, and along another one where that leads to no plan soon.

use std::sync::atomic::AtomicBool;

use crate::context::SearchContext;
use crate::estimate::estimate;
use crate::request::Request;
use crate::result::{Progress, SearchResult, Status};
use crate::search::Search;
use crate::way::{self, UNEVEN};
use crate::{Config, Error};

/// Nodes after which another way is tried: so many, and so many for every contact change that is estimated.
const SOON: f64 = 40.0;
const SOON_A_CHANGE: f64 = 2.0;

/// Searches for a sequence of stances from the start to the goal.
///
/// `progress` is called after every solved candidate; `cancel` stops the search, which then gives
/// the way to the best contact set found so far.
///
/// # Errors
/// [`Error`] where the request makes no sense or the start is no stance.
///
/// Source: best-first planning of \[escande2013\] as used in \[brossette2013\]; deviation: candidates
/// are solved one at a time in the order of an estimate instead of all children of a node, and along another way of
/// the base where none is found soon along the first.
pub fn search(
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<SearchResult, Error> {
    motion_config.validate()?;
    let begun = |uneven: f64| {
        let context = SearchContext::new(request, config, posture_config)?;
        let context = way::laid(context, uneven);
        Search::begin(context, posture_config, motion_config, progress)
    };
    let (mut search, mut ended) = begun(UNEVEN)?;
    let mut elsewhere = [0; 3];
    if ended.is_none() {
        let feet = search.nodes[0].feet(&search.context);
        let soon = SOON + SOON_A_CHANGE * estimate(&search.context, &feet);
        ended = search.run(soon as usize, progress, cancel)?;
        if ended.is_none() {
            let (mut other, mut its) = begun(0.0)?;
            if other.context.route.poses() != search.context.route.poses() && its.is_none() {
                other.spends(search.spent());
                its = other.run(soon as usize, progress, cancel)?;
                if its == Some(Status::Found) {
                    (search, other, ended) = (other, search, its);
                }
                elsewhere = other.spent();
                search.spends(elsewhere);
            }
        }
    }
    let ended = match ended {
        Some(ended) => ended,
        None => search
            .run(usize::MAX, progress, cancel)?
            .unwrap_or(Status::Exhausted),
    };
    let mut result = search.ended(ended);
    let [nodes, expanded, solved] = elsewhere;
    result.summary.nodes_generated += nodes;
    result.summary.nodes_expanded += expanded;
    result.summary.candidates_solved += solved;
    Ok(result)
}
