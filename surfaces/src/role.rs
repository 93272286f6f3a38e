//! Which face may carry which patch of the robot.
//!
//! A patch has roles (`foot`, `hand`); a role has a filter on the face's tilt, height, facing
//! and size. With u = W's z axis, opposite to gravity, the tilt of a face is acos(z_F · u):
//! 0 for a floor, π/2 for a wall, π for a ceiling.

mod filter;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Error, Face};
pub use filter::{Filter, Rejection};

/// The role of what a robot walks on.
const FOOT: &str = "foot";
/// The ground where no face serves feet: W's level, m.
const LEVEL_M: [f64; 2] = [0.0; 2];

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
    /// (tilted by at most 1.7 rad), 0.3 m over the lowest ground for feet to 1.7 m over the highest, room for a circle
    /// of 2 cm.
    fn default() -> Self {
        let foot = Filter {
            radius_min_m: Some(0.03),
            ..Filter::walkable(0.6)
        };
        let hand = Filter {
            tilt_max_rad: Some(1.7),
            over_ground_min_m: Some(0.3),
            over_ground_max_m: Some(1.7),
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
    /// The lowest and the highest place of the ground for feet, m in W: of all faces that serve the role `foot`, by
    /// their lists or by the filter; W's level where there are none.
    pub fn ground_m<'f>(
        &self,
        faces: impl IntoIterator<Item = &'f Face>,
        k_sigma: f64,
    ) -> [f64; 2] {
        let foot = self.roles.get(FOOT).cloned().unwrap_or_default();
        let serves = |face: &&Face| match &face.roles {
            Some(listed) => listed.iter().any(|role| role == FOOT),
            None => foot.serves(face, k_sigma, LEVEL_M).is_ok(),
        };
        let faces = faces.into_iter().filter(serves);
        let heights = faces.map(|face| filter::heights_m(&face.vertices_W()));
        let range = heights.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        range.unwrap_or(LEVEL_M)
    }

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
