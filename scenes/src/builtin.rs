//! The scenes that ship: scene file, scan and true world, embedded in the program.

use std::borrow::Cow;

use nalgebra::Isometry3;

use crate::scene_file::ScanSource;
use crate::simulator::{DepthNoise, KINECT, Pinhole, Scan, XTION, lidar, scan};
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

/// A scene that a depth camera shows: its name, world, seed, true sensor pose and further files.
macro_rules! depth_scene {
    ($name:literal, $world:ident, $seed:literal, $sensor:expr, [$($file:literal),*]) => {
        Builtin {
            name: $name,
            toml: include_str!(concat!("../scenes/", $name, ".toml")),
            files: &[
                (
                    concat!($name, "_depth.png"),
                    include_bytes!(concat!("../scenes/", $name, "_depth.png")),
                ),
                $(($file, include_bytes!(concat!("../scenes/", $file))),)*
            ],
            sweep: None,
            truth: worlds::$world::truth,
            seed: $seed,
            sensor: $sensor,
        }
    };
}

/// A ramp that a lidar sweeps: its name, world and seed.
macro_rules! slope {
    ($name:literal, $truth:expr, $seed:literal) => {
        Builtin {
            name: $name,
            toml: include_str!(concat!("../scenes/", $name, ".toml")),
            files: &[],
            sweep: Some(concat!($name, ".pcd")),
            truth: $truth,
            seed: $seed,
            sensor: None,
        }
    };
}

static SCENES: [Builtin; 12] = [
    depth_scene!("irregular-stairs", irregular_stairs, 1, None, []),
    depth_scene!("slope-and-hand", slope_and_hand, 2, None, []),
    depth_scene!(
        "hexapod-obstacles",
        hexapod_obstacles,
        1,
        Some(worlds::hexapod_obstacles::X_WV),
        ["hexapod-obstacles_camera.toml"]
    ),
    slope!("slope-10.5", worlds::slope::truth::<0>, 3),
    slope!("slope-13.5", worlds::slope::truth::<1>, 4),
    slope!("slope-15.3", worlds::slope::truth::<2>, 5),
    slope!("slope-17.4", worlds::slope::truth::<3>, 6),
    slope!("slope-19.7", worlds::slope::truth::<4>, 7),
    slope!("slope-22", worlds::slope::truth::<5>, 8),
    slope!("slope-23.8", worlds::slope::truth::<6>, 9),
    slope!("slope-10.5-at-30", worlds::slope::turned::<0>, 10),
    slope!("slope-23.8-at-30", worlds::slope::turned::<6>, 11),
];

/// The scene of this name; a slope's may leave its fraction out (`slope-15`).
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    let exact = SCENES.iter().find(|scene| scene.name == name);
    exact.or_else(|| {
        let of_degrees = |scene: &&Builtin| {
            let whole = scene.name.split_once('.').map(|(whole, _)| whole);
            scene.name.starts_with("slope-") && whole == Some(name)
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
            return Some(Cow::Owned(lidar::pcd(&self.sweep(self.seed)?)));
        }
        let file = self.files.iter().find(|(file, _)| *file == name);
        file.map(|(_, bytes)| Cow::Borrowed(*bytes))
    }

    /// The one scan of its scene file.
    pub fn source(&self) -> Option<ScanSource> {
        crate::SceneFile::parse(self.toml).ok()?.scan.pop()
    }

    /// The sensor's true pose in W.
    pub fn X_WV(&self) -> Option<Isometry3<f64>> {
        let stated = || Some(self.source()?.X_WV());
        self.sensor.map_or_else(stated, |pose| Some(pose()))
    }

    /// The depth camera, where the scene file has a picture.
    pub fn camera(&self) -> Option<&'static Pinhole> {
        let source = self.source()?;
        source.depth?;
        match source.sensor.as_deref() {
            Some("kinect_v1") => Some(&KINECT),
            _ => Some(&XTION),
        }
    }

    /// The picture that the simulated camera takes, where the scene file has one.
    pub fn picture(&self, noise: &DepthNoise, seed: u64) -> Option<Scan> {
        let (world, camera) = ((self.truth)().world(), self.camera()?);
        Some(scan(&world, camera, &self.X_WV()?, noise, seed))
    }

    /// The sweep that the simulated lidar takes, where the scene file has one.
    pub fn sweep(&self, seed: u64) -> Option<lidar::Sweep> {
        self.sweep?;
        let (sensor, noise) = (lidar::Vlp16::default(), lidar::RangeNoise::default());
        let (world, X_WV) = ((self.truth)().world(), self.X_WV()?);
        Some(lidar::sweep(&world, &sensor, &X_WV, &noise, seed, seed))
    }
}
