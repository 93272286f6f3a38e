//! The scenes that ship: scene file, scan and true world, embedded in the program.

use std::borrow::Cow;

use nalgebra::Isometry3;

use crate::simulator::lidar;
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
    /// Name of a sweep that the scene file names and the simulator takes when it is asked for: a
    /// lidar's file is larger than the world that it shows.
    pub sweep: Option<&'static str>,
    /// Builds the true world that the scan was taken of.
    pub truth: fn() -> Truth,
    /// Seed of the scan's noise.
    pub seed: u64,
    /// The sensor's true pose in W, where the scene file takes it from an identified mount.
    pub sensor: Option<fn() -> Isometry3<f64>>,
}

static SCENES: [Builtin; 12] = [
    Builtin {
        name: "irregular-stairs",
        toml: include_str!("../scenes/irregular-stairs.toml"),
        files: &[(
            "irregular-stairs_depth.png",
            include_bytes!("../scenes/irregular-stairs_depth.png"),
        )],
        sweep: None,
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
        sweep: None,
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
        sweep: None,
        truth: worlds::hexapod_obstacles::truth,
        seed: 1,
        sensor: Some(worlds::hexapod_obstacles::X_WV),
    },
    Builtin {
        name: "slope-10.5",
        toml: include_str!("../scenes/slope-10.5.toml"),
        files: &[],
        sweep: Some("slope-10.5.pcd"),
        truth: worlds::slope::truth::<0>,
        seed: 3,
        sensor: None,
    },
    Builtin {
        name: "slope-13.5",
        toml: include_str!("../scenes/slope-13.5.toml"),
        files: &[],
        sweep: Some("slope-13.5.pcd"),
        truth: worlds::slope::truth::<1>,
        seed: 4,
        sensor: None,
    },
    Builtin {
        name: "slope-15.3",
        toml: include_str!("../scenes/slope-15.3.toml"),
        files: &[],
        sweep: Some("slope-15.3.pcd"),
        truth: worlds::slope::truth::<2>,
        seed: 5,
        sensor: None,
    },
    Builtin {
        name: "slope-17.4",
        toml: include_str!("../scenes/slope-17.4.toml"),
        files: &[],
        sweep: Some("slope-17.4.pcd"),
        truth: worlds::slope::truth::<3>,
        seed: 6,
        sensor: None,
    },
    Builtin {
        name: "slope-19.7",
        toml: include_str!("../scenes/slope-19.7.toml"),
        files: &[],
        sweep: Some("slope-19.7.pcd"),
        truth: worlds::slope::truth::<4>,
        seed: 7,
        sensor: None,
    },
    Builtin {
        name: "slope-22",
        toml: include_str!("../scenes/slope-22.toml"),
        files: &[],
        sweep: Some("slope-22.pcd"),
        truth: worlds::slope::truth::<5>,
        seed: 8,
        sensor: None,
    },
    Builtin {
        name: "slope-23.8",
        toml: include_str!("../scenes/slope-23.8.toml"),
        files: &[],
        sweep: Some("slope-23.8.pcd"),
        truth: worlds::slope::truth::<6>,
        seed: 9,
        sensor: None,
    },
    Builtin {
        name: "slope-10.5-at-30",
        toml: include_str!("../scenes/slope-10.5-at-30.toml"),
        files: &[],
        sweep: Some("slope-10.5-at-30.pcd"),
        truth: worlds::slope::turned::<0>,
        seed: 10,
        sensor: None,
    },
    Builtin {
        name: "slope-23.8-at-30",
        toml: include_str!("../scenes/slope-23.8-at-30.toml"),
        files: &[],
        sweep: Some("slope-23.8-at-30.pcd"),
        truth: worlds::slope::turned::<6>,
        seed: 11,
        sensor: None,
    },
];

/// The scene of this name; a slope's may leave its fraction out (`slope-15`).
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    let exact = SCENES.iter().find(|scene| scene.name == name);
    exact.or_else(|| {
        let of_degrees = |scene: &&Builtin| {
            scene.name.starts_with("slope-")
                && scene
                    .name
                    .split_once('.')
                    .is_some_and(|(whole, _)| whole == name)
        };
        SCENES.iter().find(of_degrees)
    })
}

/// Names of all scenes that ship.
pub fn names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|scene| scene.name)
}

impl Builtin {
    /// The bytes of a file that the scene file names.
    pub fn file(&self, name: &str) -> Option<Cow<'static, [u8]>> {
        if self.sweep == Some(name) {
            return Some(Cow::Owned(lidar::pcd(&self.sweep()?)));
        }
        self.files
            .iter()
            .find(|(file, _)| *file == name)
            .map(|(_, bytes)| Cow::Borrowed(*bytes))
    }

    /// The sweep that the simulated lidar takes from where the scene file says.
    #[allow(non_snake_case)]
    fn sweep(&self) -> Option<lidar::Sweep> {
        let file = crate::SceneFile::parse(self.toml).ok()?;
        let source = file
            .scan
            .iter()
            .find(|s| s.cloud.as_deref() == self.sweep)?;
        let X_WV = source.X_WV();
        let world = (self.truth)().world();
        let (sensor, noise) = (lidar::Vlp16::default(), lidar::RangeNoise::default());
        Some(lidar::sweep(
            &world, &sensor, &X_WV, &noise, self.seed, self.seed,
        ))
    }
}
