//! Settings of the search.

use serde::{Deserialize, Serialize};

/// Budgets and weights of the best-first search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Largest number of contact sets in the tree.
    pub nodes_max: usize,
    /// Largest number of posture problems solved.
    pub candidates_max: usize,
    /// How far a foot is put ahead of the others along the guide path, m; at most half the distance
    /// of feet that follow each other, so that legs one behind the other do not meet.
    pub stride_m: f64,
    /// Weight of the estimated number of contacts to the goal against those made: 1 for few
    /// contacts, more for a quick answer.
    pub greed: f64,
    /// Extra price of touching with a patch that is not among the start's, in contacts.
    pub extra_contact_price: f64,
    /// Price of a metre beside the guide path, of a foot's place or an extra contact's, in contacts.
    pub aside_price_per_m: f64,
    /// Attempts from other starts at a child whose posture was not found from its parent's, in
    /// place of `posture.restarts`; they wait their turn on the frontier.
    pub posture_restarts: usize,
    /// Price of such a second try, in contacts.
    pub again_price: f64,
    /// How near to comfort the postures of the tree are brought, in place of
    /// `posture.optimality`: what is left to gain is carried on to the children.
    pub posture_optimality: f64,
    /// Contacts of one patch on one face nearer than this count as the same, m; places beside one that
    /// no motion leads to are this far from it.
    pub same_place_m: f64,
    /// Whether a foot that has left its place lands before any other contact changes: nothing else
    /// is done on fewer feet than must be.
    pub land_first: bool,
    /// Patches that are not used, by name or role.
    pub exclude: Vec<String>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            nodes_max: 400,
            candidates_max: 4000,
            stride_m: 0.40,
            greed: 2.0,
            extra_contact_price: 2.0,
            aside_price_per_m: 2.0,
            posture_restarts: 1,
            again_price: 3.0,
            posture_optimality: 5e-3,
            same_place_m: 0.06,
            land_first: true,
            exclude: Vec::new(),
        }
    }
}

impl Config {
    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`crate::Error::Config`].
    pub fn validate(&self) -> Result<(), crate::Error> {
        for (field, value) in [
            ("stride_m", self.stride_m),
            ("greed", self.greed),
            ("same_place_m", self.same_place_m),
            ("posture_optimality", self.posture_optimality),
            ("nodes_max", self.nodes_max as f64),
            ("candidates_max", self.candidates_max as f64),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed: "> 0",
                });
            }
        }
        for (field, value) in [
            ("again_price", self.again_price),
            ("extra_contact_price", self.extra_contact_price),
            ("aside_price_per_m", self.aside_price_per_m),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed: "≥ 0",
                });
            }
        }
        Ok(())
    }
}
