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
//! | how far along the guide path | [`guide`] |
//! | which contact changes could be made, and at what price | `candidate` |
//! | where a patch should touch a face, and the alternatives | `foothold_proposal` |
//! | the posture that a stance would like best | `nominal_posture` |
//! | ways that nothing can hold the robot on | `steepness` |
//! | nodes from solved candidates | `node_construction` |
//! | the tree and its order | [`search`](mod@search) |
//! | which contacts the way can do without | `shorten` |
//! | what is done with a way that reaches the goal | `finalize` |
//! | the motions between its stances | `motions` |
//! | what comes back, and as it is written | [`result`], [`record`] |

mod candidate;
mod config;
mod context;
mod error;
mod finalize;
mod foothold_proposal;
mod goal;
pub mod guide;
mod motions;
mod node;
mod node_construction;
mod nominal_posture;
pub mod record;
pub mod request;
pub mod result;
pub mod search;
mod shorten;
mod steepness;

pub use config::Config;
pub use error::Error;
pub use guide::Guide;
pub use request::{Goal, Request, Start};
pub use result::{Blocked, PathStance, Progress, SearchResult, Stage, Status};
pub use search::search;
