//! A robot's files: URDF, SRDF and contacts, in the program or on disk.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Context, Result, anyhow, bail};
use robot_model::Robot;
use robot_model::load::Document;
use robot_model::propose::{Kinds, Surface};
use scenes::scene_file::RobotSource;

use crate::propose::{self, Proposal};
use crate::provenance::{self, Inputs};

mod robots;

pub use robots::Robots;

/// What a note begins with that says why contacts and SRDF were not proposed.
pub const UNPROPOSED: &str = "nothing was proposed";
/// What the name of a robot that ships begins with.
const BUILTIN: &str = "builtin:";

/// Where a robot's files are.
#[derive(Clone, Debug, Default, PartialEq, Eq, clap::Args)]
pub struct RobotFiles {
    /// The robot: a URDF file, - for the standard input, or builtin:NAME
    #[arg(long = "robot", value_name = "URDF")]
    pub urdf: String,
    /// What is beside it; for a robot that ships, where nothing is named, what ships.
    #[command(flatten)]
    pub beside: BesideUrdf,
}

/// The files of a robot beside its URDF.
#[derive(Clone, Debug, Default, PartialEq, Eq, clap::Args)]
pub struct BesideUrdf {
    /// Named postures and pairs of links that may touch
    #[arg(long, value_name = "FILE.srdf")]
    pub srdf: Option<PathBuf>,
    /// Contact patches
    #[arg(long, value_name = "FILE.toml")]
    pub contacts: Option<PathBuf>,
    /// A folder of ROS packages, for package:// names of meshes (repeatable; beside ROS_PACKAGE_PATH,
    /// AMENT_PREFIX_PATH and the folders above the URDF)
    #[arg(long = "package-path", value_name = "FOLDER")]
    pub packages: Vec<PathBuf>,
}

impl BesideUrdf {
    /// The flags that name these files.
    pub fn flags(&self) -> Vec<String> {
        let srdf = self.srdf.iter().map(|path| ("--srdf", path));
        let contacts = self.contacts.iter().map(|path| ("--contacts", path));
        let packages = self.packages.iter().map(|path| ("--package-path", path));
        let flags = srdf.chain(contacts).chain(packages);
        let words = flags.flat_map(|(name, path)| [name.to_owned(), path.display().to_string()]);
        words.collect()
    }
}

impl RobotFiles {
    /// A robot that ships, or the URDF alone.
    pub fn named(urdf: &str) -> Self {
        Self {
            urdf: urdf.to_owned(),
            ..Self::default()
        }
    }

    /// The files that a scene file in `folder` names.
    pub fn in_folder(folder: &Path, source: &RobotSource) -> Self {
        let urdf = if source.urdf.starts_with(BUILTIN) {
            source.urdf.clone()
        } else {
            folder.join(&source.urdf).display().to_string()
        };
        let path = |name: &Option<String>| name.as_ref().map(|name| folder.join(name));
        let beside = BesideUrdf {
            srdf: path(&source.srdf),
            contacts: path(&source.contacts),
            packages: Vec::new(),
        };
        Self { urdf, beside }
    }

    /// Whether the robot ships.
    pub fn is_builtin(&self) -> bool {
        self.urdf.starts_with(BUILTIN)
    }

    /// Reads the robot and notes its files among the inputs.
    ///
    /// # Errors
    /// A robot that does not ship, with those that do; else as [`robot_model::load()`].
    pub fn load(&self, config: &robot_model::Config, inputs: &mut Inputs) -> Result<Robot> {
        match self.urdf.strip_prefix(BUILTIN) {
            Some(name) => self.load_builtin(name, config, inputs),
            None => self.load_files(config, inputs),
        }
    }

    /// Reads the files; what is not given of SRDF and contacts is proposed, and a note says so.
    fn load_files(&self, config: &robot_model::Config, inputs: &mut Inputs) -> Result<Robot> {
        inputs.read("urdf", Path::new(&self.urdf))?;
        for (role, path) in [
            ("srdf", &self.beside.srdf),
            ("contacts", &self.beside.contacts),
        ] {
            if let Some(path) = path {
                inputs.read(role, path)?;
            }
        }
        let files = self.of_model(config)?;
        let is_standard = provenance::is_standard(&files.urdf);
        if let Some(document) = files.document.as_ref().filter(|_| !is_standard) {
            // What it includes counts, too.
            inputs.note("urdf of the MJCF", &self.urdf, document.urdf.as_bytes());
        }
        let bare = self.bare(&files)?;
        if self.beside.srdf.is_some() && self.beside.contacts.is_some() {
            return Ok(bare);
        }
        let proposal = match self.proposal(&bare, Kinds::default()) {
            Ok(proposal) => proposal,
            Err(why) => {
                let mut robot = bare;
                robot.notes.push(format!("{UNPROPOSED}: {why:#}"));
                return Ok(robot);
            }
        };
        let Proposal {
            contacts,
            srdf,
            notes,
        } = proposal;
        let mut robot = robot_model::load_with(&files, Some(&srdf), Some(&contacts))?;
        let mut proposed = Vec::new();
        if self.beside.contacts.is_none() {
            inputs.note("proposed contacts", &self.urdf, contacts.as_bytes());
            let names: Vec<&str> = robot.patches.iter().map(|p| p.name.as_str()).collect();
            proposed.push(format!("contacts ({})", names.join(", ")));
        }
        if self.beside.srdf.is_none() {
            inputs.note("proposed srdf", &self.urdf, srdf.as_bytes());
            proposed.push("posture and excepted pairs".to_owned());
        }
        let what = proposed.join(", ");
        let urdf = &self.urdf;
        robot.notes.push(format!(
            "no file gives {what}: proposed from the shapes (`scandent robot {urdf} --propose FOLDER` \
             writes the files to look at and to change)"
        ));
        robot.notes.extend(notes);
        Ok(robot)
    }

    /// The robot of these files, nothing proposed.
    ///
    /// # Errors
    /// As [`robot_model::load()`].
    pub fn bare(&self, files: &robot_model::RobotFiles) -> Result<Robot> {
        let robot = robot_model::load(files);
        if !provenance::is_standard(&files.urdf) {
            return Ok(robot?);
        }
        robot.context(
            "a URDF on the standard input (what it names beside itself is looked for from the current folder on \
             and under --package-path)",
        )
    }

    /// Contacts and SRDF for a robot of these files.
    ///
    /// # Errors
    /// As [`propose::propose`]; a surface file that is none.
    pub fn proposal(&self, bare: &Robot, kinds: Kinds) -> Result<Proposal> {
        let rsdf = surfaces_beside(Path::new(&self.urdf), &bare.name)?;
        propose::propose(bare, &rsdf, kinds, &posture::Config::default())
    }

    /// The files for the loader: packages as flags and the environment name them, MJCF read.
    ///
    /// # Errors
    /// MJCF that MuJoCo refuses, or that holds no robot.
    pub fn of_model(&self, config: &robot_model::Config) -> Result<robot_model::RobotFiles> {
        let is_named = |dir: &PathBuf| !dir.as_os_str().is_empty();
        // A browser has no variables, and no lists of paths.
        let listed = |variable: &str| {
            let list = std::env::var_os(variable).into_iter();
            let dirs = list.flat_map(|list| std::env::split_paths(&list).collect::<Vec<_>>());
            dirs.filter(is_named)
        };
        let shared = listed("AMENT_PREFIX_PATH").map(|prefix| prefix.join("share"));
        let packages = self.beside.packages.iter().cloned();
        Ok(robot_model::RobotFiles {
            urdf: PathBuf::from(&self.urdf),
            document: document(Path::new(&self.urdf))?,
            srdf: self.beside.srdf.clone(),
            contacts: self.beside.contacts.clone(),
            package_dirs: packages
                .chain(listed("ROS_PACKAGE_PATH"))
                .chain(shared)
                .filter(is_named)
                .collect(),
            config: config.clone(),
        })
    }

    fn load_builtin(
        &self,
        name: &str,
        config: &robot_model::Config,
        inputs: &mut Inputs,
    ) -> Result<Robot> {
        let robot = scenes::builtin_robot(name).ok_or_else(|| {
            let known: Vec<&str> = scenes::robot_names().collect();
            let known = known.join(", ");
            anyhow!("no robot {name:?} ships; those that do: {known}")
        })?;
        inputs.note("urdf", &self.urdf, robot.urdf.as_bytes());
        let mut text = |role: &str, path: &Option<PathBuf>, shipped: &str| -> Result<String> {
            match path {
                Some(path) => inputs.text(role, path),
                None => {
                    inputs.note(role, &self.urdf, shipped.as_bytes());
                    Ok(shipped.to_owned())
                }
            }
        };
        let srdf = text("srdf", &self.beside.srdf, robot.srdf)?;
        let contacts = text("contacts", &self.beside.contacts, robot.contacts)?;
        Ok(robot_model::load_from_strings(
            robot.urdf,
            Some(&srdf),
            Some(&contacts),
            name,
            &robot_model::load::no_meshes,
            config,
        )?)
    }
}

/// What makes MuJoCo's library callable, where that is loaded late.
pub static LOADS_MUJOCO: OnceLock<fn() -> Result<()>> = OnceLock::new();

/// What stands for a file that is not a URDF by its name: the standard input, or MJCF.
fn document(path: &Path) -> Result<Option<Document>> {
    if !provenance::is_standard(path) {
        return of_mjcf(path);
    }
    let text = Inputs::default().text("urdf", path)?;
    if robot_model::is_mjcf(&text) {
        bail!("-: MJCF is read from a file: it names others beside itself");
    }
    Ok(Some(Document {
        urdf: text,
        ..Document::default()
    }))
}

/// What MuJoCo reads of a file, if that is MJCF; without MuJoCo the loader says what it is.
#[cfg(feature = "mujoco")]
fn of_mjcf(path: &Path) -> Result<Option<Document>> {
    let is_mjcf = std::fs::read_to_string(path).is_ok_and(|text| robot_model::is_mjcf(&text));
    if !is_mjcf {
        return Ok(None);
    }
    if let Some(load) = LOADS_MUJOCO.get() {
        load()?;
    }
    Ok(Some(simulation::from_mjcf::document(path)?))
}

#[cfg(not(feature = "mujoco"))]
fn of_mjcf(_: &Path) -> Result<Option<Document>> {
    Ok(None)
}

/// The surfaces of the RSDF files for this robot in a folder `rsdf` beside the URDF or one above.
///
/// # Errors
/// A file that is no RSDF.
fn surfaces_beside(urdf: &Path, robot: &str) -> Result<Vec<Surface>> {
    let above = urdf.ancestors().skip(1).take(2);
    let folders = above.flat_map(|dir| [dir.join("rsdf"), dir.join("rsdf").join(robot)]);
    let mut files: Vec<PathBuf> = folders
        .filter_map(|folder| std::fs::read_dir(folder).ok())
        .flat_map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())))
        .filter(|path| path.extension().is_some_and(|e| e == "rsdf"))
        .collect();
    files.sort();
    let mut found = Vec::new();
    for path in files {
        let text = provenance::read("rsdf", &path)?;
        let text = String::from_utf8_lossy(&text);
        found.extend(robot_model::propose::surfaces(
            &path.display().to_string(),
            &text,
        )?);
    }
    Ok(found)
}
