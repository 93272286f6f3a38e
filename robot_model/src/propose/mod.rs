//! What a user would otherwise write by hand, found from the robot itself: its limbs, where they may
//! touch the world, and the pairs of links that need no watching.
//!
//! The base is taken to stand upright with x ahead (REP 103) or, where soles tell so, aback, limbs to come in pairs
//! left and right.

mod except;
mod facing;
mod flat;
mod leg_reach;
mod limb;
mod limbs;
mod mirror;
mod palm;
mod patches;
mod rsdf;

pub use crate::load::sampled as drawn;
pub use except::{Excepted, Reason, excepted};
pub use facing::looks_backward;
pub use leg_reach::{Tip, deepest, dexterity, place};
pub use limb::{Limb, LimbKind};
pub use limbs::limbs;
pub use mirror::Mirror;
pub use patches::{Kinds, Proposed, patches};
pub use rsdf::{Surface, surfaces};
