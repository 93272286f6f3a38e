//! What several tests need: the program, plans made once, robots and ways to break a plan.

pub mod biped;
pub mod boxes;
pub mod chromium;
pub mod controller;
pub mod fixture;
pub mod mutations;
pub mod page;
pub mod program;
pub mod record;
pub mod shipped;
pub mod walk;
