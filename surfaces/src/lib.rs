//! What a contactable surface is.
//!
//! A surface is a frame S in the world W and a convex polygon in its plane z_S = 0, with z_S the
//! normal that points out of the body:
//!
//!   S = { X_WS (x, y, 0) : n_l · (x, y) ≤ b_l, l = 0 … m−1 }.
//!
//! A patch of the robot with the frame C and the vertices c_k touches it when
//!
//!   z_C = z_S,   p_SC = (t, 0),   n_l · (t + R(ψ) c_k) ≤ b_l − inset   for all k and l.
//!
//! | symbol | meaning | where |
//! |---|---|---|
//! | X_WS, inset, Σ | a surface, what is known of it, and its JSON | [`Surface`], [`pose`] |
//! | n_l, b_l | convex polygons: checks, hull, clip, inset, simplification | [`polygon`] |
//! | n_l · p_k − b_l | the patch inside the surface, its derivatives, where it fits | [`inclusion`] |
//! | σ² = gᵀ Σ g | from a plane's covariance to an inset | [`covariance`] |
//! | Σ Hᵀ S⁻¹ h | what "it is level" adds to a plane | [`level`] |
//! | p − t z_S | the body behind a surface and how deep it can be | [`thin_body`] |
//! | F ⊕ disc | the bodies that surely cover a scanned face | [`rim`] |
//! | max_l g_kl | what ends a face at each edge: real, occluded, field of view | [`edge`] |
//! | acos(z_S · u) | which surface serves a foot, a hand | [`role`] |
//! | ∪ P_i ⊂ F | a face with holes as few large convex pieces | [`cover`] |
//! | A ∪ B, A \\ B | regions of any shape, joined and cut | [`outline`] |
//! | (Σ Σᵢ⁻¹)⁻¹, ⋃ Fᵢ | faces of several views as one set | [`merge`] |
//! | | from a mesh of the environment to surfaces and bodies | [`mesh`] |
//! | | the set of them, its file, its bodies | [`SurfaceSet`], [`Obstacle`] |
//!
//! Everything is geometry in metres and radians: no sensors, no robots, no files.

mod config;
pub mod covariance;
pub mod cover;
pub mod edge;
mod error;
pub mod inclusion;
pub mod level;
pub mod merge;
pub mod mesh;
mod obstacle;
pub mod outline;
pub mod polygon;
pub mod pose;
pub mod rim;
pub mod role;
mod set;
mod surface;
pub mod thin_body;

pub use config::Config;
pub use edge::EdgeKind;
pub use error::Error;
pub use mesh::TriangleMesh;
pub use obstacle::Obstacle;
pub use polygon::{ConvexPolygon, HalfPlane};
pub use set::{SURFACES_FORMAT, SurfaceSet};
pub use surface::{Source, Surface};
pub use thin_body::ThinBody;
