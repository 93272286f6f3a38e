//! What a robot may touch: connected plane faces of the world.
//!
//! A face is a frame F in the world W and a region F of its plane z_F = 0, with z_F the normal that
//! points out of the body. A patch of the robot with the frame C and the vertices c_k touches it where
//!
//!   z_C = z_F,   p_FC = (t, 0),   t + R(ψ) c_k ∈ { p ∈ F : |p − e| ≥ inset_e for every edge e }.
//!
//! The set on the right need not be convex: a solver is held to a large convex part of it around the
//! place that is wanted.
//!
//! | symbol | meaning | where |
//! |---|---|---|
//! | F, X_WF, Σ | a face: its region with holes, its frame, what is known of both | [`Face`], [`Region`], [`Edge`] |
//! | inset_e | what an edge may be nearer than it seems, from Σ and its view | [`Face::edge_insets_m`] |
//! | F ⊖ insets | the part that is surely the face's, and a convex part of that | [`Face::inset_region`], [`outline::Outline::convex_around`] |
//! | ∪ P_i ⊂ F | a region as few large convex pieces | [`cover`] |
//! | | what was seen and lies on no face | [`mod@loose`] |
//! | F ∪ strip | treads that go on under the steps that hide them | [`continue_under_steps`] |
//! | F ⊕ edge | convex bodies that surely cover what is behind it | [`Face::bodies_W`], [`fill_unseen`] |
//! | σ² = gᵀ Σ g | a plane's covariance at a point, in another frame | [`covariance`] |
//! | Σ Hᵀ S⁻¹ h | what "it is level" adds to a plane | [`level`] |
//! | (Σ Σᵢ⁻¹)⁻¹, ⋃ Fᵢ | faces of several views as one terrain, and what they looked through | [`mod@fuse`], [`free_space`] |
//! | acos(z_F · u) | which face serves a foot, a hand | [`role`] |
//! | n_l · p ≤ b_l | convex polygons: checks, hull, clip, inset, simplification | [`polygon`] |
//! | A ∪ B, A \\ B | regions of any shape, joined and cut | [`outline`] |
//! | | from a mesh of the environment to faces and bodies | [`mesh`] |
//! | | all of them with the bodies to avoid, and their file | [`Terrain`], [`Obstacle`] |
//!
//! Everything is geometry in metres and radians: no sensors, no robots, no files.
//!
//! ```
//! use nalgebra::{Isometry3, Point2, Vector2};
//! use surfaces::{Face, Region, Terrain};
//!
//! // An L of two planks, 0.2 m wide, half a metre above the ground.
//! let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.2], [0.2, 0.2], [0.2, 1.0], [0.0, 1.0]];
//! let region = Region::new([corners.map(Point2::from).to_vec()])?;
//! let planks = Face::new("planks", Isometry3::translation(0.0, 0.0, 0.5), region);
//!
//! // Where a foot may stand that is to be 2 cm from every edge, around a place on the longer plank.
//! let room = planks.inset_region(2.0, 0.02);
//! let part = room.convex_around(&Point2::new(0.7, 0.1), &Vector2::x());
//! assert!(part.is_some_and(|part| (part.area() - 0.96 * 0.16).abs() < 1e-6));
//! print!("{}", Terrain::new(vec![planks], vec![])?.to_json()?);
//! # Ok::<(), surfaces::Error>(())
//! ```
#![forbid(unsafe_code)]

mod bounds;
mod config;
mod conservative_bodies;
mod convex_around;
pub mod covariance;
pub mod cover;
mod edge;
mod error;
mod face;
pub mod free_space;
pub mod fuse;
pub mod level;
mod looked_through;
pub mod loose;
pub mod mesh;
mod nearest;
mod obstacle;
pub mod outline;
pub mod polygon;
mod pose;
mod region;
pub mod role;
mod terrain;
mod under_steps;
mod unseen;

pub use config::{
    BodyConfig, Config, FACE_AREA_MIN_M2, FACE_WIDTH_MIN_M, UNSEEN_DEPTH_M, WALL_RAD, WORLD_M,
    beyond_world,
};
pub use edge::EdgeKind;
pub use error::Error;
pub use face::{EdgeView, Face, FaceId, Fit, Source};
pub use looked_through::LookedThrough;
pub use mesh::TriangleMesh;
pub use obstacle::Obstacle;
pub use polygon::{ConvexPolygon, HalfPlane};
pub use pose::Pose;
pub use region::{Edge, Region, Ring};
pub use terrain::{TERRAIN_FORMAT, Terrain};
pub use under_steps::{Continued, continue_under_steps};
pub use unseen::fill_unseen;
