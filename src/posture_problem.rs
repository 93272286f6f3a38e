//! Posture problems as they stand in a file: contact sets with fixed poses.

use anyhow::{Context, Result, anyhow, bail};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use posture::{Contact, Place};
use robot_model::{Configuration, Kinematics, Robot};
use serde::Deserialize;

/// Largest entry of RᵀR − 1 that counts as the rounding of written decimals.
const ROTATION_TOLERANCE: f64 = 1e-4;
/// Weight of a contact's heading against a squared lever arm of a decimetre, m².
const HEADING_WEIGHT_M2: f64 = 0.01;

/// One problem of the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemRecord {
    /// A number or a name that the result repeats.
    pub id: serde_json::Value,
    /// Coefficient of friction of every contact.
    pub mu: f64,
    /// The contacts.
    pub contacts: Vec<ContactRecord>,
}

/// One contact, fixed in W.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct ContactRecord {
    /// The link that carries the patch.
    pub link: String,
    /// The patch: its name, or a role that tells it from the link's other patches; may be left
    /// out where the link has one only.
    #[serde(default)]
    pub patch: Option<String>,
    /// Position of C in W, m.
    pub p: [f64; 3],
    /// Rotation of C in W by rows; its columns are C's axes in W, z outward from the environment.
    pub R: [[f64; 3]; 3],
    /// Whether the patch may turn about that z.
    #[serde(default)]
    pub yaw_free: bool,
}

/// The problems of a file.
///
/// # Errors
/// What is no such list, with line and column.
pub fn parse(bytes: &[u8]) -> Result<Vec<ProblemRecord>> {
    serde_json::from_slice(bytes).context("not a list of posture problems")
}

impl ProblemRecord {
    /// The contacts as the posture generator takes them.
    ///
    /// # Errors
    /// The problem and the contact that make no sense, and why.
    pub fn contacts(&self, robot: &Robot) -> Result<Vec<Contact>> {
        if !(self.mu > 0.0 && self.mu.is_finite()) {
            bail!(
                "problem {}: mu = {} is no coefficient of friction",
                self.id,
                self.mu
            );
        }
        let contact = |(i, record): (usize, &ContactRecord)| {
            record
                .contact(robot, self.mu)
                .with_context(|| format!("problem {}, contact {i}", self.id))
        };
        self.contacts.iter().enumerate().map(contact).collect()
    }
}

impl ContactRecord {
    #[allow(non_snake_case)]
    fn contact(&self, robot: &Robot, friction: f64) -> Result<Contact> {
        if let Some(x) = self.p.iter().find(|x| !x.is_finite()) {
            bail!("p holds {x}");
        }
        let X_WC = Isometry3::from_parts(Translation3::from(self.p), rotation(&self.R)?);
        let place = Place::Fixed {
            X_WC,
            yaw_free: self.yaw_free,
            surface: None,
        };
        Ok(Contact {
            patch: self.patch(robot)?,
            place,
            loaded: true,
            friction,
        })
    }

    /// Index of the patch.
    fn patch(&self, robot: &Robot) -> Result<usize> {
        robot.frame(&self.link)?;
        let on_link = || {
            robot
                .patches
                .iter()
                .enumerate()
                .filter(|(_, p)| p.link == self.link)
        };
        let named: Vec<usize> = match &self.patch {
            None => on_link().map(|(i, _)| i).collect(),
            Some(name) => {
                let by_name: Vec<_> = on_link()
                    .filter(|(_, p)| &p.name == name)
                    .map(|(i, _)| i)
                    .collect();
                if by_name.is_empty() {
                    on_link()
                        .filter(|(_, p)| p.has_role(name))
                        .map(|(i, _)| i)
                        .collect()
                } else {
                    by_name
                }
            }
        };
        let known = || {
            on_link()
                .map(|(_, p)| p.name.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        };
        match (named.as_slice(), &self.patch) {
            ([patch], _) => Ok(*patch),
            ([], Some(name)) => Err(anyhow!(
                "link {} has no patch or role {name:?}; it has: {}",
                self.link,
                known()
            )),
            ([], None) => Err(anyhow!("link {} has no contact patch", self.link)),
            _ => Err(anyhow!(
                "link {} has several such patches: {}",
                self.link,
                known()
            )),
        }
    }
}

/// The rotation of rows that are orthonormal up to rounding.
fn rotation(rows: &[[f64; 3]; 3]) -> Result<UnitQuaternion<f64>> {
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let off = (matrix.transpose() * matrix - Matrix3::identity())
        .abs()
        .max();
    if off.is_nan() || off > ROTATION_TOLERANCE {
        bail!("R is no rotation: RᵀR differs from the identity by {off:.1e}");
    }
    if matrix.determinant() < 0.0 {
        bail!("R mirrors: its determinant is −1");
    }
    Ok(UnitQuaternion::from_rotation_matrix(
        &Rotation3::from_matrix_eps(
            &matrix,
            1e-14,
            100,
            Rotation3::from_matrix_unchecked(matrix),
        ),
    ))
}

/// The posture with its base upright where the contacts would have it.
///
///   yaw = atan2(Σ a × b, Σ a · b),   p = mean of (target − R(yaw) place)
///
/// over a = a patch's place relative to the mean in `posture`, b = the same of its target, both
/// horizontal, and the headings of level contacts as unit vectors of small weight.
#[allow(non_snake_case)]
pub fn place_base(robot: &Robot, posture: &Configuration, contacts: &[Contact]) -> Configuration {
    let kinematics = Kinematics::new(robot, posture);
    let base = Isometry3::from_parts(posture.p_WB.into(), posture.R_WB).inverse();
    let pairs: Vec<(Isometry3<f64>, Isometry3<f64>, bool)> = contacts
        .iter()
        .filter_map(|contact| match &contact.place {
            Place::Fixed { X_WC, yaw_free, .. } => {
                let place = base * kinematics.X_WC(&robot.patches[contact.patch]);
                Some((place, *X_WC, *yaw_free))
            }
            Place::OnSurface { .. } => None,
        })
        .collect();
    if pairs.is_empty() {
        return posture.clone();
    }
    let n = pairs.len() as f64;
    let mean_place = pairs
        .iter()
        .map(|p| p.0.translation.vector)
        .sum::<Vector3<f64>>()
        / n;
    let mean_target = pairs
        .iter()
        .map(|p| p.1.translation.vector)
        .sum::<Vector3<f64>>()
        / n;
    let (mut sin, mut cos) = (0.0, 0.0);
    for (place, target, yaw_free) in &pairs {
        let a = (place.translation.vector - mean_place).xy();
        let b = (target.translation.vector - mean_target).xy();
        sin += a.perp(&b);
        cos += a.dot(&b);
        let level = |x: &Isometry3<f64>| (x.rotation * Vector3::z()).z > 0.5;
        if !yaw_free && level(place) && level(target) {
            let a = (place.rotation * Vector3::x()).xy();
            let b = (target.rotation * Vector3::x()).xy();
            sin += HEADING_WEIGHT_M2 * a.perp(&b);
            cos += HEADING_WEIGHT_M2 * a.dot(&b);
        }
    }
    let yaw = if sin == 0.0 && cos == 0.0 {
        0.0
    } else {
        f64::atan2(sin, cos)
    };
    let R_WB = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    let p_WB = mean_target - R_WB * mean_place;
    posture
        .clone()
        .with_base(&Isometry3::from_parts(p_WB.into(), R_WB))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_rotations_pass_and_others_do_not() {
        let turn = Rotation3::from_euler_angles(0.1, -0.2, 0.3);
        let rounded = |digits: i32| -> [[f64; 3]; 3] {
            let scale = 10f64.powi(digits);
            std::array::from_fn(|i| {
                std::array::from_fn(|j| (turn.matrix()[(i, j)] * scale).round() / scale)
            })
        };
        let read = rotation(&rounded(6)).unwrap();
        assert!(read.angle_to(&UnitQuaternion::from(turn)) < 2e-6);
        let text = rotation(&rounded(2)).unwrap_err().to_string();
        assert!(text.contains("no rotation"), "{text}");
        let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        assert!(
            rotation(&mirror)
                .unwrap_err()
                .to_string()
                .contains("mirrors")
        );
        assert!(rotation(&[[f64::NAN; 3]; 3]).is_err());
    }

    #[test]
    fn a_file_that_is_no_list_is_refused_with_the_line() {
        let text = format!("{:#}", parse(b"[\n{\"id\": 1,\n \"mu\": }]").unwrap_err());
        assert!(text.contains("line 3"), "{text}");
        let text = format!(
            "{:#}",
            parse(b"[{\"id\": 1, \"mu\": 1, \"contact\": []}]").unwrap_err()
        );
        assert!(text.contains("contact"), "{text}");
    }
}
