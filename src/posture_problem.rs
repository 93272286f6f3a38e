//! Posture problems as they stand in a file.
//!
//! The format is [`scenes::contact_sets`]'s; a plain list of problems without surfaces is read, too.

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Matrix3, Point2, Rotation3, Translation3, UnitQuaternion};
use posture::{Contact, Environment, Freedom, Problem, stand};
use robot_model::{Configuration, ContactPatch, PatchId, Robot};
use scenes::contact_sets::{
    BODY_M, ContactRecord, FORMAT, FORMAT_BEGINS, Margins, ProblemRecord, ProblemSet, SurfaceRecord,
};
use surfaces::{ConvexPolygon, Face, Region, Terrain};

/// Largest entry of RᵀR − 1 that counts as the rounding of written decimals.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// The problems of a file.
///
/// # Errors
/// What is no such file, with line and column; a version of the format that is not known.
pub fn parse(bytes: &[u8]) -> Result<ProblemSet> {
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    if first == Some(&b'[') {
        let problems = serde_json::from_slice(bytes).context("not a list of posture problems")?;
        return Ok(ProblemSet {
            format: FORMAT.to_owned(),
            robot: String::new(),
            joint_names: Vec::new(),
            family: String::new(),
            seed: 0,
            body_m: BODY_M,
            problems,
        });
    }
    #[derive(serde::Deserialize)]
    struct Versioned {
        format: String,
    }
    // A later version may have other fields: its name comes first.
    let Versioned { format } =
        serde_json::from_slice(bytes).context("not a file of posture problems")?;
    if format != FORMAT {
        let what = if format.starts_with(FORMAT_BEGINS) {
            "another version of the program wrote this"
        } else {
            "this is no file of posture problems"
        };
        bail!("format is {format:?}, {FORMAT:?} is read here: {what}");
    }
    let set: ProblemSet =
        serde_json::from_slice(bytes).context("not a file of posture problems")?;
    if !(set.body_m > 0.0 && set.body_m.is_finite()) {
        bail!("body_m = {} is no thickness", set.body_m);
    }
    Ok(set)
}

/// The margins that problems are drawn for.
pub fn margins(config: &posture::Config) -> Margins {
    Margins {
        friction_use: config.friction_use,
        torque_use: config.torque_use,
        joint_margin_rad: config.joint_margin_rad,
        self_clearance_m: config.self_clearance_m,
        clearance_m: config.clearance_m,
        com_margin_m: config.com_margin_m,
    }
}

/// A problem of a file on a robot.
pub struct Posed {
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// The surfaces and what is behind them.
    pub environment: Environment,
    /// Where the search starts: the comfortable posture, its base where the contacts would have it.
    pub guess: Configuration,
}

impl Posed {
    /// What the posture generator is asked.
    pub fn problem<'a>(&'a self, robot: &'a Robot) -> Problem<'a> {
        Problem {
            robot,
            environment: &self.environment,
            contacts: self.contacts.clone(),
            base_goal: None,
            joint_goal: None,
            reference: &self.guess,
            guess: &self.guess,
        }
    }
}

/// A record as the posture generator takes it, a body of `body_m` behind every surface.
///
/// # Errors
/// The problem and the contact or surface that make no sense, and why.
pub fn pose(
    record: &ProblemRecord,
    robot: &Robot,
    reference: &Configuration,
    body_m: f64,
) -> Result<Posed> {
    let (id, mu) = (&record.id, record.mu);
    if !(mu > 0.0 && mu.is_finite()) {
        bail!("problem {id}: mu = {mu} is no coefficient of friction");
    }
    let faces = record.surfaces.iter();
    let faces = faces
        .map(|s| face(s).with_context(|| format!("problem {id}, surface {:?}", s.id)))
        .collect::<Result<Vec<_>>>()?;
    let problem = || format!("problem {id}");
    let terrain = Terrain::new(faces, Vec::new()).with_context(problem)?;
    let environment = Environment::new(terrain, body_m, 0.0).with_context(problem)?;
    let contacts = record.contacts.iter().enumerate().map(|(i, c)| {
        let contact = contact(c, robot, &environment, mu);
        contact.with_context(|| format!("problem {id}, contact {i}"))
    });
    let contacts = contacts.collect::<Result<Vec<_>>>()?;
    let guess = stand::over_contacts(robot, reference, &contacts);
    Ok(Posed {
        contacts,
        environment,
        guess,
    })
}

fn contact(
    record: &ContactRecord,
    robot: &Robot,
    environment: &Environment,
    friction: f64,
) -> Result<Contact> {
    let face = record.surface.as_deref().map(|id| environment.face(id));
    let face = face.transpose()?;
    let patch = patch(record, robot)?;
    let contact = match (&record.p, &record.R, face) {
        (Some(p), Some(R), face) => {
            let at = robot.patches[patch].touching(&isometry(p, R)?);
            let yaw = record.yaw_free;
            Contact {
                face,
                freedom: if yaw { Freedom::Yaw } else { Freedom::Fixed },
                ..Contact::at(robot, patch, at)
            }
        }
        (None, None, Some(face)) => Contact::anywhere_on(environment, face, robot, patch)?,
        (None, None, None) => bail!("neither p and R nor a surface say where it is"),
        _ => bail!("p and R go together"),
    };
    Ok(Contact {
        friction,
        ..contact
    })
}

fn face(record: &SurfaceRecord) -> Result<Face> {
    let vertices = record.polygon_m.iter().map(|&v| Point2::from(v)).collect();
    let polygon = ConvexPolygon::new(vertices)?;
    let X_WF = isometry(&record.p, &record.R)?;
    Ok(Face::new(record.id.as_str(), X_WF, Region::from(&polygon)))
}

fn isometry(p: &[f64; 3], R: &[[f64; 3]; 3]) -> Result<Isometry3<f64>> {
    if let Some(x) = p.iter().find(|x| !x.is_finite()) {
        bail!("p holds {x}");
    }
    Ok(Isometry3::from_parts(Translation3::from(*p), rotation(R)?))
}

/// The patch of a link that a record names, by its name or else by a role.
fn patch(record: &ContactRecord, robot: &Robot) -> Result<PatchId> {
    robot.frame(&record.link)?;
    let on_link: Vec<PatchId> = robot
        .patch_ids()
        .filter(|p| robot.patches[*p].link == record.link)
        .collect();
    let those = |fits: &dyn Fn(&ContactPatch) -> bool| -> Vec<PatchId> {
        let patches = on_link.iter().copied();
        patches.filter(|p| fits(&robot.patches[*p])).collect()
    };
    let named = match &record.patch {
        None => on_link.clone(),
        Some(name) => match those(&|p| &p.name == name) {
            by_name if by_name.is_empty() => those(&|p| p.has_role(name)),
            by_name => by_name,
        },
    };
    let known = || {
        let names = on_link.iter().map(|p| robot.patches[*p].name.as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let link = &record.link;
    match (named.as_slice(), &record.patch) {
        ([patch], _) => Ok(*patch),
        ([], Some(name)) => bail!(
            "link {link} has no patch or role {name:?}; it has: {}",
            known()
        ),
        ([], None) => bail!("link {link} has no contact patch"),
        _ => bail!("link {link} has several such patches: {}", known()),
    }
}

/// The rotation of rows that are orthonormal up to rounding.
fn rotation(rows: &[[f64; 3]; 3]) -> Result<UnitQuaternion<f64>> {
    let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
    let off = (matrix.transpose() * matrix - Matrix3::identity()).amax();
    if off.is_nan() || off > ROTATION_TOLERANCE {
        bail!("R is no rotation: RᵀR differs from the identity by {off:.1e}");
    }
    if matrix.determinant() < 0.0 {
        bail!("R mirrors: its determinant is −1");
    }
    let guess = Rotation3::from_matrix_unchecked(matrix);
    let nearest = Rotation3::from_matrix_eps(&matrix, 1e-14, 100, guess);
    Ok(UnitQuaternion::from_rotation_matrix(&nearest))
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
        let text = rotation(&mirror).unwrap_err().to_string();
        assert!(text.contains("mirrors"), "{text}");
        assert!(rotation(&[[f64::NAN; 3]; 3]).is_err());
    }

    #[test]
    fn a_file_that_is_no_list_is_refused_with_the_line() {
        for (text, word) in [
            ("[\n{\"id\": 1,\n \"mu\": }]", "line 3"),
            ("[{\"id\": 1, \"mu\": 1, \"contact\": []}]", "contact"),
        ] {
            let said = format!("{:#}", parse(text.as_bytes()).unwrap_err());
            assert!(said.contains(word), "{said}");
        }
    }
}
