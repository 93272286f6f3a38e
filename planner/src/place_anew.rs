//! A change that fails by little is tried once more with the contacts made just before it at other
//! places, all chosen together.
//!
//! A contact is put where its own posture wants it. Whether the next foot can leave from there is found
//! out only then, and of the places around most may not do: a hand has to push where it holds the foot
//! that stays, and that foot has to stand where the hand holds it.

use std::sync::Arc;

use posture::{Contact, Outcome, Posture, Problem};
use robot_model::Configuration;

use crate::Error;
use crate::change::{Candidate, Move};
use crate::nominal_posture::nominal_posture;
use crate::search::Search;

/// A change that fails by more than this is not mended by other places of the contacts before it, as
/// [`posture::Violation::amount`].
const LITTLE: f64 = 0.05;

/// The first of changes that were planned together, with the others to follow, all at the places of the posture that was found for
/// the contacts that were asked for; as another candidate, whose price it has.
pub(crate) fn one_by_one(
    mut changes: Vec<Move>,
    asked: &[Contact],
    posture: Arc<Posture>,
) -> Option<impl FnOnce(&Candidate) -> Candidate> {
    for change in &mut changes {
        let Move::Add(foothold) = change else {
            continue;
        };
        let mut placed = asked.iter().zip(&posture.contacts);
        let found = placed.find(|(c, _)| c.patch == foothold.patch);
        foothold.exact =
            found.map(|(contact, state)| Box::new(contact.placed(state.X_WC).loaded(false)));
    }
    let mut changes = changes.into_iter();
    let change = changes.next()?;
    let then: Vec<Move> = changes.collect();
    Some(move |other: &Candidate| Candidate {
        change,
        then: Some(then),
        purpose: Vec::new(),
        planned: Some(posture),
        ..other.clone()
    })
}

impl Search<'_> {
    /// The first of the changes that put the contacts made before a failed change at places from which
    /// it can be done, with the others to follow; nothing where there are no such contacts, or none
    /// was found. They are sought from the posture of the failed change's node, then from where that change itself
    /// came `nearest`.
    ///
    /// # Errors
    /// [`Error::Posture`] where the posture cannot be asked for.
    pub fn place_anew(
        &self,
        failed: &Candidate,
        amount: Option<f64>,
        nearest: Option<&Configuration>,
    ) -> Result<Option<Candidate>, Error> {
        let is_hopeless = amount.is_none_or(|amount| amount > LITTLE);
        let was_tried =
            failed.tries > 0 || failed.is_variant() || self.failed_elsewhere(failed) > 0;
        if is_hopeless || was_tried {
            return Ok(None);
        }
        let context = &self.context;
        let node = &self.nodes[failed.node];

        // From the failed change back to what was released before the contacts made last.
        let mut changes = vec![failed.change.clone()];
        let mut first = failed.node;
        let mut made = 0;
        while let Some(origin) = &self.nodes[first].origin {
            let is_own = origin.change.patch() == failed.change.patch();
            match &origin.change {
                Move::Add(_) if !is_own => made += 1,
                Move::Remove(_) if is_own && made == 0 => {}
                _ => break,
            }
            changes.push(origin.change.clone());
            first = origin.node;
        }
        if made == 0 {
            return Ok(None);
        }
        changes.reverse();

        let mut contacts = node.contacts.clone();
        for change in &changes {
            match change {
                Move::Add(foothold) => {
                    let Some(free) = foothold.free(context) else {
                        return Ok(None);
                    };
                    let is_last = foothold.patch == failed.change.patch();
                    contacts.retain(|c| c.patch != foothold.patch);
                    contacts.push(free.loaded(!is_last));
                }
                Move::Remove(patch) => {
                    for contact in contacts.iter_mut().filter(|c| c.patch == *patch) {
                        contact.loaded = false;
                    }
                }
            }
        }
        let reference = nominal_posture(context, &contacts, node.along_m(context));
        let problem = context.problem(contacts, &reference, &node.posture.q);
        let config = posture::Config {
            restarts: 0,
            solver: posture::Solver {
                upright: Some(context.upright(&reference)),
                ..self.posture_config.solver
            },
            ..self.posture_config.clone()
        };
        let mut outcome = posture::solve(&problem, &config)?;
        if let (Outcome::Undecided { .. }, Some(guess)) = (&outcome, nearest) {
            let from_there = Problem {
                guess,
                ..problem.clone()
            };
            outcome = posture::solve(&from_there, &config)?;
        }
        if let Some(violation) = outcome.violation() {
            tracing::debug!("nothing anew: {}", violation.describe(&problem));
        }
        let Outcome::Feasible(posture) = outcome else {
            return Ok(None);
        };
        let asked = problem.contacts;
        Ok(
            one_by_one(changes, &asked, Arc::from(posture)).map(|done| Candidate {
                node: first,
                ..done(failed)
            }),
        )
    }

    /// Puts the change that is to follow on one that has become a node on the frontier.
    pub fn follow(&mut self, done: &Candidate, node: usize) {
        let Some([next, rest @ ..]) = done.then.as_deref() else {
            return;
        };
        self.put(Candidate {
            node,
            change: next.clone(),
            then: Some(rest.to_vec()),
            ..done.clone()
        });
    }
}
