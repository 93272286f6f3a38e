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
//! | the way of the base round what it cannot walk over | `way`, over `lattice` and `ground` |
//! | where on a face a patch may land | `landing` |
//! | where it should land, and where else | `foothold_proposal` |
//! | the posture that a stance would like best | `nominal_posture` |
//! | ways that nothing can hold the robot on, goals that lengths exclude | `steepness`, `out_of_reach` |
//! | where the search comes no nearer | `staleness` |
//! | nodes from solved candidates | `node_construction` |
//! | the tree and its order | [`search`](mod@search) |
//! | which contacts the way can do without | `shorten` |
//! | what is done with a way that reaches the goal | `finalize` |
//! | the motions between its stances | `motions` |
//! | what comes back, and as it is written | [`result`], [`record`] |

mod candidate;
mod change;
mod config;
mod context;
mod error;
mod finalize;
mod foothold_proposal;
mod goal;
mod ground;
pub mod guide;
mod landing;
mod lattice;
mod motions;
mod node;
mod node_construction;
mod nominal_posture;
mod out_of_reach;
pub mod record;
pub mod request;
mod reserve;
pub mod result;
mod route;
pub mod search;
mod shorten;
mod staleness;
mod steepness;
mod way;

pub use config::Config;
pub use error::Error;
pub use guide::Guide;
pub use request::{Goal, Request, Start};
pub use result::{Blocked, PathStance, Progress, SearchResult, Stage, Status};
pub use search::search;
