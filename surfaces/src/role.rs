//! Which face may carry which patch of the robot.
//!
//! A patch has roles (`foot`, `hand`); a role has a filter on the face's tilt, height, facing
//! and size. With u = W's z axis, opposite to gravity, the tilt of a face is acos(z_F · u):
//! 0 for a floor, π/2 for a wall, π for a ceiling.

mod filter;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Error;
pub use filter::{Filter, Rejection};

/// The filter of each role, by name.
///
/// In a file a table a role (`[foot]`, `[hand]`, or any other name): what a table of a known role
/// does not set keeps its default, and a role of another name asks for nothing by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(from = "BTreeMap<String, Filter>", into = "BTreeMap<String, Filter>")]
pub struct Config {
    roles: BTreeMap<String, Filter>,
}

impl Default for Config {
    /// `foot`: tilted by at most 0.6 rad, room for a circle of 3 cm; `hand`: not a ceiling
    /// (tilted by at most 1.7 rad), between 0.3 and 1.7 m high, room for a circle of 2 cm.
    fn default() -> Self {
        let foot = Filter {
            radius_min_m: Some(0.03),
            ..Filter::walkable(0.6)
        };
        let hand = Filter {
            tilt_max_rad: Some(1.7),
            height_min_m: Some(0.3),
            height_max_m: Some(1.7),
            radius_min_m: Some(0.02),
            ..Filter::default()
        };
        Self {
            roles: [("foot".into(), foot), ("hand".into(), hand)].into(),
        }
    }
}

impl From<BTreeMap<String, Filter>> for Config {
    fn from(given: BTreeMap<String, Filter>) -> Self {
        let mut config = Self::default();
        for (role, filter) in given {
            let known = config.roles.remove(&role).unwrap_or_default();
            config.roles.insert(role, filter.or(known));
        }
        config
    }
}

impl From<Config> for BTreeMap<String, Filter> {
    fn from(config: Config) -> Self {
        config.roles
    }
}

impl Config {
    /// The filter of a role.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the roles that exist.
    pub fn filter(&self, role: &str) -> Result<&Filter, Error> {
        self.roles.get(role).ok_or_else(|| Error::Unknown {
            what: "role",
            name: role.into(),
            candidates: self.roles.keys().cloned().collect(),
        })
    }
}

#[cfg(test)]
mod tests;
