//! Candidates in the order of their prices, each with its outcome where it was solved ahead of its turn.

use std::collections::BTreeMap;

use crate::Error;
use crate::candidate::Solved;
use crate::change::Candidate;

/// What came of a candidate.
pub(crate) type Outcome = Result<Option<Solved>, Error>;

/// Order of the frontier: priority, then the number of the candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Rank(u64, usize);

/// What waits for its turn.
#[derive(Default)]
pub(crate) struct Frontier {
    waiting: BTreeMap<Rank, (Candidate, Option<Outcome>)>,
    counted: usize,
}

impl Frontier {
    /// Adds a candidate, with its outcome where that is known.
    pub fn put(&mut self, candidate: Candidate, outcome: Option<Outcome>) {
        self.counted += 1;
        // Priorities are finite and not negative: their bits have their order.
        let rank = Rank(candidate.priority.max(0.0).to_bits(), self.counted);
        self.waiting.insert(rank, (candidate, outcome));
    }

    /// What waits, the best first.
    pub fn candidates(&self) -> impl Iterator<Item = &Candidate> {
        self.waiting.values().map(|(candidate, _)| candidate)
    }

    /// The best candidate, and whether it is solved.
    pub fn first(&self) -> Option<(&Candidate, bool)> {
        let (_, (candidate, outcome)) = self.waiting.first_key_value()?;
        Some((candidate, outcome.is_some()))
    }

    /// The best candidates that are not solved.
    pub fn due(&self, count: usize) -> Vec<(Rank, Candidate)> {
        let waiting = self.waiting.iter();
        let open = waiting.filter(|(_, (_, outcome))| outcome.is_none());
        let open = open.map(|(rank, (candidate, _))| (*rank, candidate.clone()));
        open.take(count).collect()
    }

    /// Keeps the outcome of a candidate.
    pub fn solved(&mut self, rank: Rank, outcome: Outcome) {
        if let Some(entry) = self.waiting.get_mut(&rank) {
            entry.1 = Some(outcome);
        }
    }

    /// Takes the best candidate with its outcome, where it is solved.
    pub fn pop(&mut self) -> Option<(Candidate, Option<Outcome>)> {
        let (_, waiting) = self.waiting.pop_first()?;
        Some(waiting)
    }

    /// Takes the candidate that is best by another price.
    pub fn pop_by(
        &mut self,
        price: impl Fn(&Candidate) -> f64,
    ) -> Option<(Candidate, Option<Outcome>)> {
        let waiting = self.waiting.iter();
        let prices = waiting.map(|(rank, (candidate, _))| (*rank, price(candidate)));
        let (rank, _) = prices.min_by(|a, b| a.1.total_cmp(&b.1))?;
        self.waiting.remove(&rank)
    }

    /// Forgets the outcomes of what was solved ahead of its turn.
    pub fn forget(&mut self) {
        self.waiting
            .values_mut()
            .for_each(|(_, outcome)| *outcome = None);
    }

    /// Leaves out the candidates that do not fit.
    pub fn retain(&mut self, fits: impl Fn(&Candidate) -> bool) {
        self.waiting.retain(|_, (candidate, _)| fits(candidate));
    }

    /// Weighs what is estimated to follow by so much less.
    pub fn weigh_less(&mut self, surplus: f64) {
        for (_, (mut candidate, outcome)) in std::mem::take(&mut self.waiting) {
            candidate.priority -= surplus * candidate.rest;
            self.put(candidate, outcome);
        }
    }
}
