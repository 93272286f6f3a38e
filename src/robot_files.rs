//! A robot's files: URDF, SRDF and contacts, in the program or on disk.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use robot_model::Robot;
use scenes::scene_file::RobotSource;

use crate::provenance::Inputs;

/// What the name of a robot that ships begins with.
const BUILTIN: &str = "builtin:";

/// Where a robot's files are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotFiles {
    /// A path, or `builtin:NAME`.
    pub urdf: String,
    /// Postures and disabled pairs; those that ship for a robot that ships.
    pub srdf: Option<PathBuf>,
    /// Contact patches; those that ship for a robot that ships.
    pub contacts: Option<PathBuf>,
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
        let beside = |name: &Option<String>| name.as_ref().map(|name| folder.join(name));
        Self {
            urdf,
            srdf: beside(&source.srdf),
            contacts: beside(&source.contacts),
        }
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

    fn load_files(&self, config: &robot_model::Config, inputs: &mut Inputs) -> Result<Robot> {
        let urdf = PathBuf::from(&self.urdf);
        inputs.read("urdf", &urdf)?;
        for (role, path) in [("srdf", &self.srdf), ("contacts", &self.contacts)] {
            if let Some(path) = path {
                inputs.read(role, path)?;
            }
        }
        let files = robot_model::RobotFiles {
            urdf,
            srdf: self.srdf.clone(),
            contacts: self.contacts.clone(),
            package_dirs: Vec::new(),
            config: config.clone(),
        };
        Ok(robot_model::load(&files)?)
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
                Some(path) => String::from_utf8(inputs.read(role, path)?)
                    .with_context(|| format!("{}: not a text file", path.display())),
                None => {
                    inputs.note(role, &self.urdf, shipped.as_bytes());
                    Ok(shipped.to_owned())
                }
            }
        };
        let srdf = text("srdf", &self.srdf, robot.srdf)?;
        let contacts = text("contacts", &self.contacts, robot.contacts)?;
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

/// The robot on the command line.
#[derive(Clone, Debug, clap::Args)]
pub struct RobotFlags {
    /// The robot: a URDF file, or builtin:NAME
    #[arg(long, value_name = "URDF")]
    pub robot: String,
    #[command(flatten)]
    beside: BesideUrdf,
}

impl RobotFlags {
    /// The files.
    pub fn files(&self) -> RobotFiles {
        self.beside.files(&self.robot)
    }
}

/// The files of a robot beside its URDF, on the command line.
#[derive(Clone, Debug, clap::Args)]
pub struct BesideUrdf {
    /// Named postures and pairs of links that may touch
    #[arg(long, value_name = "FILE.srdf")]
    pub srdf: Option<PathBuf>,
    /// Contact patches
    #[arg(long, value_name = "FILE.toml")]
    pub contacts: Option<PathBuf>,
}

impl BesideUrdf {
    /// These files and the URDF.
    pub fn files(&self, urdf: &str) -> RobotFiles {
        RobotFiles {
            urdf: urdf.to_owned(),
            srdf: self.srdf.clone(),
            contacts: self.contacts.clone(),
        }
    }
}
