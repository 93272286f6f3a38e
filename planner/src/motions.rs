//! Motions of the edges of a path, each computed once.

use std::collections::BTreeMap;
use std::sync::Arc;

use motion::{End, Failure, Motion, Segment, Setting};
use rayon::prelude::*;

use crate::Error;
use crate::answer::PathStance;

type Edge = Result<Segment, Failure>;

/// The motions between stances that were asked for so far.
///
/// A motion depends on its two stances alone, so the order and the number of threads in which they
/// are computed do not matter.
pub(crate) struct Motions<'a> {
    pub setting: Setting<'a>,
    /// By the addresses of the two postures, which are kept alive beside the edge.
    known: BTreeMap<(usize, usize), (PathStance, PathStance, Edge)>,
}

impl<'a> Motions<'a> {
    pub fn new(setting: Setting<'a>) -> Self {
        Self {
            setting,
            known: BTreeMap::new(),
        }
    }

    /// Computes the motions of a path that are not known yet; the first stance that cannot be
    /// reached from the one before it, and why.
    ///
    /// # Errors
    /// [`Error::Motion`] where stances do not follow on each other.
    pub fn along(&mut self, path: &[PathStance]) -> Result<Option<(usize, Failure)>, Error> {
        let pairs: Vec<&[PathStance]> = path.windows(2).collect();
        let setting = &self.setting;
        let solve = |pair: &&[PathStance]| {
            motion::segment(setting, end(&pair[0]), end(&pair[1]))
                .map(|edge| (key(pair), (pair[0].clone(), pair[1].clone(), edge)))
        };
        // As many at a time as there are threads: what lies beyond a missing motion may never be
        // asked for.
        for batch in pairs.chunks(rayon::current_num_threads()) {
            let unknown = batch
                .iter()
                .filter(|pair| !self.known.contains_key(&key(pair)));
            let unknown: Vec<_> = unknown.collect();
            let solved: Vec<_> = unknown
                .into_par_iter()
                .map(solve)
                .collect::<Result<_, _>>()?;
            self.known.extend(solved);
            let known = |pair: &&[PathStance]| self.known.get(&key(pair));
            if batch
                .iter()
                .filter_map(known)
                .any(|(.., edge)| edge.is_err())
            {
                break;
            }
        }
        Ok(path.windows(2).enumerate().find_map(|(i, pair)| {
            let (.., edge) = self.known.get(&key(pair))?;
            Some((i + 1, edge.as_ref().err()?.clone()))
        }))
    }

    /// The motion of a path all of whose edges have one.
    pub fn assemble(&self, path: &[PathStance]) -> Option<Motion> {
        let segments: Option<Vec<&Segment>> = path
            .windows(2)
            .map(|pair| self.known.get(&key(pair))?.2.as_ref().ok())
            .collect();
        let segments = segments.filter(|s| !s.is_empty())?;
        Some(motion::assemble(&self.setting, &segments))
    }
}

fn key(pair: &[PathStance]) -> (usize, usize) {
    let address = |stance: &PathStance| Arc::as_ptr(&stance.posture) as usize;
    (address(&pair[0]), address(&pair[1]))
}

fn end(stance: &PathStance) -> End<'_> {
    End {
        contacts: &stance.contacts,
        posture: &stance.posture,
    }
}
