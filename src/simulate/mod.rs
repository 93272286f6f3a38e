//! Plans in the physics simulation: stances held, motions executed.

pub mod report;

#[cfg(feature = "mujoco")]
pub mod execute;
#[cfg(feature = "mujoco")]
pub mod hold;
#[cfg(feature = "mujoco")]
pub mod stance;
#[cfg(feature = "mujoco")]
pub mod table;
#[cfg(feature = "mujoco")]
pub mod trace;
#[cfg(feature = "mujoco")]
pub mod video;
#[cfg(feature = "mujoco")]
pub mod world;
