//! Where the search has gone on long without coming nearer to the goal: what is left to try there waits
//! until other parts of the tree had their turn.
//!
//! A try that comes no nearer than what a node has below it already counts at that node, and at its
//! ancestors the less, the farther they are. A weighted estimate holds a best-first search in a dead
//! end until all of it is tried; by these counts it backs out of one step by step, and goes straight on
//! where nothing failed yet.

/// What one try counts at the parent of a node where it counts 1.
const UPWARD: f64 = 0.8;
/// What one that fails counts: more than one that only comes no nearer, so that alternatives far back have
/// their turn before all hands were tried in a dead end.
const FAILED: f64 = 2.5;
/// Counts below this are nothing.
const NOTHING: f64 = 1e-3;
/// Price of a count, in contacts.
const STALE_PRICE: f64 = 0.3;

/// How a node's part of the tree gets on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    parent: Option<usize>,
    /// The least estimate to the goal of a node there, in contacts.
    nearest: f64,
    /// Tries that came no nearer.
    stale: f64,
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
        }])
    }

    /// Counts a try at a node; `estimate` is what the node that comes of it has before it, if one
    /// does. What that node starts with.
    pub fn count(&mut self, tried: usize, estimate: Option<f64>) -> Progress {
        let nearest = estimate.unwrap_or(f64::INFINITY);
        let before = self.0[tried];
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
        let nearer = nearest < before.nearest;
        Progress {
            parent: Some(tried),
            nearest,
            stale: if nearer { 0.0 } else { UPWARD * before.stale },
        }
    }

    /// Joins the next node.
    pub fn push(&mut self, progress: Progress) {
        self.0.push(progress);
    }

    /// What is left to try at a node costs more by this, in contacts.
    pub fn price(&self, node: usize) -> f64 {
        STALE_PRICE * self.0[node].stale
    }
}
