//! scandent
