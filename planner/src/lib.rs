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
//! | how far along the guide path | [`guide`] |
//! | which contact changes could be made, and at what price | `candidate` |
//! | where a patch would like to touch a surface, and beside that | `wish` |
//! | the posture that a stance would like best | `comfort` |
//! | ways that nothing can hold the robot on | `steepness` |
//! | the tree and its order | [`search`](mod@search) |
//! | which contacts the way can do without | `shorten` |
//! | what is done with a way that reaches the goal | `conclude` |
//! | the motions between its stances | `motions` |
//! | what is written | [`plan`], [`record`] |

pub mod answer;
mod candidate;
mod comfort;
mod conclude;
mod config;
mod error;
mod goal;
mod grow;
pub mod guide;
mod motions;
mod node;
pub mod plan;
pub mod record;
pub mod request;
pub mod search;
mod shorten;
mod steepness;
mod wish;

pub use answer::{Answer, Blocked, PathStance, Progress, Stage, Status};
pub use config::Config;
pub use error::Error;
pub use guide::Guide;
pub use plan::Plan;
pub use request::{Goal, Request, Start};
pub use search::search;
