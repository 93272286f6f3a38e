//! Best-first search over contact sets: from a start posture to the goal, one contact at a time.
//!
//! ```text
//! frontier of candidates ── best ──▶ posture problem ── feasible ──▶ node ──▶ its candidates
//!        ▲                                │ not                                    │
//!        └────────────────────────────────┴── why: kept for the report ◀──────────┘
//! ```
//!
//! | question | module |
//! |---|---|
//! | what is asked | [`request`] |
//! | what follows from it once | `context` |
//! | which places to pass, and the base's way through them | [`guide`], `route` |
//! | which contact changes could be made, and at what price | `candidate`, `change` |
//! | how many follow, as estimated and at least | `estimate` |
//! | the way of the base round what it cannot walk over | `way`, over `shortest`, `lattice` and `ground` |
//! | where there is none, in words | `gap` |
//! | how far patches reach, by lengths alone | `reach` |
//! | where on a face a patch may land | `landing` |
//! | where it should land, and where else | `foothold_proposal`, `foothold` |
//! | the posture that a stance would like best | `nominal_posture` |
//! | ways that nothing can hold the robot on, goals that lengths exclude | `steepness`, `out_of_reach` |
//! | where the search comes no nearer | `staleness` |
//! | which contacts of hands would help a foot | `support` |
//! | nodes from solved candidates | `node_construction` |
//! | what waits, in order | `frontier` |
//! | the tree and its order | `search` |
//! | other ways of the base where the first leads to no plan soon | [`portfolio`] |
//! | which contacts and steps the way can do without | `shorten` |
//! | what is done with a way that reaches the goal, and when the search ends | `finalize` |
//! | what would let through what blocks the way | `remedy` |
//! | the motions between stances, and what becomes of edges without one | `motions`, `settle` |
//! | a search that goes on among more bodies than it began with | [`regrow`], `tree` |
//! | why: the tree, what was refused, what else there was | `trace` |
//! | what comes back, and as it is written | [`result`], [`record`] |
//!
//! `examples/three_boxes.rs` plans over three boxes. Settings that make no sense are refused by name:
//!
//! ```
//! use planner::{Config, Guide};
//!
//! let short = Config { stride_m: 0.3, ..Config::default() };
//! assert!(short.validate().is_ok());
//! let wrong = Config { stride_m: -0.3, ..Config::default() };
//! assert!(wrong.validate().unwrap_err().to_string().contains("planner.stride_m = -0.3"));
//! // A guide is a polyline of two places or more.
//! assert!(Guide::new(vec![[0.0, 0.0, 0.7].into()]).is_err());
//! ```
#![forbid(unsafe_code)]

mod candidate;
mod change;
mod config;
mod context;
mod crouch;
mod error;
mod estimate;
mod finalize;
mod foothold;
mod foothold_proposal;
mod footing;
mod frontier;
mod gap;
mod goal;
mod goal_stance;
mod ground;
pub mod guide;
mod landing;
mod lattice;
mod motions;
mod node;
mod node_construction;
mod nominal_posture;
mod out_of_reach;
mod place_anew;
pub mod portfolio;
mod reach;
pub mod record;
pub mod regrow;
mod remedy;
pub mod request;
mod reserve;
pub mod result;
mod room;
mod route;
mod search;
mod settle;
mod shorten;
mod shortest;
mod sole_room;
mod staleness;
mod steepness;
mod support;
mod trace;
mod tree;
mod way;

pub use config::Config;
pub use error::Error;
pub use guide::Guide;
pub use portfolio::{grow, search};
pub use regrow::search_on;
pub use remedy::TOLD;
pub use request::{Goal, Request, Start};
pub use result::{Blocked, PathStance, Progress, SearchResult, Stage, Status};
pub use tree::Tree;
