//! Contact sets with known answers, for the robots that ship.
#![allow(clippy::unwrap_used)]

mod balls;
mod shanks;
mod soles;
mod world;
