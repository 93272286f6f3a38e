//! A search that goes on among more bodies than it began with: what of its tree keeps off them stays.

use std::sync::atomic::AtomicBool;

use motion::{MotionContext, keeps_off};

use crate::context::SearchContext;
use crate::goal::{Attempt, try_goal};
use crate::lattice::Preference;
use crate::request::Request;
use crate::result::{PathStance, Progress, SearchResult, Status};
use crate::search::{Search, Told};
use crate::tree::Tree;
use crate::{Config, Error, portfolio, way};

/// Goes on with a search for a request that differs in bodies alone, which come after those that the search was begun with;
/// as far as the settings allow beyond what it spent. Where these bodies turn the way of the base aside, or meet the first half
/// of the stances that were found, it is another search: what stays was chosen for what followed.
///
/// # Errors
/// As [`portfolio::search`].
pub fn search_on(
    tree: Tree,
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<(SearchResult, Option<Tree>), Error> {
    let context = SearchContext::new(request, config, posture_config)?;
    let mut context = way::laid(context, &tree.preference);
    let (robot, environment) = (request.robot, request.environment);
    let moves = MotionContext::new(robot, environment, posture_config, motion_config);
    let is_along = context.gap.is_none() && context.route.is_along(&tree.route);
    if !is_along || !tree.keeps_most(&moves) {
        let found = portfolio::grow(
            request,
            config,
            posture_config,
            motion_config,
            progress,
            cancel,
        );
        return found.map(|(result, other)| tree.and(result, other));
    }
    context.route = tree.route.clone();
    let preference = tree.preference.clone();
    let mut search = Search::bare(context, posture_config, motion_config);
    search.take(tree, progress)?;
    let ended = search.run([usize::MAX; 2], progress, cancel)?;
    Ok(search.into_ended(ended.unwrap_or(Status::Exhausted), preference))
}

impl Search<'_> {
    /// How it ended; with its tree, where that may be gone on with.
    pub fn into_ended(
        mut self,
        status: Status,
        preference: Preference,
    ) -> (SearchResult, Option<Tree>) {
        let result = self.ended(status);
        // What improved a plan weighs otherwise.
        let reached = self.reached.filter(|_| self.context.config.improve == 0);
        // What is known on any number of threads.
        let nodes = self.nodes.iter().enumerate();
        let settled = nodes.filter(|(i, node)| node.settled && !self.dead.contains(i));
        let edges: Vec<[PathStance; 2]> = settled
            .filter_map(|(_, node)| Some([&self.nodes[node.parent?], node].map(PathStance::from)))
            .collect();
        let mut paths: Vec<&[PathStance]> = edges.iter().map(|edge| &edge[..]).collect();
        paths.push(&result.path);
        let motions = self.motions.only(&paths);
        let tree = reached.map(|reached| Tree {
            bodies: self.context.request.environment.world().obstacles().len(),
            preference,
            route: self.context.route,
            nodes: self.nodes,
            dead: self.dead,
            frontier: self.frontier,
            staleness: self.staleness,
            seen: self.seen,
            changes_min: self.changes_min,
            blocked: self.blocked,
            failed: self.failed,
            expanded: self.expanded,
            solved: self.solved,
            elsewhere: self.elsewhere,
            motions,
            reached,
        });
        (result, tree)
    }

    /// Takes over what another search grew, less the stances and motions that come too near to the bodies that were not there
    /// then: what led to these is tried anew.
    fn take(&mut self, tree: Tree, progress: Told) -> Result<(), Error> {
        let bodies = tree.bodies..self.context.request.environment.world().obstacles().len();
        self.nodes = tree.nodes;
        self.dead = tree.dead;
        self.frontier = tree.frontier;
        self.frontier.forget();
        self.staleness = tree.staleness;
        self.seen = tree.seen;
        self.changes_min = tree.changes_min;
        self.blocked = tree.blocked;
        self.failed = tree.failed;
        self.expanded = tree.expanded;
        self.solved = tree.solved;
        self.elsewhere = tree.elsewhere;
        self.motions.known = tree.motions;
        self.motions.keep_off(&bodies);
        let more = [self.budget, [self.spent()[0], self.spent()[2]]];
        self.budget = std::array::from_fn(|k| more[0][k].saturating_add(more[1][k]));
        for index in 1..self.nodes.len() {
            let node = &self.nodes[index];
            let Some(parent) = node.parent.filter(|_| !self.dead.contains(&index)) else {
                continue;
            };
            let pair = [parent, index].map(|i| PathStance::from(&self.nodes[i]));
            let stands = keeps_off(&self.motions.context, [&node.posture.q], &bodies);
            let moves = !node.settled || self.motions.knows(&pair);
            if stands && moves {
                continue;
            }
            let origin = self.nodes[index].origin.clone();
            self.cut(index);
            origin.into_iter().for_each(|origin| self.put(origin));
        }
        let (kept, of) = (self.nodes.len() - self.dead.len(), self.nodes.len());
        tracing::debug!("{kept} of {of} nodes are clear of the bodies {bodies:?}");
        let alive = (0..self.nodes.len()).filter(|i| !self.dead.contains(i));
        let rests = alive.filter(|&i| i != tree.reached);
        let rests = rests.map(|i| self.nodes[i].rest(&self.context));
        self.nearest = (rests.fold(f64::INFINITY, f64::min), 0);
        if self.dead.contains(&tree.reached) {
            return Ok(());
        }
        match try_goal(
            &self.context,
            self.posture_config,
            &self.nodes[tree.reached],
        )? {
            Attempt::Reached(last) => self.finalize(tree.reached, last, progress),
            _ => {
                self.branch(tree.reached);
                Ok(())
            }
        }
    }
}
