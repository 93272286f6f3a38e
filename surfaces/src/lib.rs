//! What a contactable surface is.

pub mod covariance;
pub mod cover;
mod error;
pub mod inclusion;
mod obstacle;
pub mod polygon;
pub mod pose;
pub mod role;
mod set;
mod surface;
pub mod thin_body;

pub use error::Error;
pub use obstacle::Obstacle;
pub use polygon::{ConvexPolygon, HalfPlane};
pub use set::{SURFACES_FORMAT, SurfaceSet};
pub use surface::{Source, Surface};
pub use thin_body::ThinBody;
