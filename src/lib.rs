//! scandent

pub mod view;
