//! Settings of the search.

use robot_model::ContactPatch;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Budgets and prices of the best-first search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Largest number of contact sets in the tree on a way of up to ten strides; on longer ones in
    /// proportion.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub nodes_max: usize,
    /// Largest number of posture problems solved, in the same way.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub candidates_max: usize,
    /// How far a foot is put ahead of the others along the guide path, m; at most 0.57 of the legs' length,
    /// and half the distance of feet that follow each other, so that legs one behind the other do not meet.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub stride_m: f64,
    /// Weight of the estimated number of contacts to the goal against those made: 1 for few
    /// contacts, more for a quick answer (weighted A*).
    #[schemars(range(min = 1.0, max = 100.0))]
    pub heuristic_weight: f64,
    /// After the first plan, nodes that are spent on shorter ones.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub improve: usize,
    /// Extra price of touching with a patch that is not among the start's, in contacts.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub extra_contact_price: f64,
    /// Price of a metre beside the guide path, of a foot's place or an extra contact's, in contacts.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub lateral_deviation_price_per_m: f64,
    /// Largest tilt of the base from upright (of a robot on three feet or more: from the mean of
    /// what it stands on), in stances and between them, rad; six tenths of that at the goal.
    #[schemars(range(min = 0.01, max = 1.57))]
    pub tilt_max_rad: f64,
    /// Patches that are not used, by name or role.
    pub exclude: Vec<String>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            nodes_max: 400,
            candidates_max: 4000,
            stride_m: 0.40,
            heuristic_weight: 2.0,
            improve: 0,
            extra_contact_price: 2.0,
            lateral_deviation_price_per_m: 2.0,
            tilt_max_rad: 0.5,
            exclude: Vec::new(),
        }
    }
}

impl Config {
    /// Whether a patch is not to be used.
    pub fn excludes(&self, patch: &ContactPatch) -> bool {
        let mut named = self.exclude.iter();
        named.any(|name| &patch.name == name || patch.has_role(name))
    }

    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`crate::Error::Config`].
    pub fn validate(&self) -> Result<(), crate::Error> {
        for (field, value, zero_allowed) in [
            ("nodes_max", self.nodes_max as f64, false),
            ("candidates_max", self.candidates_max as f64, false),
            ("stride_m", self.stride_m, false),
            ("heuristic_weight", self.heuristic_weight, false),
            ("tilt_max_rad", self.tilt_max_rad, false),
            ("extra_contact_price", self.extra_contact_price, true),
            (
                "lateral_deviation_price_per_m",
                self.lateral_deviation_price_per_m,
                true,
            ),
        ] {
            let fine = value.is_finite() && (value > 0.0 || zero_allowed && value == 0.0);
            let fine = fine && (field != "tilt_max_rad" || value < std::f64::consts::FRAC_PI_2);
            if !fine {
                return Err(crate::Error::Config {
                    field,
                    value,
                    allowed: if zero_allowed { "≥ 0" } else { "> 0" },
                });
            }
        }
        Ok(())
    }
}
