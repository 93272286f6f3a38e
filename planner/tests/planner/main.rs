//! The whole search on exactly known worlds, with the humanoid that ships.
#![allow(clippy::unwrap_used)]

mod ground;
mod stairs;
mod support;
