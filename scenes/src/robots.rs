//! The robots that ship.

use robot_model::load::no_meshes;
use robot_model::{Robot, load_from_strings};

/// A robot's three files, embedded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltinRobot {
    /// Name, as in `builtin:NAME`.
    pub name: &'static str,
    /// Links, joints, masses, shapes.
    pub urdf: &'static str,
    /// Named postures and pairs that are never checked.
    pub srdf: &'static str,
    /// Contact patches.
    pub contacts: &'static str,
}

impl BuiltinRobot {
    /// The robot that the files describe.
    ///
    /// # Errors
    /// As [`robot_model::load_from_strings`]; none with the default settings.
    pub fn load(&self, config: &robot_model::Config) -> Result<Robot, robot_model::Error> {
        load_from_strings(
            self.urdf,
            Some(self.srdf),
            Some(self.contacts),
            self.name,
            &no_meshes,
            config,
        )
    }
}

macro_rules! robot {
    ($name:literal) => {
        BuiltinRobot {
            name: $name,
            urdf: include_str!(concat!("../robots/", $name, "/", $name, ".urdf")),
            srdf: include_str!(concat!("../robots/", $name, "/", $name, ".srdf")),
            contacts: include_str!(concat!("../robots/", $name, "/contacts.toml")),
        }
    };
}

static ROBOTS: [BuiltinRobot; 4] = [
    robot!("hrp2"),
    robot!("hexapod"),
    robot!("hexapod_urp"),
    robot!("quadruped"),
];

/// The robot of this name.
pub fn builtin_robot(name: &str) -> Option<&'static BuiltinRobot> {
    ROBOTS.iter().find(|robot| robot.name == name)
}

/// The robot of this name, by the default settings.
pub fn robot(name: &str) -> Option<Robot> {
    builtin_robot(name)?.load(&Default::default()).ok()
}

/// Names of all robots that ship.
pub fn robot_names() -> impl Iterator<Item = &'static str> {
    ROBOTS.iter().map(|robot| robot.name)
}
