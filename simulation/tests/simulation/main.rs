//! Stances and motions simulated: what must hold holds, what must fail fails.
#![allow(clippy::unwrap_used)]

#[cfg(feature = "mujoco")]
mod displaced;
mod dynamics;
#[cfg(feature = "mujoco")]
mod from_mjcf;
#[cfg(feature = "mujoco")]
mod mujoco;
mod robot;
#[cfg(feature = "mujoco")]
mod stepping;
mod whole_body;
