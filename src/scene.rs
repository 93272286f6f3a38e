//! A scene: what is asked, and where the files that it names are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Matrix6, UnitQuaternion};
use scenes::SceneFile;
use scenes::scene_file::{self, Friction, Goal, Guide, ScanSource};
use toml::{Table, Value};

use crate::provenance::{self, Inputs};
use crate::robot_files::RobotFiles;

/// Everything that a plan is made from, its files not yet read.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name; the output folder is called after it.
    pub name: String,
    /// Where the environment is known from.
    pub environment: Environment,
    /// Covariance of the mount of each scan's sensor: rotation about and shift along W's axes, rad and
    /// m; nothing where poses are given.
    pub mounts: Vec<Option<Matrix6<f64>>>,
    /// The robot's files.
    pub robot: RobotFiles,
    /// Where the robot is.
    pub start: Start,
    /// Where it shall go.
    pub goal: Goal,
    /// The path that it should roughly follow; a line where there is none.
    pub guide: Option<Guide>,
    /// Coefficients of friction that replace those of the contacts file.
    pub friction: Friction,
    /// Settings to lay over the defaults.
    pub settings: Table,
    /// Where the environment's files are.
    pub files: Files,
}

/// Where the environment is known from.
#[derive(Clone, Debug)]
pub enum Environment {
    /// Scans with their poses.
    Scans(Vec<ScanSource>),
    /// A surface set that was extracted before.
    Surfaces(String),
    /// A mesh of the environment in W.
    Mesh(String),
}

/// Where the robot is before its first step.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// In a named posture.
    Posture {
        /// The SRDF's name of it; the resting posture where there is none.
        name: Option<String>,
        /// Values of joints in the place of its own, by name, rad or m.
        joints: BTreeMap<String, f64>,
        /// Pose of the base in W; without it the base is upright over the origin, the soles on
        /// z = 0.
        base: Option<Isometry3<f64>>,
        /// Moved on to just before the floor that is seen there.
        before_floor: bool,
        /// Patches that touch the ground; all feet where there are none.
        contacts: Vec<String>,
    },
    /// In a named posture over a place, the feet on the ground that is there.
    Over {
        /// As above.
        name: Option<String>,
        /// As above.
        joints: BTreeMap<String, f64>,
        /// Where the base is in W, x and y, m.
        at_m: [f64; 2],
        /// Its heading, rad.
        yaw_rad: f64,
        /// As above.
        contacts: Vec<String>,
    },
    /// With these patches at these poses, in a posture that is yet to be found.
    Contacts(Vec<(String, Isometry3<f64>)>),
}

impl Default for Start {
    /// In the resting posture over the origin, on all feet.
    fn default() -> Self {
        Self::Posture {
            name: None,
            joints: BTreeMap::new(),
            base: None,
            before_floor: false,
            contacts: Vec::new(),
        }
    }
}

/// Where the environment's files are.
#[derive(Clone, Debug)]
pub enum Files {
    /// In the program.
    Builtin(&'static scenes::Builtin),
    /// In a folder.
    Folder(PathBuf),
    /// At hand, by name.
    Memory(BTreeMap<String, Vec<u8>>),
}

impl Scene {
    /// Whether nothing says where the robot stands but the floor that is seen.
    pub fn starts_before_floor(&self) -> bool {
        let levelled = match &self.environment {
            Environment::Scans(sources) => sources.iter().any(|source| source.level),
            _ => false,
        };
        match self.start {
            Start::Posture {
                base: None,
                before_floor,
                ..
            } => levelled || before_floor,
            _ => false,
        }
    }

    /// Notes the environment's file among the inputs that no result may replace, before it is read.
    pub fn will_read(&self) {
        if let (Files::Folder(folder), Environment::Surfaces(name) | Environment::Mesh(name)) =
            (&self.files, &self.environment)
        {
            provenance::will_read(&folder.join(name));
        }
    }

    /// The scene of a name that ships, or of a `scene.toml`.
    ///
    /// # Errors
    /// A name that does not exist, with those that do; a file that cannot be read or is no scene.
    pub fn open(name_or_path: &str, inputs: &mut Inputs) -> Result<Self> {
        if let Some(builtin) = scenes::builtin(name_or_path) {
            let name = format!("builtin:{}", builtin.name);
            inputs.note("scene", &name, builtin.toml.as_bytes());
            return Self::parse(builtin.toml, Files::Builtin(builtin)).context(name);
        }
        let path = Path::new(name_or_path);
        let looks_like_a_path = path.extension().is_some()
            || path.components().count() > 1
            || provenance::is_standard(path);
        if !looks_like_a_path && !path.exists() {
            let known: Vec<&str> = scenes::names().collect();
            let known = known.join(", ");
            bail!(
                "no scene is called {name_or_path:?}; those that ship: {known}; or give a scene.toml"
            );
        }
        let text = inputs.text("scene", path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(&text, Files::Folder(folder)).with_context(|| name_or_path.to_owned())
    }

    /// The scene of a `scene.toml` that is at hand with the files that it names.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn at_hand(
        name: &str,
        files: BTreeMap<String, Vec<u8>>,
        inputs: &mut Inputs,
    ) -> Result<Self> {
        let files = Files::Memory(files);
        let text = provenance::text(name, files.read("scene", name, inputs)?)?;
        Self::parse(&text, files).with_context(|| name.to_owned())
    }

    fn parse(text: &str, files: Files) -> Result<Self> {
        let file = SceneFile::parse(text)?;
        let settings = settings(&file);
        let environment = match (file.surfaces_file, file.mesh_file) {
            (Some(name), _) => Environment::Surfaces(name),
            (None, Some(name)) => Environment::Mesh(name),
            (None, None) => Environment::Scans(file.scan),
        };
        let folder = match &files {
            Files::Builtin(_) | Files::Memory(_) => Path::new(""),
            Files::Folder(folder) => folder,
        };
        Ok(Self {
            name: file.name,
            environment,
            mounts: Vec::new(),
            robot: RobotFiles::in_folder(folder, &file.robot),
            start: Start::from(&file.start),
            goal: file.goal,
            guide: file.guide,
            friction: file.friction,
            settings,
            files,
        })
    }
}

impl From<&scene_file::Start> for Start {
    fn from(start: &scene_file::Start) -> Self {
        let pose = |position: [f64; 3], [roll, pitch, yaw]: [f64; 3]| {
            let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            Isometry3::from_parts(position.into(), rotation)
        };
        if !start.contact.is_empty() {
            let contacts = start.contact.iter();
            let contacts = contacts.map(|c| (c.patch.clone(), pose(c.position_m, c.rpy_rad)));
            return Start::Contacts(contacts.collect());
        }
        if let Some(at_m) = start.over_m {
            return Start::Over {
                name: start.posture.clone(),
                joints: start.joints_rad.clone(),
                at_m,
                yaw_rad: start.yaw_rad,
                contacts: start.contacts.clone(),
            };
        }
        Start::Posture {
            name: start.posture.clone(),
            joints: start.joints_rad.clone(),
            base: start.base_position_m.map(|p| pose(p, start.base_rpy_rad)),
            before_floor: start.before_floor,
            contacts: start.contacts.clone(),
        }
    }
}

impl Files {
    /// The bytes of one of the environment's files, noted among the inputs.
    ///
    /// # Errors
    /// A file that is not there, with its role and path.
    pub fn read(&self, role: &str, name: &str, inputs: &mut Inputs) -> Result<Vec<u8>> {
        match self {
            Files::Folder(folder) => inputs.read(role, &folder.join(name)),
            Files::Memory(files) => {
                let bytes = files.get(name);
                let bytes = bytes.with_context(|| format!("{name}: no such file is at hand"))?;
                inputs.note(role, name, bytes);
                Ok(bytes.clone())
            }
            Files::Builtin(scene) => {
                let bytes = scene.file(name);
                let bytes =
                    bytes.with_context(|| format!("builtin:{}: no file {name:?}", scene.name))?;
                inputs.note(role, &format!("builtin:{name}"), &bytes);
                Ok(bytes.into_owned())
            }
        }
    }
}

/// The settings of a scene file as one table of tables; roles are settings of the surfaces.
fn settings(file: &SceneFile) -> Table {
    let mut surfaces = file.surfaces.clone();
    if !file.roles.is_empty() {
        surfaces.insert("roles".to_owned(), Value::Table(file.roles.clone()));
    }
    let tables = [
        ("perception", &file.perception),
        ("ground", &file.ground),
        ("surfaces", &surfaces),
        ("robot_model", &file.robot_model),
        ("posture", &file.posture),
        ("motion", &file.motion),
        ("export", &file.export),
        ("planner", &file.planner),
    ];
    let given = tables.into_iter().filter(|(_, table)| !table.is_empty());
    let named = given.map(|(name, table)| (name.to_owned(), Value::Table(table.clone())));
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_that_ships_opens_and_has_its_files() {
        for name in scenes::names() {
            let mut inputs = Inputs::default();
            let scene = Scene::open(name, &mut inputs).unwrap();
            assert_eq!(scene.name, name);
            if let Environment::Scans(scans) = &scene.environment {
                assert!(!scans.is_empty(), "{name}");
                for scan in scans {
                    let file = scan.depth.as_ref().or(scan.cloud.as_ref()).unwrap();
                    scene.files.read("scan", file, &mut inputs).unwrap();
                    if let Some(mount) = &scan.extrinsics {
                        scene.files.read("extrinsics", mount, &mut inputs).unwrap();
                    }
                }
            }
            let layers = Some((name, &scene.settings));
            crate::config::Config::layered(layers, &Default::default()).unwrap();
        }
    }

    #[test]
    fn a_scene_may_start_on_contacts_and_set_every_stage() {
        let text = r#"
            name = "by-hand"
            mesh_file = "world.stl"
            robot = { urdf = "builtin:hrp2" }
            goal = { base_position_m = [1.0, 0.0] }
            robot_model = { lenient = true }
            motion = { dt_s = 0.005 }
            export = { robot = "mc_hrp2" }
            [[start.contact]]
            patch = "left_foot"
            position_m = [0.0, 0.1, 0.0]
            rpy_rad = [0.0, 0.0, 0.3]
        "#;
        let scene = Scene::parse(text, Files::Folder(PathBuf::new())).unwrap();
        let pose = Isometry3::new([0.0, 0.1, 0.0].into(), [0.0, 0.0, 0.3].into());
        let contacts = vec![("left_foot".to_owned(), pose)];
        assert_eq!(scene.start, Start::Contacts(contacts));
        let layers = Some((scene.name.as_str(), &scene.settings));
        let config = crate::config::Config::layered(layers, &Default::default()).unwrap();
        assert!(config.robot_model.lenient);
        assert_eq!(config.motion.dt_s, 0.005);
        assert_eq!(config.export.robot.as_deref(), Some("mc_hrp2"));
    }
}
