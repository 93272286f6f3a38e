//! URDF + SRDF + contacts file → [`Robot`].
//!
//! 1. `urdf` says what the file says; `tree` whether that is a tree.
//! 2. `lump` makes moving bodies of it, `inertia` weighs them, `shapes` gives them hulls.
//! 3. `srdf` adds postures and disables pairs; `contacts` adds patches.

mod contacts;
mod inertia;
mod lump;
mod package;
mod shapes;
mod srdf;
mod tree;
mod urdf;
mod xml;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::collision::CollisionModel;
use crate::{Config, Error, Kinematics, Robot};

/// The files that make up a robot.
#[derive(Clone, Debug, Default)]
pub struct RobotFiles {
    /// The URDF.
    pub urdf: PathBuf,
    /// The SRDF, if any.
    pub srdf: Option<PathBuf>,
    /// The contacts file, if any.
    pub contacts: Option<PathBuf>,
    /// Folders to look for `package://` meshes in, before those above the URDF.
    pub package_dirs: Vec<PathBuf>,
    /// How strictly to read them.
    pub config: Config,
}

impl RobotFiles {
    /// A URDF alone.
    pub fn new(urdf: impl Into<PathBuf>) -> Self {
        RobotFiles {
            urdf: urdf.into(),
            ..RobotFiles::default()
        }
    }

    /// With an SRDF.
    pub fn with_srdf(mut self, srdf: impl Into<PathBuf>) -> Self {
        self.srdf = Some(srdf.into());
        self
    }

    /// With a contacts file.
    pub fn with_contacts(mut self, contacts: impl Into<PathBuf>) -> Self {
        self.contacts = Some(contacts.into());
        self
    }
}

/// Gives the bytes of the mesh of a name as the URDF has it, or says why not.
pub type MeshSource<'a> = dyn Fn(&str) -> Result<Vec<u8>, String> + 'a;

/// The [`MeshSource`] of robots that have no meshes.
///
/// # Errors
/// Always.
pub fn no_meshes(_filename: &str) -> Result<Vec<u8>, String> {
    Err("this robot is embedded and has no mesh files".to_owned())
}

/// Reads a robot from its files.
///
/// # Errors
/// Every variant of [`Error`] but [`Error::Value`], naming file, link or joint, and cause.
pub fn load(files: &RobotFiles) -> Result<Robot, Error> {
    let named = |path: &PathBuf| Ok((path.display().to_string(), read_text(path)?));
    let texts = Texts {
        urdf: named(&files.urdf)?,
        srdf: files.srdf.as_ref().map(named).transpose()?,
        contacts: files.contacts.as_ref().map(named).transpose()?,
    };
    // An absolute folder has all of its parents to look for packages in.
    let urdf_path = std::path::absolute(&files.urdf).unwrap_or_else(|_| files.urdf.clone());
    let urdf_dir = urdf_path.parent().unwrap_or(Path::new(".")).to_owned();
    let meshes = |filename: &str| {
        let path = package::find(filename, &urdf_dir, &files.package_dirs)?;
        std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    assemble(&texts, &meshes, &files.config)
}

/// Reads an embedded robot; errors call its texts `NAME.urdf`, `NAME.srdf` and `NAME contacts`.
///
/// # Errors
/// As [`load`].
pub fn load_from_strings(
    urdf: &str,
    srdf: Option<&str>,
    contacts: Option<&str>,
    name: &str,
    meshes: &MeshSource,
    config: &Config,
) -> Result<Robot, Error> {
    let texts = Texts {
        urdf: (format!("{name}.urdf"), urdf.to_owned()),
        srdf: srdf.map(|text| (format!("{name}.srdf"), text.to_owned())),
        contacts: contacts.map(|text| (format!("{name} contacts"), text.to_owned())),
    };
    assemble(&texts, meshes, config)
}

/// Each file's name and text.
struct Texts {
    urdf: (String, String),
    srdf: Option<(String, String)>,
    contacts: Option<(String, String)>,
}

fn assemble(texts: &Texts, meshes: &MeshSource, config: &Config) -> Result<Robot, Error> {
    let mut findings = Findings {
        lenient: config.lenient,
        ..Findings::default()
    };
    // The URDF: tree, bodies, shapes.
    let (file, text) = &texts.urdf;
    let urdf = urdf::parse(file, text)?;
    let tree = tree::of(file, &urdf)?;
    let lumped = lump::lump(file, &urdf, &tree, &mut findings)?;
    let mut reader = shapes::ShapeReader {
        file,
        meshes,
        config,
        hulls: BTreeMap::new(),
    };
    let shapes = reader.read(&urdf, &lumped.places, &mut findings)?;
    let collision = CollisionModel::new(shapes, &lumped.bodies);
    let mut robot = Robot::new(urdf.name, lumped.bodies, lumped.frames, collision)?;
    // What the other files add.
    if let Some((file, text)) = &texts.srdf {
        srdf::apply(file, text, &mut robot, &mut findings)?;
    }
    if let Some((file, text)) = &texts.contacts {
        robot.patches = contacts::read(file, text, &robot)?;
    }
    let resting = Kinematics::new(&robot, &robot.resting());
    robot.collision.disable_overlapping_neighbours(&resting);
    // Overlap at rest is a flaw of the shapes, not of the posture.
    let overlapping = robot.colliding_pairs(&robot.resting());
    if config.disable_colliding_at_rest {
        robot.collision.disable(|a, b| {
            overlapping
                .iter()
                .any(|pair| pair.link_a == a && pair.link_b == b)
        });
    }
    findings.watches_overlap = !config.disable_colliding_at_rest;
    findings.overlapping = overlapping
        .iter()
        .map(|p| format!("{} – {} ({:.1} mm)", p.link_a, p.link_b, -p.distance * 1e3))
        .collect();
    robot.notes = findings.into_notes();
    Ok(robot)
}

fn read_text(path: &Path) -> Result<String, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io {
        path: path.to_owned(),
        source,
    })?;
    String::from_utf8(bytes).map_err(|error| Error::Parse {
        file: path.display().to_string(),
        cause: format!("byte {} is no UTF-8 text", error.utf8_error().valid_up_to()),
    })
}

/// What was assumed on the way, to be told to the user.
#[derive(Default)]
struct Findings {
    lenient: bool,
    notes: Vec<String>,
    mimics: Vec<String>,
    continuous: Vec<String>,
    locked: Vec<String>,
    without_effort: Vec<String>,
    without_velocity: Vec<String>,
    simplified: Vec<String>,
    overlapping: Vec<String>,
    watches_overlap: bool,
}

impl Findings {
    fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// The error itself, or a note of it where that is wanted.
    fn refuse_unless_lenient(&mut self, error: Error) -> Result<(), Error> {
        if !self.lenient {
            return Err(error);
        }
        self.note(format!("{error} (read on, as asked)"));
        Ok(())
    }

    /// Things of a kind are told of together, one note a kind.
    fn into_notes(self) -> Vec<String> {
        let overlapping = if self.watches_overlap {
            "links overlap at rest and are watched all the same"
        } else {
            "links overlap at rest and are not watched"
        };
        let kinds = [
            ("mimic joints are locked", self.mimics),
            ("joints without a range are locked", self.locked),
            ("continuous joints are limited to ±2π rad", self.continuous),
            (
                "no effort limit is stated, none is used",
                self.without_effort,
            ),
            (
                "no velocity limit is stated, none is used",
                self.without_velocity,
            ),
            (
                "hulls were simplified; the meshes stick out by up to",
                self.simplified,
            ),
            (overlapping, self.overlapping),
        ];
        let listed = kinds.into_iter().filter(|(_, of)| !of.is_empty());
        listed
            .map(|(what, of)| format!("{what}: {}", of.join(", ")))
            .chain(self.notes)
            .collect()
    }
}
