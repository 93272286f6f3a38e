//! Everything that can keep a mount from being found.

use crate::camera::Degeneracy;

/// Why a plane, a stance or a mount could not be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Too little of a scan can be ground.
    #[error(
        "no ground: {found} of {samples} points within {range_min_m}–{range_max_m} m lie on one plane, {wanted} are needed"
    )]
    NoGround {
        /// Points on the best plane.
        found: usize,
        /// Points within range.
        samples: usize,
        /// Points needed.
        wanted: usize,
        /// Nearest distance that counts, m.
        range_min_m: f64,
        /// Farthest distance that counts, m.
        range_max_m: f64,
    },
    /// Points that ought to span a plane or a rotation lie on a line.
    #[error("{what}: the points lie on a line")]
    Collinear {
        /// Whose points.
        what: &'static str,
    },
    /// The feet do not fit the ground.
    #[error("feet: {cause}")]
    Feet {
        /// What is wrong with them.
        cause: String,
    },
    /// What a LiDAR saw does not determine its mount.
    #[error("{cause}")]
    Lidar {
        /// Why not.
        cause: String,
    },
    /// A cloud of a LiDAR cannot be used.
    #[error("{source}")]
    Cloud {
        /// Its number among those given, from 0.
        number: usize,
        /// Why not.
        source: perception::Error,
    },
    /// The poses do not determine the mount.
    #[error("the poses do not determine the mount: {0}")]
    Degenerate(Degeneracy),
    /// The refinement did not come to an end.
    #[error("the identification did not converge in {iterations} iterations")]
    NotConverged {
        /// Iterations done.
        iterations: usize,
    },
    /// A parameter is outside its range.
    #[error("{key} = {value}: {cause}")]
    Config {
        /// The parameter's name.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        cause: &'static str,
    },
}

/// `Ok` if `value` is finite and inside `[low, high]`, else the config error that names `key`.
pub(crate) fn within(
    key: &'static str,
    value: f64,
    [low, high]: [f64; 2],
    cause: &'static str,
) -> Result<(), Error> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(Error::Config { key, value, cause })
    }
}
