//! Quasi-static whole-body motion between the stances of a plan.
//!
//! ```text
//! two stances ─▶ what stays closed, leaves, lands ─▶ ways through the air ─▶ the swept link alone
//!                                                                                   │ free
//!   samples ◀─ every one checked ◀─ time scaling ◀─ C² spline ◀─ body at the knots ◀┘
//!                  │ not                                              ▲
//!                  └────────────── a waypoint's posture ──────────────┘      then the next way
//! ```
//!
//! | question | module |
//! |---|---|
//! | what is written | [`record`] |
//! | the motion at any time, with its rates | [`interpolation`] |
//! | what is asked | [`problem`] |
//! | which contacts stay closed, leave and land | [`segment`](mod@segment) |
//! | whether a patch can leave its place or come to it | `raised` |
//! | the way of a patch through the air | `way`; how near it may come to things: `airborne`, `sweep` |
//! | forces, and the centre of mass | `blend` |
//! | configurations | `projection` (with `inequalities`, `near`) at knots, joined by `route` |
//! | time | [`time_scaling`], `track` |
//! | is every sample right | `track`, `statics`, `clearance` |
//! | what to do where it is not | `generate` |
//! | why there is no motion | [`failure`] |
//! | where the forces act | [`force_points`](mod@force_points) |
//! | curves that are twice continuously differentiable | [`spline`] |

mod airborne;
mod assemble;
mod blend;
mod clearance;
mod config;
mod dense;
mod error;
pub mod failure;
pub mod force_points;
mod generate;
mod inequalities;
pub mod interpolation;
mod near;
pub mod problem;
mod projection;
mod raised;
pub mod record;
mod route;
pub mod segment;
pub mod spline;
mod statics;
mod sweep;
pub mod time_scaling;
mod track;
mod way;

pub use assemble::assemble;
pub use config::Config;
pub use error::Error;
pub use failure::{Failure, Reason};
pub use force_points::force_points;
pub use interpolation::{Instant, Interpolation};
pub use problem::{End, Setting};
pub use raised::raised;
pub use record::{MOTION_FORMAT, Motion, Phase, PhaseContact, PhaseKind, Pose, Sample};
pub use segment::{Segment, segment};
