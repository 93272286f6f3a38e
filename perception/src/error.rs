//! Everything that can go wrong between a scan file and its surfaces.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Why a scan could not be read or turned into surfaces.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that cannot be read, is of no known format, contradicts its format, itself or its length, holds no valid
    /// point, or needs what was not given.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, after the header field or the part, as the format calls it.
        cause: String,
    },
    /// The sensor table has no entry of this name.
    #[error("unknown sensor {name:?}; known are {}", candidates.join(", "))]
    UnknownSensor {
        /// The name asked for.
        name: String,
        /// The names in the table.
        candidates: Vec<&'static str>,
    },
    /// Hardly a point of a scan is in range: its unit is another one, or the range too short.
    #[error(
        "{scan}: {used} of {points} points are within {range_max_m} m (perception.range_max_m), and half of them are \
         farther away than {median_m:.3} m: is the file in mm or cm?"
    )]
    OutOfRange {
        /// The scan.
        scan: String,
        /// Points in range.
        used: usize,
        /// Points measured.
        points: usize,
        /// Half of the points are farther away, m.
        median_m: f64,
        /// The range that is used, m.
        range_max_m: f64,
    },
    /// No face of a scan could be one that is walked on.
    #[error(
        "none of {faces} faces can be the ground: none is seen from above by a sensor that is carried upright, or lies across the direction given as up; give what is up in it (--up X,Y,Z or --imu FILE; up in a scene), or its pose{hint}"
    )]
    NoLevelFace {
        /// Faces that were found.
        faces: usize,
        /// What may be level otherwise, in words; nothing where up was given.
        hint: String,
    },
    /// The organised path was asked for on a cloud that has no image behind it.
    #[error("method \"organised\" needs a depth image, or an organised cloud in its optical frame")]
    NotOrganised,
    /// A LiDAR's calibration holds a value that makes no sense.
    #[error("calibration: {field} {cause}")]
    Calibration {
        /// The field.
        field: &'static str,
        /// What is wrong with it.
        cause: String,
    },
    /// A LiDAR's cloud has too few points in view, or none that is not isolated.
    #[error(
        "{left} points are left of {points} ({invalid} more are invalid) in view, in range and not isolated; a plane needs 3"
    )]
    FewPoints {
        /// Points left.
        left: usize,
        /// Valid points of the cloud.
        points: usize,
        /// Invalid ones beside them.
        invalid: usize,
    },
    /// No plane under the sensor is about level, and no calibration says where the ground is.
    #[error(
        "no ground: none of the planes through {points} points is about level under the sensor; a calibration would tell where it is"
    )]
    NoGround {
        /// Points that were looked at.
        points: usize,
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
    /// The search for nearest neighbours refused the points.
    #[error("nearest neighbours: {source}")]
    Neighbours {
        /// What the search tree said.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Error {
    /// An error of `path`.
    pub(crate) fn file(path: &Path, cause: impl Into<String>) -> Self {
        Self::File {
            path: path.to_owned(),
            cause: cause.into(),
        }
    }

    /// An error of a part of `path`.
    pub(crate) fn field(path: &Path, field: impl Display, cause: impl Display) -> Self {
        Self::file(path, format!("{field}: {cause}"))
    }

    /// A parser's error of `path`.
    pub(crate) fn parse(path: &Path, format: &str, cause: impl Display) -> Self {
        Self::file(path, format!("not a readable {format} file: {cause}"))
    }
}

/// `Ok` if `value` is finite and inside `[low, high]`, else the config error that names `key`.
pub(crate) fn within(
    key: &'static str,
    value: f64,
    low: f64,
    high: f64,
    cause: &'static str,
) -> Result<(), Error> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(Error::Config { key, value, cause })
    }
}
