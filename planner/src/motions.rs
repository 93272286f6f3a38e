//! Motions of the edges of a path, each computed once.

use std::collections::BTreeMap;

use motion::{Failure, MotionContext, Segment, StanceRef};
use plan::Motion;
use rayon::prelude::*;

use crate::Error;
use crate::result::PathStance;

/// What a motion depends on: the two stances, to the bit.
type Key = [Vec<u64>; 2];

/// The motions between stances that were asked for so far.
///
/// A motion depends on its two stances alone, so the order and the number of threads in which they
/// are computed do not matter.
pub(crate) struct Motions<'a> {
    pub context: MotionContext<'a>,
    known: BTreeMap<Key, Result<Segment, Failure>>,
}

impl<'a> Motions<'a> {
    pub fn new(context: MotionContext<'a>) -> Self {
        Self {
            context,
            known: BTreeMap::new(),
        }
    }

    /// Computes the motions of a path that are not known yet; the first stance that cannot be
    /// reached from the one before it, and why. `told` hears how many are known, and of how many.
    ///
    /// # Errors
    /// [`Error::Motion`] where stances do not follow on each other.
    pub fn along(
        &mut self,
        path: &[PathStance],
        told: &dyn Fn(usize, usize),
    ) -> Result<Option<(usize, Failure)>, Error> {
        let pairs: Vec<(Key, &[PathStance])> = path.windows(2).map(|p| (key(p), p)).collect();
        let context = &self.context;
        let solve = |(key, pair): &(Key, &[PathStance])| {
            let edge = motion::segment(context, end(&pair[0]), end(&pair[1]))?;
            Ok((key.clone(), edge))
        };
        // As many at a time as there are threads: what lies beyond a missing motion may never be
        // asked for.
        let mut number = 0;
        for batch in pairs.chunks(rayon::current_num_threads()) {
            told(number, pairs.len());
            let unknown = batch
                .iter()
                .filter(|(key, _)| !self.known.contains_key(key));
            let unknown: Vec<_> = unknown.collect();
            let solved: Result<Vec<_>, Error> = unknown.into_par_iter().map(solve).collect();
            self.known.extend(solved?);
            for (key, _) in batch {
                number += 1;
                if let Some(Err(failure)) = self.known.get(key) {
                    return Ok(Some((number, failure.clone())));
                }
            }
        }
        Ok(None)
    }

    /// The motion of a path all of whose edges have one.
    pub fn assemble(&self, path: &[PathStance]) -> Option<Motion> {
        let segments: Option<Vec<&Segment>> = path
            .windows(2)
            .map(|pair| self.known.get(&key(pair))?.as_ref().ok())
            .collect();
        let segments = segments.filter(|s| !s.is_empty())?;
        Some(motion::assemble(&self.context, &segments))
    }
}

fn key(pair: &[PathStance]) -> Key {
    let bits = |stance: &PathStance| {
        let contacts = stance.contacts.iter();
        let contacts = contacts.map(|c| 2 * c.patch.index() as u64 + u64::from(c.loaded));
        let states = stance.posture.contacts.iter();
        let forces = states.flat_map(|state| state.forces_W.iter().flatten().copied());
        let numbers = stance.posture.q.to_q().into_iter().chain(forces);
        contacts.chain(numbers.map(f64::to_bits)).collect()
    };
    [bits(&pair[0]), bits(&pair[1])]
}

fn end(stance: &PathStance) -> StanceRef<'_> {
    StanceRef {
        contacts: &stance.contacts,
        posture: &stance.posture,
    }
}
