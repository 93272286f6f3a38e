//! Whole-body motion between the stances of a plan: quasi-static paths, and the fastest time along them.
//!
//! ```text
//! two stances ─▶ what stays closed, leaves, lands ─▶ paths through the air ─▶ the swept link alone
//!                                                                                   │ free
//!   time law ◀─ every sample checked ◀─ C² spline ◀─ body at the knots ◀──────────────┘
//!                  │ not                                              ▲
//!                  └────────────── a waypoint's posture ──────────────┘      then the next path
//! ```
//!
//! | question | module |
//! |---|---|
//! | what is written | [`plan::Motion`] |
//! | the motion at any time, with its rates | [`interpolation`] |
//! | what is asked | [`problem`] |
//! | which contacts stay closed, leave and land | [`segment`](mod@segment) |
//! | whether a patch can leave its place or come to it | `raised` |
//! | the path of a patch through the air | `swing_path`; how near it may come to things: `airborne`, `sweep` |
//! | forces, and the centre of mass | `blend` |
//! | configurations | `projection` (with `equations`, `inequalities`, `near`) at knots, joined by `route` |
//! | time | `pace`, by [`time_law`] |
//! | no stop at a stance | `passage` |
//! | what the contacts bear and the joints exert in motion | `load_shares`, `inverse_dynamics` |
//! | steps from rest to rest | [`time_scaling`] |
//! | is every sample right | `sampling`, `statics`, `clearance` |
//! | what to do where it is not | `generate` |
//! | why there is no motion | [`failure`] |
//! | curves that are twice continuously differentiable | [`spline`] |
//!
//! `examples/one_step.rs` moves a foot onto a step. A motion is sampled; between the samples it is a
//! twice continuously differentiable curve:
//!
//! ```
//! use motion::spline::{Ends, Order, Spline};
//!
//! // Two coordinates at three knots 0.1 s apart, at rest at both ends.
//! let curve = Spline::new(2, 0.1, vec![0.0, 1.0, 0.2, 1.1, 0.4, 1.0], Ends::Rest);
//! let mut rate = [0.0; 2];
//! curve.evaluate(0.1, Order::First, &mut rate);
//! assert!(rate[0] > 2.0 && rate[1].abs() < 1e-9);
//! ```
#![forbid(unsafe_code)]

mod airborne;
mod assemble;
mod blend;
mod clearance;
mod config;
mod dense;
mod equations;
mod error;
mod evening;
pub mod failure;
mod generate;
mod inequalities;
pub mod interpolation;
mod inverse_dynamics;
mod keeps_off;
mod load_shares;
mod near;
mod pace;
mod passage;
pub mod problem;
mod projection;
mod raised;
mod route;
mod sampling;
pub mod segment;
pub mod spline;
mod statics;
mod sweep;
mod swing_path;
pub mod time_law;
pub mod time_scaling;

pub use assemble::{assemble, limits};
pub use config::Config;
pub use error::Error;
pub use failure::{Failure, Reason};
pub use interpolation::{Instant, Interpolation};
pub use keeps_off::keeps_off;
pub use posture::force_points;
pub use problem::{MotionContext, StanceRef};
pub use raised::raised;
pub use segment::{Segment, segment};
