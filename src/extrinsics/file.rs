//! The file of extrinsics: pose of the sensor on a link, with its covariance.

use anyhow::{Result, bail};
use calibration::camera::{Identification, PaperParameters};
use nalgebra::{Isometry3, UnitQuaternion};
use plan::{Input, Program};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Format name of the file.
pub const FORMAT: &str = "scandent-extrinsics/1";
/// How far the quaternion's length may be from 1: written decimals.
const UNIT_TOLERANCE: f64 = 1e-6;

/// Where a sensor sits on a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Extrinsics {
    /// `scandent-extrinsics/1`.
    pub format: String,
    /// The robot's name.
    pub robot: String,
    /// The link of which the frame is R.
    pub link: String,
    /// Position of the sensor's optical frame V (x right, y down, z forward) in R, m.
    pub position_m: [f64; 3],
    /// Orientation of V in R.
    pub quat_xyzw: [f64; 4],
    /// Covariance of (δθ, δp) in R, R_RV = exp(δθ) R̂, p_RV = p̂ + δp: rad², rad·m, m².
    pub covariance: Option<[[f64; 6]; 6]>,
    /// Standard deviations of (δθ, δp): rad, m.
    pub sigma: Option<[f64; 6]>,
    /// The same in the paper's convention.
    pub paper: Option<Paper>,
    /// How well the stances determine it.
    pub quality: Option<Quality>,
    /// The program that wrote it.
    pub program: Option<Program>,
    /// What it was computed from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub input: Vec<Input>,
}

/// The six parameters of \[chai2015\]: α, β, γ about Y, Z, X; y up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// α, β, γ, degrees.
    pub angles_deg: [f64; 3],
    /// p_x, p_y, p_z, mm.
    pub position_mm: [f64; 3],
    /// Their standard deviations, degrees.
    pub angles_sigma_deg: [f64; 3],
    /// Their standard deviations, mm.
    pub position_sigma_mm: [f64; 3],
}

/// How well the stances determine the mount.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// Stances.
    pub stances: usize,
    /// Different tilts among them.
    pub tilts: usize,
    /// Rank of the unweighted Jacobian.
    pub rank: usize,
    /// Its greatest over its least singular value (rad, m).
    pub condition: f64,
    /// Residuals over their stated noise.
    pub noise_factor: f64,
    /// Mean angle between measured and predicted ground, degrees.
    pub theta_mean_deg: f64,
    /// Greatest such angle, degrees.
    pub theta_max_deg: f64,
    /// Mean difference of the distances, mm.
    pub distance_mean_mm: f64,
    /// Greatest such difference, mm.
    pub distance_max_mm: f64,
}

impl Extrinsics {
    /// What is written of an identification.
    pub fn of(found: &Identification, robot: &str, link: &str, input: Vec<Input>) -> Self {
        let X_RV = &found.X_RV;
        let parameters = PaperParameters::of_mount(X_RV);
        let deviations = parameters.deviations(&found.covariance);
        let rows = [0, 1, 2, 3, 4, 5].map(|i| [0, 1, 2, 3, 4, 5].map(|j| found.covariance[(i, j)]));
        Self {
            format: FORMAT.to_owned(),
            robot: robot.to_owned(),
            link: link.to_owned(),
            position_m: X_RV.translation.vector.into(),
            quat_xyzw: X_RV.rotation.coords.into(),
            covariance: Some(rows),
            sigma: Some([0, 1, 2, 3, 4, 5].map(|k| rows[k][k].max(0.0).sqrt())),
            paper: deviations.map(|[a, b, c, x, y, z]| Paper {
                angles_deg: parameters.angles_rad.map(f64::to_degrees),
                position_mm: parameters.position_m.map(|p| 1e3 * p),
                angles_sigma_deg: [a, b, c].map(f64::to_degrees),
                position_sigma_mm: [x, y, z].map(|p| 1e3 * p),
            }),
            quality: Some(Quality::of(found)),
            program: Some(crate::program()),
            input,
        }
    }

    /// The file's text.
    pub fn to_toml(&self) -> Result<String> {
        Ok(toml::to_string(self)?)
    }

    /// Reads and checks a file's text.
    ///
    /// # Errors
    /// Text that is no such file, with the line or the field.
    pub fn parse(text: &str) -> Result<Self> {
        let read: Self = toml::from_str(text)?;
        if read.format != FORMAT {
            bail!("format {:?} is not {FORMAT:?}", read.format);
        }
        let numbers = read.position_m.iter().chain(&read.quat_xyzw);
        if numbers.clone().any(|x| !x.is_finite()) {
            bail!("position_m or quat_xyzw is not finite");
        }
        let length = read.quat_xyzw.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            bail!("quat_xyzw has length {length}, not 1");
        }
        Ok(read)
    }

    /// Pose of V in R.
    pub fn X_RV(&self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_quaternion(self.quat_xyzw.into());
        Isometry3::from_parts(self.position_m.into(), rotation)
    }
}

impl Quality {
    fn of(found: &Identification) -> Self {
        let n = found.agreement.len().max(1) as f64;
        let theta = || found.agreement.iter().map(|a| a.theta_rad.to_degrees());
        let distance = || found.agreement.iter().map(|a| 1e3 * a.distance_error_m);
        Self {
            stances: found.agreement.len(),
            tilts: found.observability.tilts,
            rank: found.observability.rank,
            condition: found.observability.condition,
            noise_factor: found.noise_factor,
            theta_mean_deg: theta().sum::<f64>() / n,
            theta_max_deg: theta().fold(0.0, f64::max),
            distance_mean_mm: distance().sum::<f64>() / n,
            distance_max_mm: distance().fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "format = \"scandent-extrinsics/1\"\nrobot = \"r\"\nlink = \"body\"\n\
        position_m = [0.5, 0.0, 0.4]\nquat_xyzw = [0.0, 0.0, 0.6, 0.8]\n";

    #[test]
    fn a_mount_alone_is_enough_and_comes_back() {
        let read = Extrinsics::parse(SMALL).unwrap();
        assert_eq!(
            read.X_RV().translation.vector,
            nalgebra::Vector3::new(0.5, 0.0, 0.4)
        );
        assert_eq!(Extrinsics::parse(&read.to_toml().unwrap()).unwrap(), read);
    }

    #[test]
    fn mistakes_are_named() {
        for (from, to, word) in [
            ("extrinsics/1", "extrinsics/9", "extrinsics/9"),
            ("0.8]", "0.9]", "length"),
            ("0.4]", "nan]", "finite"),
            ("link", "lnk", "lnk"),
        ] {
            let error = Extrinsics::parse(&SMALL.replace(from, to)).unwrap_err();
            assert!(format!("{error:#}").contains(word), "{error:#}");
        }
    }
}
