//! URDF + SRDF + contacts file → [`Robot`].
//!
//! 1. `urdf` reads the file through urdf-rs; `tree` says whether its links make a tree.
//! 2. `lump` makes moving bodies of it, `inertia` weighs them, `shapes` gives them hulls.
//! 3. `srdf` adds postures and disables pairs; `contacts` adds patches; `overlaps` excepts shapes that
//!    cannot be told apart.

mod contacts;
mod inertia;
mod lump;
mod overlaps;
mod package;
mod shapes;
mod srdf;
mod tree;
mod urdf;

pub use contacts::schema as contacts_schema;
pub use overlaps::sampled;
pub(crate) use overlaps::{NEAR_M, are_neighbours};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::collision::CollisionModel;
use crate::{Config, Error, Robot};

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
    /// What stands for the file at `urdf` where that is of another format.
    pub document: Option<Document>,
}

/// A robot that another format was read into, or that is no file.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Its URDF.
    pub urdf: String,
    /// Named postures and pairs that the format disables, to which an SRDF adds; nothing where it is empty.
    pub srdf: String,
    /// The bytes of meshes by the names that the URDF has for them.
    pub meshes: BTreeMap<String, Vec<u8>>,
    /// What was approximated.
    pub notes: Vec<String>,
}

impl RobotFiles {
    /// A URDF alone.
    pub fn new(urdf: impl Into<PathBuf>) -> Self {
        RobotFiles {
            urdf: urdf.into(),
            ..RobotFiles::default()
        }
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
    load_with(files, None, None)
}

/// Reads a robot from its files, these texts in the place of an SRDF or a contacts file that is not
/// there.
///
/// # Errors
/// As [`load`].
pub fn load_with(
    files: &RobotFiles,
    srdf: Option<&str>,
    contacts: Option<&str>,
) -> Result<Robot, Error> {
    let named = |path: &PathBuf| Ok((path.display().to_string(), read_text(path)?));
    let or = |path: &Option<PathBuf>, text: Option<&str>, kind: &str| match (path, text) {
        (Some(path), _) => named(path).map(Some),
        (None, text) => Ok(text.map(|text| (format!("proposed {kind}"), text.to_owned()))),
    };
    let document = files.document.as_ref();
    let read_as = |text: &String| {
        (
            format!("{} (read as URDF)", files.urdf.display()),
            text.clone(),
        )
    };
    let texts = Texts {
        urdf: match document {
            Some(document) => read_as(&document.urdf),
            None => named(&files.urdf)?,
        },
        srdf: (document.into_iter())
            .filter(|document| !document.srdf.is_empty())
            .map(|document| read_as(&document.srdf))
            .chain(or(&files.srdf, srdf, "SRDF")?)
            .collect(),
        contacts: or(&files.contacts, contacts, "contacts")?,
    };
    // An absolute folder has all of its parents to look for packages in.
    let urdf_path = std::path::absolute(&files.urdf).unwrap_or_else(|_| files.urdf.clone());
    let urdf_dir = urdf_path.parent().unwrap_or(Path::new(".")).to_owned();
    let meshes = |filename: &str| {
        if let Some(bytes) = document.and_then(|document| document.meshes.get(filename)) {
            return Ok(bytes.clone());
        }
        let path = package::find(filename, &urdf_dir, &files.package_dirs)?;
        std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let mut robot = assemble(&texts, &meshes, &files.config)?;
    let read = document
        .iter()
        .flat_map(|document| document.notes.iter().cloned());
    robot.notes.splice(0..0, read);
    Ok(robot)
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
        srdf: (srdf.iter())
            .map(|text| (format!("{name}.srdf"), (*text).to_owned()))
            .collect(),
        contacts: contacts.map(|text| (format!("{name} contacts"), text.to_owned())),
    };
    assemble(&texts, meshes, config)
}

/// Each file's name and text.
struct Texts {
    urdf: (String, String),
    srdf: Vec<(String, String)>,
    contacts: Option<(String, String)>,
}

/// The robot of the texts, or all that is wrong with them.
fn assemble(texts: &Texts, meshes: &MeshSource, config: &Config) -> Result<Robot, Error> {
    let mut findings = Findings {
        lenient: config.lenient,
        ..Findings::default()
    };
    let read = put_together(texts, meshes, config, &mut findings);
    let refused = std::mem::take(&mut findings.refused);
    let mut robot = match read {
        Err(error) => return Err(error.after(refused)),
        Ok(robot) => Error::all(refused).map(|()| robot)?,
    };
    robot.notes = findings.into_notes();
    Ok(robot)
}

fn put_together(
    texts: &Texts,
    meshes: &MeshSource,
    config: &Config,
    findings: &mut Findings,
) -> Result<Robot, Error> {
    // The URDF: tree, bodies, shapes.
    let (file, text) = &texts.urdf;
    let urdf = urdf::parse(file, text)?;
    let tree = tree::of(file, &urdf)?;
    let held = (texts.contacts.iter())
        .flat_map(|(_, text)| contacts::held(text))
        .collect();
    let lumped = lump::lump(file, &urdf, &tree, &held, findings)?;
    let mut reader = shapes::ShapeReader {
        file,
        meshes,
        hulls: BTreeMap::new(),
    };
    let shapes = reader.read(&urdf.robot.links, &lumped.places, findings)?;
    let collision = CollisionModel::new(shapes, &lumped.bodies);
    let mut robot = Robot::new(urdf.robot.name, lumped.bodies, lumped.frames, collision)?;
    // What the other files add.
    for (file, text) in &texts.srdf {
        let applied = srdf::apply(file, text, &mut robot, findings);
        findings.kept(applied);
    }
    if let Some((file, text)) = &texts.contacts {
        let patches = contacts::read(file, text, &robot);
        robot.set_patches(findings.kept(patches).unwrap_or_default());
    }
    overlaps::except(&mut robot, config, findings);
    Ok(robot)
}

fn read_text(path: &Path) -> Result<String, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io {
        path: path.to_owned(),
        source,
    })?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let cause = format!("byte {} is no UTF-8 text", error.utf8_error().valid_up_to());
        Error::file(path.display(), cause)
    })?;
    // Some editors begin a text with a byte-order mark.
    Ok(text.trim_start_matches('\u{feff}').to_owned())
}

/// What was assumed on the way, and what is refused once all was looked at, to be told to the user.
#[derive(Default)]
struct Findings {
    lenient: bool,
    refused: Vec<Error>,
    notes: Vec<String>,
    /// What was found of several things, in the order of its first appearance, and those things.
    lists: Vec<(&'static str, Vec<String>)>,
}

impl Findings {
    fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Adds `thing` to those of which `what` is to be told.
    fn list(&mut self, what: &'static str, thing: impl Into<String>) {
        match self.lists.iter_mut().find(|(of, _)| *of == what) {
            Some((_, things)) => things.push(thing.into()),
            None => self.lists.push((what, vec![thing.into()])),
        }
    }

    /// What was read, or nothing and its error among those refused.
    fn kept<T>(&mut self, read: Result<T, Error>) -> Option<T> {
        read.map_err(|error| self.refused.push(error)).ok()
    }

    /// Refuses, or notes where that is wanted.
    fn refuse_unless_lenient(&mut self, error: Error) {
        match self.lenient {
            true => self.note(format!("{error} (read on, as asked)")),
            false => self.refused.push(Error::Strict(Box::new(error))),
        }
    }

    fn into_notes(self) -> Vec<String> {
        let lists = self.lists.into_iter();
        let lists = lists.map(|(what, things)| format!("{what}: {}", things.join(", ")));
        lists.chain(self.notes).collect()
    }
}
