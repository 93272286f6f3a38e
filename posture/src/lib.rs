//! From one contact set to a whole-body posture with the forces that hold it, or the reason why
//! there is none.
//!
//! ```text
//!   min   distance from the reference posture + small forces + wanted places of free contacts
//!   s.t.  closure       every contact at its pose, or anywhere in the plane of its surface
//!         inclusion     the patch inside the surface's polygon        [brossette2013] Algorithm 1
//!         equilibrium   Σ f + m g = 0,  Σ (p − c) × f = 0
//!         friction      f inside a pyramid inscribed in the cone, its edges along the load
//!         torques       |g(q) − Jᵀ f| ≤ use · τ_max
//!         limits        q inside the joint limits
//!         clearances    d(body, body) ≥ margin, d(body, environment) ≥ margin
//! ```
//!
//! | symbol | module |
//! |---|---|
//! | the problem | [`problem`]: [`contact`]s in an [`environment`] |
//! | postures to begin with | [`stand`] |
//! | the variables and their step | `layout`, `iterate`, `jacobian` |
//! | one constraint a file | `constraint` |
//! | the cost | `cost` |
//! | where it starts, and how it comes near its contacts | `seeding`, `contact_ik` |
//! | proofs that no posture exists | `proof` |
//! | attempts, one after the other | `solve` |
//! | the solver, and its QP engines | `sqp`, `qp` |
//! | what comes back | [`outcome`] |
//! | why nothing does | [`explain()`] |
//!
//! ```
//! use posture::{Config, Contact, Environment, Problem, stand};
//! use surfaces::{Face, Terrain};
//!
//! let robot = scenes::robot("hrp2").expect("it ships");
//! let floor = Face::rectangle("floor", nalgebra::Isometry3::identity(), [1.0, 1.0])?;
//! // Bodies 3 cm deep behind faces whose edges are known exactly.
//! let environment = Environment::new(Terrain::new(vec![floor], vec![])?, 0.03, 0.0)?;
//!
//! let (floor, foot) = (environment.face("floor")?, robot.patch_id("left_foot")?);
//! let contacts = vec![Contact::anywhere_on(&environment, floor, &robot, foot)?];
//! let start = stand::on_level_ground(&robot, &robot.resting(), &[foot]);
//! let problem = Problem::new(&robot, &environment, contacts, &start);
//! let outcome = posture::solve(&problem, &Config::default())?;
//! let posture = outcome.posture().expect("it stands on one foot");
//! assert!(posture.margins.joint_rad > 0.029);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod config;
mod constraint;
pub mod contact;
mod contact_ik;
mod cost;
pub mod environment;
mod error;
mod evaluate;
mod explain;
#[cfg(test)]
mod finite_difference;
mod iterate;
mod jacobian;
mod layout;
mod least_load;
pub mod outcome;
pub mod problem;
mod proof;
mod qp;
mod rolling;
mod rows;
mod seeding;
mod solve;
mod sqp;
pub mod stand;

pub use config::{Config, Engine, Solver, Upright};
pub use contact::{Area, Contact, Freedom};
pub use environment::{Environment, FaceIndex, PlacedShape};
pub use error::Error;
pub use explain::{Explanation, Group, Relaxation, explain, remedy};
pub use layout::{ball_inset_m, force_points, patch_inset_m};
pub use outcome::{Constraint, ContactState, Outcome, Posture, Violation};
pub use problem::{BaseGoal, JointGoal, Problem};
pub use proof::refutation;
pub use rolling::Rolling;
pub use solve::solve;
