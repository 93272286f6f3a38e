//! Pages of the folder's files.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use scenes::SceneFile;
use serde_json::{Value, json};
use surfaces::Terrain;
use toml::Table;

use super::folder::Folder;
use super::{Refusal, bad, refuse};
use crate::argument;
use crate::cli::Global;
use crate::command::view::open_surfaces;
use crate::config::Config;
use crate::environment::{self, Perceived, levelled::levelled};
use crate::environment_flags::ScanFlags;
use crate::goal::suggested;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files, Scene};
use crate::threads;
use crate::view::{SurfacesInput, surfaces_page};

/// The tables of a scene that the page has no form for: they go through it as they are.
const SETTINGS: [&str; 9] = [
    "roles",
    "guide",
    "ground",
    "surfaces",
    "robot_model",
    "posture",
    "motion",
    "export",
    "planner",
];

/// The page of surfaces, of a scene, of a mesh or of a scan, which is levelled: `builtin:NAME`, or a file's name; of a
/// scan with the sensor that took it.
pub(super) fn edit(
    folder: &Folder,
    name: &str,
    sensor: &str,
    global: &Global,
) -> Result<String, Refusal> {
    let robots = robots(folder);
    if let Some(scene) = name.strip_prefix("builtin:") {
        let shipped = scenes::builtin(scene);
        let shipped = shipped.ok_or_else(|| Refusal(404, format!("no scene {scene:?} ships")))?;
        return scene_page(scene, shipped.toml, &robots, global).map_err(bad);
    }
    let path = folder.file(name)?;
    match kind(name) {
        Some(Kind::Scene) => {
            let text = std::fs::read_to_string(&path);
            let text = text.map_err(|cause| Refusal(400, format!("{name}: {cause}")))?;
            let scene = SceneFile::parse(&text).with_context(|| name.to_owned());
            folder.holds(&scene.map_err(bad)?)?;
            scene_page(&path.display().to_string(), &text, &robots, global).map_err(bad)
        }
        Some(Kind::Surfaces) => surfaces(name, &path, &robots, global).map_err(bad),
        Some(Kind::Mesh) => {
            let mesh = Environment::Mesh(path.display().to_string());
            unasked(name, &mesh, &robots, global).map_err(bad)
        }
        Some(Kind::Scan) => {
            let sensor = (!sensor.is_empty()).then(|| argument::sensor(sensor));
            let sensor = sensor.transpose().map_err(|why| Refusal(400, why))?;
            let how = ScanFlags {
                sensor,
                level: true,
                ..ScanFlags::default()
            };
            let scan = how.scans(&[path], &mut Inputs::default()).map_err(bad)?;
            unasked(name, &scan, &robots, global).map_err(bad)
        }
        None => refuse(
            400,
            format!(
                "{name}: neither a scene (.toml), surfaces (.json), a mesh (.stl, .obj) nor a scan"
            ),
        ),
    }
}

/// What a file that can be edited holds, by its name.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scene,
    Surfaces,
    Mesh,
    Scan,
}

/// The kind of a file.
pub(super) fn kind(name: &str) -> Option<Kind> {
    let (_, ending) = name.rsplit_once('.')?;
    match ending.to_ascii_lowercase().as_str() {
        "toml" => Some(Kind::Scene),
        "json" => Some(Kind::Surfaces),
        "stl" | "obj" | "dae" | "glb" | "gltf" => Some(Kind::Mesh),
        "png" | "tif" | "tiff" | "npy" | "npz" | "pcd" | "ply" | "las" | "e57" | "mcap" | "xyz"
        | "asc" | "pts" => Some(Kind::Scan),
        _ => None,
    }
}

/// The URDFs of the folder.
fn robots(folder: &Folder) -> Vec<String> {
    let mut files = folder.files();
    files.retain(|name| name.to_ascii_lowercase().ends_with(".urdf"));
    files
}

fn surfaces(name: &str, path: &Path, robots: &[String], global: &Global) -> Result<String> {
    let seen = Perceived {
        terrain: open_surfaces(path)?,
        ..Perceived::default()
    };
    let config = Config::layered(None, global)?;
    page(name, &seen, &config, &unset(&seen.terrain, &config), robots)
}

/// What a form begins with for surfaces of which nothing is asked yet: a goal that is suggested.
fn unset(terrain: &Terrain, config: &Config) -> Value {
    match suggested(terrain, config) {
        Some(place) => json!({ "goal": { "base_position_m": place } }),
        None => json!({}),
    }
}

/// The page of the surfaces of a mesh or of a scan that is levelled.
fn unasked(name: &str, source: &Environment, robots: &[String], global: &Global) -> Result<String> {
    let config = Config::layered(None, global)?;
    let files = Files::Folder(PathBuf::new());
    let seen = perceived(source, &files, &config, global)?;
    let mut asked = unset(&seen.terrain, &config);
    if matches!(source, Environment::Scans(_)) {
        asked["start"] = json!({ "before_floor": true });
    }
    page(name, &seen, &config, &asked, robots)
}

fn perceived(
    source: &Environment,
    files: &Files,
    config: &Config,
    global: &Global,
) -> Result<Perceived> {
    let (source, _) = levelled(source, files, config)?;
    let (mut stages, mut inputs) = (Stages::default(), Inputs::default());
    let read = || environment::perceive(&source, files, config, &mut stages, &mut inputs);
    threads::pool(global.threads)?.install(read)
}

/// The page of a scene's surfaces, with what it asks.
fn scene_page(name: &str, text: &str, robots: &[String], global: &Global) -> Result<String> {
    let mut inputs = Inputs::default();
    let scene = Scene::open(name, &mut inputs)?;
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    let seen = perceived(&scene.environment, &scene.files, &config, global)?;
    let mut table: Table = text.parse()?;
    let mut settings = Table::new();
    for key in SETTINGS {
        settings.extend(table.remove(key).map(|value| (key.to_owned(), value)));
    }
    let mut asked = json!({ "settings": toml::to_string(&settings)? });
    for key in ["robot", "start", "goal", "friction"] {
        if let Some(value) = table.get(key) {
            asked[key] = serde_json::to_value(value)?;
        }
    }
    if scene.starts_before_floor() {
        asked["start"]["before_floor"] = json!(true);
    }
    page(&scene.name, &seen, &config, &asked, robots)
}

fn page(
    name: &str,
    seen: &Perceived,
    config: &Config,
    asked: &Value,
    robots: &[String],
) -> Result<String> {
    surfaces_page(&SurfacesInput {
        name,
        terrain: &seen.terrain,
        cloud_W: &seen.cloud_W,
        config,
        asked,
        robots,
        served: true,
    })
}

/// The page of a plan that is in the folder.
pub(super) fn show(folder: &Folder, name: &str) -> Result<String, Refusal> {
    let path: PathBuf = folder.file(name)?;
    if path.file_name().is_none_or(|file| file != "view.html") {
        return refuse(
            400,
            format!("{name}: only pages of plans, view.html, are shown"),
        );
    }
    std::fs::read_to_string(&path).map_err(|cause| Refusal(400, format!("{name}: {cause}")))
}
