//! Pages of the folder's files.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use scenes::SceneFile;
use serde_json::{Value, json};
use surfaces::Terrain;
use toml::Table;

use super::folder::Folder;
use super::{Refusal, bad, refuse};
use crate::cli::Global;
use crate::command::view::open_surfaces;
use crate::config::Config;
use crate::environment::{self, Perceived, levelled::levelled};
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::Scene;
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

/// The page of surfaces or of a scene: `builtin:NAME`, or a file's name.
pub(super) fn edit(folder: &Folder, name: &str, global: &Global) -> Result<String, Refusal> {
    if let Some(scene) = name.strip_prefix("builtin:") {
        let shipped = scenes::builtin(scene);
        let shipped = shipped.ok_or_else(|| Refusal(404, format!("no scene {scene:?} ships")))?;
        return scene_page(scene, shipped.toml, global).map_err(bad);
    }
    let path = folder.file(name)?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("json") => surfaces(name, &path, global).map_err(bad),
        Some("toml") => {
            let text = std::fs::read_to_string(&path);
            let text = text.map_err(|cause| Refusal(400, format!("{name}: {cause}")))?;
            let scene = SceneFile::parse(&text).with_context(|| name.to_owned());
            folder.holds(&scene.map_err(bad)?)?;
            scene_page(&path.display().to_string(), &text, global).map_err(bad)
        }
        _ => refuse(
            400,
            format!("{name}: neither surfaces (.json) nor a scene (.toml)"),
        ),
    }
}

fn surfaces(name: &str, path: &Path, global: &Global) -> Result<String> {
    let terrain = open_surfaces(path)?;
    let config = Config::layered(None, global)?;
    page(name, &terrain, &[], &config, &Value::Null)
}

/// The page of a scene's surfaces, with what it asks.
fn scene_page(name: &str, text: &str, global: &Global) -> Result<String> {
    let mut inputs = Inputs::default();
    let scene = Scene::open(name, &mut inputs)?;
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    let (source, _) = levelled(&scene.environment, &scene.files, &config)?;
    let mut stages = Stages::default();
    let read = || environment::perceive(&source, &scene.files, &config, &mut stages, &mut inputs);
    let Perceived {
        terrain, cloud_W, ..
    } = threads::pool(global.threads)?.install(read)?;
    let mut table: Table = text.parse()?;
    let mut settings = Table::new();
    for key in SETTINGS {
        settings.extend(table.remove(key).map(|value| (key.to_owned(), value)));
    }
    let asked = json!({
        "robot": table.get("robot"),
        "start": table.get("start"),
        "goal": table.get("goal"),
        "friction": table.get("friction"),
        "settings": toml::to_string(&settings)?,
    });
    page(&scene.name, &terrain, &cloud_W, &config, &asked)
}

fn page(
    name: &str,
    terrain: &Terrain,
    cloud_W: &[[f32; 3]],
    config: &Config,
    asked: &Value,
) -> Result<String> {
    surfaces_page(&SurfacesInput {
        name,
        terrain,
        cloud_W,
        config,
        asked,
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
