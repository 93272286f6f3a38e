//! What a contactable surface is.

mod error;
mod obstacle;
pub mod polygon;
pub mod pose;
mod set;
mod surface;
pub mod thin_body;

pub use error::Error;
pub use obstacle::Obstacle;
pub use polygon::{ConvexPolygon, HalfPlane};
pub use set::SurfaceSet;
pub use surface::{Source, Surface};
pub use thin_body::ThinBody;
