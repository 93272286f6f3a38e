//! What would let the contact changes through that are told of when there is no plan.

use std::collections::BTreeSet;

use posture::Relaxation;
use rayon::prelude::*;

use crate::nominal_posture::nominal_posture;
use crate::result::Blocked;
use crate::search::Search;

/// So many of the changes that block the way are told of, those nearest to the goal.
pub const TOLD: usize = 6;

/// What would let a change through.
enum Remedy {
    /// More attempts at its posture than the search makes.
    Attempts,
    /// One limit that gives way.
    Limit(Relaxation),
}

impl Search<'_> {
    /// Adds to the reasons of the first changes that have no posture what one kind of limit would have to be for one: where
    /// an attempt ends says what gave way, not what is too tight. A robot too weak for a step misses its place.
    pub(crate) fn add_remedies(&self, blocked: &mut [Blocked]) {
        let mut seen = BTreeSet::new();
        let once = blocked
            .iter_mut()
            .filter(|one| seen.insert(one.change.to_string()));
        let told: Vec<&mut Blocked> = once.take(TOLD).collect();
        told.into_par_iter().for_each(|one| {
            let words = match self.remedy(one) {
                None => return,
                Some(Remedy::Attempts) => "with more attempts it has a posture".to_owned(),
                Some(Remedy::Limit(limit)) => {
                    let words = format!("it would take {}", limit.words);
                    one.remedy = Some(limit);
                    words
                }
            };
            one.reason = format!("{}; {words}", one.reason);
        });
    }

    /// What alone would be enough; nothing where it takes more than one limit, or no posture is what fails.
    fn remedy(&self, blocked: &Blocked) -> Option<Remedy> {
        let tried = blocked.tried.as_ref().filter(|t| !t.asked.is_empty())?;
        let (context, node) = (&self.context, &self.nodes[tried.node]);
        let nominal = nominal_posture(context, &tried.asked, node.along_m(context));
        let problem = context.problem(tried.asked.clone(), &nominal, &node.posture.q);
        let config = posture::Config {
            solver: posture::Solver {
                upright: Some(context.upright(&nominal)),
                ..self.posture_config.solver
            },
            ..self.posture_config.clone()
        };
        if posture::solve(&problem, &config).ok()?.posture().is_some() {
            return Some(Remedy::Attempts);
        }
        posture::remedy(&problem, &config).ok()?.map(Remedy::Limit)
    }
}
