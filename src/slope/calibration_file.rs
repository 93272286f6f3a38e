//! The TOML file of a LiDAR's calibration.

use std::path::Path;

use anyhow::{Context, Result};
use perception::lidar::LidarCalibration;

use crate::output;
use crate::provenance::Inputs;

/// Reads and checks a calibration.
///
/// # Errors
/// A file that cannot be read, is no TOML or holds a value that makes no sense: file, line or field,
/// cause.
pub fn read(path: &Path, inputs: &mut Inputs) -> Result<LidarCalibration> {
    let name = path.display().to_string();
    let bytes = inputs.read("calibration", path)?;
    parse(&bytes).with_context(|| name)
}

/// The calibration in `bytes`.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8]) -> Result<LidarCalibration> {
    let text = std::str::from_utf8(bytes).context("not a text file")?;
    let calibration: LidarCalibration =
        toml::from_str(text).context("not a LiDAR's calibration")?;
    calibration.check()?;
    Ok(calibration)
}

/// Writes a calibration in one step.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, calibration: &LidarCalibration) -> Result<()> {
    output::write(path, toml::to_string(calibration)?.as_bytes())
}
