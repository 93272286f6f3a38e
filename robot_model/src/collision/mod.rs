//! Collision shapes of a robot, and signed distances to itself and to the world.
//!
//! A distance d with unit normal n (from b toward a) and witness points p_a, p_b changes as
//!
//!   ḋ = nᵀ (v_pa − v_pb)        d < 0 on overlap: the least translation that would part them
//!
//! parry3d (GJK and EPA) computes what has no closed form; only `parry.rs` and
//! `index.rs` know it.

mod ascent;
pub(crate) mod ball;
mod broad;
mod closest;
mod geometry;
mod hull;
mod model;
mod narrow;
mod overlap;
mod parry;
mod quickhull;
mod segment;
mod world;

pub use closest::{Closest, gap_m};
pub use geometry::ShapeGeometry;
pub use hull::Hull;
pub use model::{BodyShape, CollidingPair, CollisionModel, Other, Proximity, Shape};
pub use narrow::closest;
pub use parry::BoxIndex;
pub use quickhull::HullError;
pub use world::{Obstacle, World};
