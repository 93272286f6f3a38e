//! Quasi-static whole-body motion between the stances of a plan.
//!
//! | question | module |
//! |---|---|
//! | what is written | [`record`] |
//! | where the forces act | [`force_points`](mod@force_points) |
//! | the motion at any time, with its rates | [`interpolation`] |
//! | curves that are twice continuously differentiable | [`spline`] |

mod error;
pub mod force_points;
pub mod interpolation;
pub mod record;
pub mod spline;

pub use error::Error;
pub use force_points::force_points;
pub use interpolation::{Instant, Interpolation};
pub use record::{MOTION_FORMAT, Motion, Phase, PhaseContact, PhaseKind, Pose, Sample};
