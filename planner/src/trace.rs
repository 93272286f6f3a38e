//! What the search tried, for who wonders why: its tree, what it was refused, and for each contact of the way
//! what else there was.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use plan::{Alternative, Choice, Refusal, Trace, TracedNode};

use crate::change::Candidate;
use crate::node_construction::describe;
use crate::result::Blocked;
use crate::search::Search;

/// Alternatives that are told of one choice.
const ALTERNATIVES: usize = 6;
/// Refusals that are told.
const REFUSALS: usize = 2000;

/// To the millimetre.
fn place(p: &Vector3<f64>) -> [f64; 3] {
    p.map(|x| (1e3 * x).round() / 1e3).into()
}

impl Search<'_> {
    /// The tree with the choices along a way, given by its nodes; whether it comes to the goal.
    pub(crate) fn trace(&self, way: &[usize], is_plan: bool) -> Trace {
        let nodes = self.nodes.iter().enumerate();
        let tried = self.blocked.iter().filter_map(|one| one.tried.as_ref());
        let refused: Vec<Refusal> = tried
            .map(|tried| Refusal {
                node: tried.node,
                at_W: place(&tried.at_W),
                by: tried.by,
            })
            .collect();
        let made = way.iter().enumerate().skip(1);
        let made = made.filter_map(|(stance, &chosen)| {
            let node = self.nodes[chosen].parent?;
            Some(self.choice(stance, node, Some(chosen)))
        });
        let last = way.last().filter(|_| !is_plan);
        let stuck = last.map(|&node| self.choice(way.len(), node, None));
        Trace {
            nodes: nodes
                .map(|(index, node)| TracedNode {
                    parent: node.parent,
                    base_W: place(&node.posture.q.p_WB),
                    cut: self.dead.contains(&index),
                })
                .collect(),
            refused: refused[refused.len().saturating_sub(REFUSALS)..].to_vec(),
            choices: made.chain(stuck).collect(),
        }
    }

    /// What was chosen at a node, and what else there was.
    fn choice(&self, stance: usize, node: usize, chosen: Option<usize>) -> Choice {
        let refused = self
            .blocked
            .iter()
            .rev()
            .filter_map(|one| refusal(one, node));
        let children = self.nodes.iter().enumerate();
        let children = children.filter(|(index, child)| {
            child.parent == Some(node) && Some(*index) != chosen && !self.dead.contains(index)
        });
        let reached = children.map(|(_, child)| {
            let reason = "reached too; what follows from there was not needed";
            let at_W = child.changed_W(&self.context);
            (at_W, alternative(child.change.clone(), child.price, reason))
        });
        let waiting = self.frontier.candidates().filter(|c| c.node == node);
        let waiting = waiting.map(|candidate: &Candidate| {
            let parent = &self.nodes[node];
            let change = describe(&self.context, parent, &candidate.change);
            let price = candidate.price(self.context.weight);
            (
                parent.place_of_W(&candidate.change),
                alternative(change, price, "not tried"),
            )
        });
        // One change to one place once: what is sure of it.
        let mut told = BTreeSet::new();
        let mut once = |(at_W, one): (Vector3<f64>, Alternative)| {
            let cell = at_W.map(|x| (1e2 * x).round() as i64);
            let is_new = told.insert((format!("{:?}", one.change), <[i64; 3]>::from(cell)));
            is_new.then_some(one)
        };
        let chosen = chosen.map(|index| &self.nodes[index]);
        if let Some(chosen) = chosen {
            let at_W = chosen.changed_W(&self.context);
            once((at_W, alternative(chosen.change.clone(), chosen.price, "")));
        }
        let all = refused.chain(reached).chain(waiting);
        let mut alternatives: Vec<Alternative> = all.filter_map(once).collect();
        alternatives.sort_by(|a, b| a.price.total_cmp(&b.price));
        let more = alternatives.len().saturating_sub(ALTERNATIVES);
        alternatives.truncate(ALTERNATIVES);
        Choice {
            stance,
            node,
            price: chosen.map(|node| rounded(node.price)),
            alternatives,
            more,
        }
    }
}

/// What could not be done at a node.
fn refusal(blocked: &Blocked, node: usize) -> Option<(Vector3<f64>, Alternative)> {
    let tried = blocked.tried.as_ref().filter(|tried| tried.node == node)?;
    let refused = alternative(blocked.change.clone(), tried.price, &blocked.reason);
    let by = Some(tried.by);
    Some((tried.at_W, Alternative { by, ..refused }))
}

fn alternative(change: plan::Change, price: f64, reason: &str) -> Alternative {
    Alternative {
        change,
        price: rounded(price),
        by: None,
        reason: reason.to_owned(),
    }
}

fn rounded(price: f64) -> f64 {
    (1e2 * price).round() / 1e2
}
