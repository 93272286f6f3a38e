//! Plans in the physics simulation: stances held, motions executed.

pub mod execute;
pub mod hold;
pub mod report;
pub mod stance;
pub mod table;
pub mod trace;
pub mod video;
pub mod world;
