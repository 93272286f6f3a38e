//! Motions of the edges of a path, each computed once.

use std::collections::BTreeMap;
use std::ops::Range;

use motion::{Failure, MotionContext, Segment, StanceRef};
use rayon::prelude::*;

use crate::Error;
use crate::result::PathStance;

/// What a motion depends on: the two stances, to the bit.
type Key = [Vec<u64>; 2];

/// What is known of the motions between stances.
pub(crate) type Known = BTreeMap<Key, Result<Segment, Failure>>;

/// The motions between stances that were asked for so far.
///
/// A motion depends on its two stances alone, so the order and the number of threads in which they
/// are computed do not matter.
pub(crate) struct Motions<'a> {
    pub context: MotionContext<'a>,
    pub known: Known,
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

    /// The motions of a path all of whose edges have one, in order.
    pub fn of(&self, path: &[PathStance]) -> Option<Vec<Segment>> {
        let pairs = path.windows(2);
        let known = pairs.map(|pair| self.known.get(&key(pair))?.as_ref().ok());
        known.map(|segment| segment.cloned()).collect()
    }

    /// What is known of the edges of paths, and no more.
    pub fn only(mut self, paths: &[&[PathStance]]) -> Known {
        let pairs = paths.iter().flat_map(|path| path.windows(2));
        pairs
            .filter_map(|pair| self.known.remove_entry(&key(pair)))
            .collect()
    }

    /// Whether there is a motion from one stance to the next, as far as is known.
    pub fn knows(&self, pair: &[PathStance; 2]) -> bool {
        matches!(self.known.get(&key(pair)), Some(Ok(_)))
    }

    /// Forgets the motions that come too near to bodies of the world, by index.
    pub fn keep_off(&mut self, bodies: &Range<usize>) {
        let context = &self.context;
        let keeps_off = |edge: &Result<Segment, Failure>| {
            let segment = edge.as_ref();
            segment.map_or(true, |segment| segment.keeps_off(context, bodies))
        };
        self.known.retain(|_, edge| keeps_off(edge));
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
