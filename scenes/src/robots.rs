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

static ROBOTS: [BuiltinRobot; 4] = [
    BuiltinRobot {
        name: "hrp2",
        urdf: include_str!("../robots/hrp2/hrp2.urdf"),
        srdf: include_str!("../robots/hrp2/hrp2.srdf"),
        contacts: include_str!("../robots/hrp2/contacts.toml"),
    },
    BuiltinRobot {
        name: "hexapod",
        urdf: include_str!("../robots/hexapod/hexapod.urdf"),
        srdf: include_str!("../robots/hexapod/hexapod.srdf"),
        contacts: include_str!("../robots/hexapod/contacts.toml"),
    },
    BuiltinRobot {
        name: "hexapod_urp",
        urdf: include_str!("../robots/hexapod_urp/hexapod_urp.urdf"),
        srdf: include_str!("../robots/hexapod_urp/hexapod_urp.srdf"),
        contacts: include_str!("../robots/hexapod_urp/contacts.toml"),
    },
    BuiltinRobot {
        name: "quadruped",
        urdf: include_str!("../robots/quadruped/quadruped.urdf"),
        srdf: include_str!("../robots/quadruped/quadruped.srdf"),
        contacts: include_str!("../robots/quadruped/contacts.toml"),
    },
];

/// The robot of this name.
pub fn builtin_robot(name: &str) -> Option<&'static BuiltinRobot> {
    ROBOTS.iter().find(|robot| robot.name == name)
}

/// Names of all robots that ship.
pub fn robot_names() -> impl Iterator<Item = &'static str> {
    ROBOTS.iter().map(|robot| robot.name)
}
