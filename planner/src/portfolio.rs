//! The search along one way of the base, and along others where that leads to no plan soon.

use std::sync::atomic::AtomicBool;

use crate::context::SearchContext;
use crate::lattice::Preference;
use crate::request::Request;
use crate::result::{Progress, SearchResult, Status};
use crate::search::Search;
use crate::tree::Tree;
use crate::way::{self, UNEVEN};
use crate::{Config, Error};

/// Nodes after which another way is tried: so many, and so many for every contact change that is estimated; or so many
/// posture problems for each of these.
const SOON: f64 = 40.0;
const SOON_A_CHANGE: f64 = 2.0;
const SOON_PROBLEMS: usize = 4;

/// Searches for a sequence of stances from the start to the goal.
///
/// `progress` is called after every solved candidate; `cancel` stops the search, which then gives
/// the way to the best contact set found so far.
///
/// # Errors
/// [`Error`] where the request makes no sense or the start is no stance.
///
/// Source: best-first planning of \[escande2013\] as used in \[brossette2013\]; deviation: candidates
/// are solved one at a time in the order of an estimate instead of all children of a node, and along other ways of
/// the base where none is found soon along the first.
pub fn search(
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<SearchResult, Error> {
    let (found, _) = grow(
        request,
        config,
        posture_config,
        motion_config,
        progress,
        cancel,
    )?;
    Ok(found.timed(request, posture_config, motion_config))
}

/// As [`search`], with no motion in time yet; with its tree, where a plan was found and it may be gone on with.
///
/// # Errors
/// As [`search`].
pub fn grow(
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<(SearchResult, Option<Tree>), Error> {
    motion_config.validate()?;
    let context = SearchContext::new(request, config, posture_config)?;
    let begun = |preference: &Preference| {
        let context = way::laid(context.clone(), preference);
        Search::begin(context, posture_config, motion_config, progress)
    };
    let mut preference = Preference {
        uneven: UNEVEN,
        stuck_W: Vec::new(),
    };
    let (mut first, mut ended) = begun(&preference)?;
    let soon = (SOON + SOON_A_CHANGE * first.nodes[0].rest(&first.context)) as usize;
    let soon = [soon, soon * SOON_PROBLEMS];
    if ended.is_none() {
        ended = first.run(soon, progress, cancel)?;
    }
    let mut searches = vec![first];
    let mut preferences = vec![preference.clone()];
    // One way does not mind uneven ground; the others keep off where those before got stuck.
    for keeps_off in [false, true, true, true, true] {
        if ended.is_some() {
            break;
        }
        preference.uneven = if keeps_off { UNEVEN } else { 0.0 };
        if keeps_off {
            preference.stuck_W = searches.iter().map(Search::stuck_W).collect();
        }
        let (mut other, its) = begun(&preference)?;
        let known = |search: &Search| other.context.route.is_along(&search.context.route);
        if its.is_some() || searches.iter().any(known) {
            continue;
        }
        other.elsewhere = spent(&searches);
        ended = other.run(soon, progress, cancel)?;
        ended = ended.filter(|ended| *ended == Status::Found);
        searches.push(other);
        preferences.push(preference.clone());
    }
    // That which has a plan, or else the one that came nearest to the goal, goes on.
    let last = searches.len() - 1;
    let rest = |&way: &usize| searches[way].rest();
    let nearest = (0..=last).min_by(|a, b| rest(a).total_cmp(&rest(b)));
    let chosen = match ended {
        Some(_) => last,
        None => nearest.unwrap_or(0),
    };
    let mut search = searches.swap_remove(chosen);
    search.elsewhere = spent(&searches);
    let ended = match ended {
        Some(ended) => ended,
        None => search
            .run([usize::MAX; 2], progress, cancel)?
            .unwrap_or(Status::Exhausted),
    };
    Ok(search.into_ended(ended, preferences.swap_remove(chosen)))
}

/// What searches spent together, each by itself.
fn spent(searches: &[Search]) -> [usize; 3] {
    let alone = searches.iter().map(|search| {
        let (spent, elsewhere) = (search.spent(), search.elsewhere);
        std::array::from_fn(|k| spent[k] - elsewhere[k])
    });
    alone.fold([0; 3], |sum, spent: [usize; 3]| {
        std::array::from_fn(|k| sum[k] + spent[k])
    })
}
