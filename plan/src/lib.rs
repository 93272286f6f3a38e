//! What a plan is: contacts, stances, the plan over them and the motion between them.
//!
//! Types and their JSON files only. The crates that solve (`posture`, `motion`, `planner`), the one
//! that checks (`verify`) and those that show, export or simulate meet here and nowhere else.
//!
//! | type | file |
//! |---|---|
//! | [`Plan`] | `plan.json`: where from, which robot, which faces, the [stances](Stance) |
//! | [`Trace`] | `search.json`: the tree of the search, what it was refused and why it chose |
//! | [`Motion`] | `motion.json`: [phases](Phase) and [samples](Sample) of the whole body in time |
//! | [`Refutation`] | in `posture --explain`'s results: contacts without a posture, and the proof |
//!
//! ```
//! let text = r#"{ "patch": "left_foot", "link": "LLEG_LINK6", "face": "floor", "friction": 0.5, "loaded": true,
//!     "X_WC": { "p": [0.0, 0.1, 0.0], "quat_xyzw": [0.0, 0.0, 0.0, 1.0] } }"#;
//! let contact: plan::Contact = serde_json::from_str(text)?;
//! assert_eq!(contact.face.as_str(), "floor");
//! # Ok::<(), serde_json::Error>(())
//! ```
#![forbid(unsafe_code)]

mod contact;
mod error;
mod motion;
mod plan;
mod refutation;
mod stance;
mod trace;

pub use contact::Contact;
pub use error::Error;
pub use motion::{Limits, MOTION_FORMAT, Motion, Phase, PhaseKind, Sample};
pub use plan::{
    GoalContact, GoalJoints, GoalRecord, Input, MotionFile, PLAN_FORMAT, Plan, Program,
    RequiredMargins, RobotSummary, SearchSummary, Unsolved,
};
pub use refutation::{ContactPlace, Multipliers, Near, PlaceFreedom, Proof, Refutation};
pub use stance::{Change, Margins, Stance};
pub use surfaces::Pose;
pub use trace::{Alternative, Barrier, Choice, Refusal, Trace, TracedNode};
