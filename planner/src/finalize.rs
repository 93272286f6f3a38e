//! What is done with a way that reaches the goal: it is shortened and given its motion. A contact
//! change that has no motion is no edge of the tree: it is cut, and the search goes on.

use std::sync::Arc;

use motion::Failure;
use posture::Posture;

use crate::Error;
use crate::node::Node;
use crate::result::{PathStance, Progress, SearchResult, Stage, Status};
use crate::search::Search;
use crate::shorten::shorten;
use plan::{Change, Trace};

/// Posture problems that are solved for each node that a plan is improved by.
const PROBLEMS_A_NODE: usize = 10;

impl Search<'_> {
    /// Keeps the plan by way of a node that has the goal's posture; where a motion is missing on the
    /// way, that is cut there.
    ///
    /// # Errors
    /// [`Error`] where a posture or a motion cannot be asked for.
    pub(crate) fn finalize(
        &mut self,
        index: usize,
        last: Arc<Posture>,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<(), Error> {
        self.reached = Some(index);
        let goal = PathStance {
            change: Change::Goal,
            contacts: self.nodes[index].contacts.clone(),
            posture: last,
        };
        let indices = self.way(index);
        let way: Vec<Node> = indices.iter().map(|&i| self.nodes[i].clone()).collect();
        // A node's depth is its place on the way, whatever is left out of that.
        let of_tree = |way: &[Node]| way.iter().map(|node| indices[node.depth]).collect();

        // The short way, if there are motions all along it.
        let config = self.posture_config;
        let (shorter, solved) = shorten(&self.context, config, way.clone(), &mut |_| Ok(true))?;
        self.solved += solved;
        let so_far = self.progress(Stage::Search);
        let told = |known, of| {
            let stage = Stage::Motion { known, of };
            progress(Progress { stage, ..so_far });
        };
        let short = path(&shorter, &goal);
        if self.motions.along(&short, &told)?.is_none() {
            progress(self.progress(Stage::Search));
            self.keep(short, of_tree(&shorter));
            return Ok(());
        }

        // The way as it was found, left out only what motions can do without too.
        let missing = self.motions.along(&path(&way, &goal), &told)?;
        if let Some((stance, failure)) = missing {
            progress(self.progress(Stage::Search));
            self.forbid(&indices, stance, &failure);
            return Ok(());
        }
        let motions = &mut self.motions;
        let (shorter, solved) = shorten(&self.context, config, way, &mut |way| {
            Ok(motions.along(&path(way, &goal), &told)?.is_none())
        })?;
        self.solved += solved;
        progress(self.progress(Stage::Search));
        self.keep(path(&shorter, &goal), of_tree(&shorter));
        Ok(())
    }

    /// Keeps a path with motions all along it, and its nodes, if it is the best; after the first, the search goes on for
    /// shorter ones where it is asked to.
    fn keep(&mut self, path: Vec<PathStance>, way: Vec<usize>) {
        // The goal's posture is on the last contact set.
        let stances = path.len() - 1;
        if !self.could_be_better(stances - 1) {
            return;
        }
        if self.best.is_none() {
            let more = self.context.config.improve;
            let [nodes, _, solved] = self.spent();
            self.budget = [nodes + more, solved + more * PROBLEMS_A_NODE];
            if more > 0 {
                // Few contacts count from here on, not a quick answer.
                self.frontier.weigh_less(self.context.weight - 1.0);
                self.context.weight = 1.0;
            }
        }
        self.best = Some(SearchResult {
            status: Status::Found,
            summary: self.summary(stances),
            segments: self.motions.of(&path).unwrap_or_default(),
            motion: None,
            path,
            blocked: Vec::new(),
            trace: Trace::default(),
        });
        self.best_way = way;
    }

    /// Whether a way with so many contact changes is shorter than the best plan.
    pub(crate) fn could_be_better(&self, changes: usize) -> bool {
        let best = self.best.as_ref();
        best.is_none_or(|best| changes + 1 < best.summary.path_stances)
    }

    /// Whether there is a plan and nothing more is to be done about it.
    pub(crate) fn is_done(&self) -> bool {
        self.best.is_some() && (self.is_spent() || !self.could_be_better(self.changes_min))
    }

    /// Whether the budget is spent.
    pub(crate) fn is_spent(&self) -> bool {
        let ([nodes, _, solved], [nodes_max, solved_max]) = (self.spent(), self.budget);
        nodes >= nodes_max || solved >= solved_max
    }

    /// The best plan where there is one, or how far the search came.
    pub(crate) fn ended(&mut self, status: Status) -> SearchResult {
        let Some(best) = self.best.take() else {
            return self.give_up(status);
        };
        SearchResult {
            summary: self.summary(best.summary.path_stances),
            trace: self.trace(&self.best_way, true),
            ..best
        }
    }

    /// The way to the node nearest to the goal, and what blocks the rest.
    fn give_up(&mut self, status: Status) -> SearchResult {
        let way = self.way(self.nearest());
        let path: Vec<PathStance> = way
            .iter()
            .map(|&i| PathStance::from(&self.nodes[i]))
            .collect();
        let trace = self.trace(&way, false);
        let mut blocked = std::mem::take(&mut self.blocked);
        blocked.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        if status != Status::Interrupted {
            self.add_remedies(&mut blocked);
        }
        SearchResult {
            status,
            summary: self.summary(path.len()),
            path,
            segments: Vec::new(),
            motion: None,
            blocked,
            trace,
        }
    }

    /// Indices of the nodes from the root to a node.
    fn way(&self, index: usize) -> Vec<usize> {
        let mut way: Vec<usize> =
            std::iter::successors(Some(index), |&i| self.nodes[i].parent).collect();
        way.reverse();
        way
    }

    /// Cuts the tree where a way has no motion to its stance number `stance`.
    fn forbid(&mut self, way: &[usize], stance: usize, failure: &Failure) {
        let parent = way[stance - 1];
        let child = way.get(stance).map(|&i| self.nodes[i].clone());
        self.block(parent, child, format!("no motion: {}", failure.describe()));
        match way.get(stance) {
            Some(&node) => {
                self.mend(node, failure);
                self.cut(node);
            }
            // The contact set stands; the goal is to be reached from those after it.
            None => self.branch(parent),
        }
    }
}

fn path(way: &[Node], goal: &PathStance) -> Vec<PathStance> {
    let mut path: Vec<PathStance> = way.iter().map(PathStance::from).collect();
    path.push(goal.clone());
    path
}
