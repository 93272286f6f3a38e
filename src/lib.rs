//! scandent

pub mod verify;
pub mod view;
