//! Where the search has gone on long without coming nearer to the goal: what is left to try there waits
//! until other parts of the tree had their turn.
//!
//! A try that comes no nearer than what a node has below it already counts at that node, and at its
//! ancestors the less, the farther they are. A weighted estimate holds a best-first search in a dead
//! end until all of it is tried; by these counts it backs out of one step by step, and goes straight on
//! where nothing failed yet.

use crate::node::Node;

/// What one try counts at the parent of a node where it counts 1.
const UPWARD: f64 = 0.8;
/// Counts below this are nothing.
const NOTHING: f64 = 1e-3;
/// Price of a count, in contacts.
pub(crate) const STALE_PRICE: f64 = 0.3;

/// How a node's part of the tree gets on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// The least estimate to the goal of a node there, in contacts.
    nearest: f64,
    /// Tries that came no nearer.
    pub stale: f64,
}

impl Progress {
    /// Where nothing was tried.
    pub const NONE: Self = Self {
        nearest: f64::INFINITY,
        stale: 0.0,
    };
}

/// Counts a try at a node; `estimate` is what the new node has before it, where there is one. What the
/// new node starts with.
pub(crate) fn count(nodes: &mut [Node], tried: usize, estimate: Option<f64>) -> Progress {
    let nearest = estimate.unwrap_or(f64::INFINITY);
    let before = nodes[tried].progress;
    let stale = if nearest < before.nearest {
        0.0
    } else {
        UPWARD * before.stale
    };
    let (mut at, mut counts) = (Some(tried), 1.0);
    while let Some(node) = at.filter(|_| counts > NOTHING) {
        let progress = &mut nodes[node].progress;
        if nearest < progress.nearest {
            progress.nearest = nearest;
        } else {
            progress.stale += counts;
        }
        counts *= UPWARD;
        at = nodes[node].parent;
    }
    Progress { nearest, stale }
}
