//! Best-first search over contact sets.
