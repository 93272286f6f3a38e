//! Contact sets with known answers, for the robots that ship.
#![allow(clippy::unwrap_used, non_snake_case)]

mod balls;
mod soles;
mod world;
