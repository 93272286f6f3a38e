//! From one contact set to a whole-body posture with the forces that hold it, or the reason why
//! there is none.
//!
//! ```text
//!   min   distance from the reference posture + small forces + wanted places of free contacts
//!   s.t.  closure       every contact at its pose, or anywhere in the plane of its surface
//!         inclusion     the patch inside the surface's polygon        [brossette2013] Algorithm 1
//!         equilibrium   Σ f + m g = 0,  Σ (p − c) × f = 0
//!         friction      f inside the pyramid inscribed in the cone
//!         torques       |g(q) − Jᵀ f| ≤ use · τ_max
//!         limits        q inside the joint limits
//!         clearances    d(body, body) ≥ margin, d(body, environment) ≥ margin
//! ```
//!
//! | symbol | module |
//! |---|---|
//! | the problem | [`problem`] |
//! | the variables and their step | `iterate` |
//! | one constraint a file | `constraint` |
//! | the cost | `cost` |
//! | where it starts, and how it comes near its contacts | `starts`, `approach` |
//! | what no posture can mend | `proof` |
//! | attempts, one after the other | `solve` |
//! | the solver, and its QP engines | `sqp`, `qp` |
//! | what comes back | [`outcome`] |
//! | why nothing does | [`explain()`] |

mod approach;
mod config;
mod constraint;
mod cost;
mod error;
mod evaluate;
mod explain;
#[cfg(test)]
mod finite_difference;
mod iterate;
mod least_load;
pub mod outcome;
pub mod problem;
mod proof;
mod qp;
mod rows;
mod solve;
mod sqp;
mod starts;

pub use config::{Config, Engine};
pub use error::Error;
pub use explain::{Explanation, Group, Relaxation, explain};
pub use outcome::{Constraint, ContactState, Margins, Outcome, Posture, Violation};
pub use problem::{BaseGoal, Contact, Environment, Place, Problem};
pub use solve::solve;
