//! Where a sensor sits on a robot: stances and frames → extrinsics, their file, their report.
//!
//! | file | what it holds |
//! |---|---|
//! | `stances_file.rs` | the table of stances: a frame and joint readings a row |
//! | `feet.rs` | the feet of a robot as points of a link's frame |
//! | `identify.rs` | stances and frames → the extrinsics |
//! | `file.rs` | the file of the extrinsics |
//! | `next.rs` | which stance to add |
//! | `mistakes.rs` | which mistake in the table explains that nothing fits |
//! | `verdict.rs` | what is to be thought of the extrinsics |
//! | `placement.rs` | extrinsics → the pose of a scene's scans |
//! | `report.rs`, `report/` | what is said of it: in words, as CSV, as one HTML page |
//! | `plot.rs` | the page's charts |

pub mod feet;
pub mod file;
pub mod identify;
pub mod mistakes;
pub mod next;
pub mod placement;
pub mod plot;
pub mod report;
pub mod stances_file;
pub mod verdict;
