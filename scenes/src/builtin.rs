//! The scenes that ship: scene file, scan and true world, embedded in the program.

use nalgebra::Isometry3;

use crate::truth::Truth;
use crate::worlds;

/// A scene that ships.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name.
    pub name: &'static str,
    /// The scene file; the files it names are in `files`.
    pub toml: &'static str,
    /// Name and bytes of every file that the scene file names.
    pub files: &'static [(&'static str, &'static [u8])],
    /// Builds the true world that the scan was taken of.
    pub truth: fn() -> Truth,
    /// Seed of the scan's noise.
    pub seed: u64,
    /// The sensor's true pose in W, where the scene file takes it from an identified mount.
    pub sensor: Option<fn() -> Isometry3<f64>>,
}

static SCENES: [Builtin; 3] = [
    Builtin {
        name: "irregular-stairs",
        toml: include_str!("../scenes/irregular-stairs.toml"),
        files: &[(
            "irregular-stairs_depth.png",
            include_bytes!("../scenes/irregular-stairs_depth.png"),
        )],
        truth: worlds::irregular_stairs::truth,
        seed: 1,
        sensor: None,
    },
    Builtin {
        name: "slope-and-hand",
        toml: include_str!("../scenes/slope-and-hand.toml"),
        files: &[(
            "slope-and-hand_depth.png",
            include_bytes!("../scenes/slope-and-hand_depth.png"),
        )],
        truth: worlds::slope_and_hand::truth,
        seed: 2,
        sensor: None,
    },
    Builtin {
        name: "hexapod-obstacles",
        toml: include_str!("../scenes/hexapod-obstacles.toml"),
        files: &[
            (
                "hexapod-obstacles_depth.png",
                include_bytes!("../scenes/hexapod-obstacles_depth.png"),
            ),
            (
                "hexapod-obstacles_camera.toml",
                include_bytes!("../scenes/hexapod-obstacles_camera.toml"),
            ),
        ],
        truth: worlds::hexapod_obstacles::truth,
        seed: 1,
        sensor: Some(worlds::hexapod_obstacles::X_WV),
    },
];

/// The scene of this name.
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    SCENES.iter().find(|scene| scene.name == name)
}

/// Names of all scenes that ship.
pub fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|scene| scene.name)
}

impl Builtin {
    /// The bytes of a file that the scene file names.
    pub fn file(&self, name: &str) -> Option<&'static [u8]> {
        self.files
            .iter()
            .find(|(file, _)| *file == name)
            .map(|(_, bytes)| *bytes)
    }
}
