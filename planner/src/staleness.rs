//! Where the search has gone on long without coming nearer to the goal: what is left to try there waits
//! until other parts of the tree had their turn.
//!
//! A try that comes no nearer than what a node has below it already counts at that node and at all below
//! it, and at an ancestor and what else lies below that the less, the farther the ancestor is. A weighted
//! estimate holds a best-first search in a dead end until all of it is tried; by these counts it backs out
//! of one step by step, and goes straight on where nothing failed yet. (Counted at the ancestors alone,
//! failures of ten branches would make what is left to try at the fork before them dearer than in any of
//! the branches.)

/// What one try counts at the parent of a node where it counts 1.
const UPWARD: f64 = 0.8;
/// What one that fails counts: more than one that only comes no nearer, so that alternatives far back have
/// their turn before all hands were tried in a dead end.
const FAILED: f64 = 1.5;
/// Counts below this are nothing.
const NOTHING: f64 = 1e-3;
/// Price of a count, in contacts.
const STALE_PRICE: f64 = 0.4;

/// How a node's part of the tree gets on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    parent: Option<usize>,
    /// The least estimate to the goal of a node there, in contacts.
    nearest: f64,
    /// Tries there that came no nearer.
    stale: f64,
    /// What is added to the counts of the node and its ancestors: what it begins with, less what they
    /// were then.
    offset: f64,
}

/// The counts of all nodes, by their numbers.
pub(crate) struct Staleness(Vec<Progress>);

impl Staleness {
    /// Those of a tree of a root alone, where nothing was tried.
    pub fn new() -> Self {
        Self(vec![Progress {
            parent: None,
            nearest: f64::INFINITY,
            stale: 0.0,
            offset: 0.0,
        }])
    }

    /// Counts a try at a node; `estimate` is what the node that comes of it has before it, if one
    /// does. What that node starts with.
    pub fn count(&mut self, tried: usize, estimate: Option<f64>) -> Progress {
        let nearest = estimate.unwrap_or(f64::INFINITY);
        let nearer = nearest < self.0[tried].nearest;
        let counts = estimate.map_or(FAILED, |_| 1.0);
        let (mut at, mut counts) = (Some(tried), counts);
        while let Some(node) = at.filter(|_| counts > NOTHING) {
            let progress = &mut self.0[node];
            if nearest < progress.nearest {
                progress.nearest = nearest;
            } else {
                progress.stale += counts;
            }
            counts *= UPWARD;
            at = progress.parent;
        }
        let begins = if nearer {
            0.0
        } else {
            UPWARD * self.counted(tried)
        };
        Progress {
            parent: Some(tried),
            nearest,
            stale: 0.0,
            offset: begins - self.shared(tried),
        }
    }

    /// Joins the next node.
    pub fn push(&mut self, progress: Progress) {
        self.0.push(progress);
    }

    /// What is left to try at a node costs more by this, in contacts.
    pub fn price(&self, node: usize) -> f64 {
        STALE_PRICE * self.counted(node)
    }

    /// Tries that came no nearer, since there is the node: each the less, the farther it lies below the
    /// last node that it has in common with this one.
    fn counted(&self, node: usize) -> f64 {
        self.0[node].offset + self.shared(node)
    }

    /// As [`Self::counted`], of all times: of what is counted at a node, [`UPWARD`] is counted at its parent
    /// too.
    fn shared(&self, node: usize) -> f64 {
        let ancestors = std::iter::successors(Some(node), |&node| self.0[node].parent);
        let counted = ancestors.map(|node| match self.0[node].parent {
            Some(_) => (1.0 - UPWARD) * self.0[node].stale,
            None => self.0[node].stale,
        });
        counted.sum()
    }
}
