//! What ends a face at an edge of its region: what the sensor saw beyond it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What ends a face at an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EdgeKind {
    /// The face ends: beyond it is something farther away.
    #[default]
    Real,
    /// Another face rises from it: nothing falls there, and what keeps clear of that face keeps clear of the edge.
    Fold,
    /// Something nearer hides how the face goes on.
    Occluded,
    /// The border of what the sensor measured cuts the face.
    FieldOfView,
    /// Nothing was measured beyond it.
    Unknown,
}

impl EdgeKind {
    /// All kinds, each at its own number.
    const ALL: [Self; 5] = [
        Self::Real,
        Self::Fold,
        Self::Occluded,
        Self::FieldOfView,
        Self::Unknown,
    ];

    /// The kind that an edge has in most of its places; of equals the first in the order above, and
    /// [`Self::Real`] of none.
    pub fn most(places: impl Iterator<Item = Self>) -> Self {
        let mut counts = [0_usize; Self::ALL.len()];
        places.for_each(|kind| counts[kind as usize] += 1);
        let more = |a: Self, b: Self| {
            if counts[b as usize] > counts[a as usize] {
                b
            } else {
                a
            }
        };
        Self::ALL.into_iter().fold(Self::Real, more)
    }
}
