//! One plan at a time, computed beside the server.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use anyhow::Result;
use planner::{Progress, Stage};
use scenes::SceneFile;
use serde_json::{Value, json};
use surfaces::Terrain;
use toml::Table;

use super::folder::Folder;
use super::{Refusal, bad, refuse};
use crate::cli::Global;
use crate::command::run::plan_and_write;
use crate::output;
use crate::pipeline::RunOptions;
use crate::provenance::Inputs;
use crate::robot_files::Robots;
use crate::scene::Scene;
use crate::status::Status;
use crate::told::Told;

/// Longest name of a scene.
const NAME_MAX: usize = 64;

/// The plan that is computed, or the last one.
#[derive(Default)]
pub(super) struct Jobs {
    now: Mutex<Option<Arc<Job>>>,
}

struct Job {
    /// The scene's name.
    name: String,
    /// The command line that does the same.
    command: String,
    begin: Instant,
    cancel: AtomicBool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    stage: String,
    progress: Option<Progress>,
    /// How it ended, and what the command would have printed.
    ended: Option<(&'static str, String, f64)>,
}

impl Jobs {
    /// Writes scene and surfaces under a name that is free, and plans for them.
    pub(super) fn start(
        &self,
        folder: &Folder,
        scene: Table,
        surfaces: &str,
        global: &Global,
    ) -> Result<Value, Refusal> {
        let mut now = lock(&self.now);
        if now
            .as_ref()
            .is_some_and(|job| lock(&job.state).ended.is_none())
        {
            return refuse(409, "a plan is being computed: cancel it, or wait");
        }
        let (name, path) = write(folder, scene, surfaces)?;
        let at = |name: &str| folder.shown().join(name).display().to_string();
        let (file, out) = (at(&format!("{name}.toml")), at(&format!("out/{name}")));
        let job = Arc::new(Job {
            name,
            command: format!("scandent plan {file} -o {out}"),
            begin: Instant::now(),
            cancel: AtomicBool::new(false),
            state: Mutex::default(),
        });
        *now = Some(Arc::clone(&job));
        let (asked, global) = (Arc::clone(&job), global.clone());
        let work = move || {
            let results = path.with_file_name("out").join(&job.name);
            let mut said = Vec::new();
            let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                job.plan(&path, &results, &global, &mut said)
            }));
            let said = String::from_utf8_lossy(&said).into_owned();
            let (how, text) = match done {
                Ok(Ok(Status::Done)) => ("verified", said),
                Ok(Ok(Status::NoPlan)) => ("no_plan", said),
                Ok(Ok(_)) => ("undecided", said),
                Ok(Err(error)) => ("error", format!("{error:#}")),
                Err(_) => ("error", "the planner failed: see the terminal".to_owned()),
            };
            let seconds = job.begin.elapsed().as_secs_f64();
            job.change(|state| state.ended = Some((how, text, seconds)));
        };
        // A browser's worker has one thread: the page hears of the work from `change`.
        match cfg!(target_os = "wasi") {
            true => work(),
            false => drop(std::thread::spawn(work)),
        }
        Ok(asked.status())
    }

    /// How far it is.
    pub(super) fn status(&self) -> Value {
        let now = lock(&self.now);
        now.as_ref()
            .map_or_else(|| json!({ "state": "idle" }), |job| job.status())
    }

    /// Asks what is computed to stop.
    pub(super) fn cancel(&self) -> Value {
        if let Some(job) = lock(&self.now).as_ref() {
            job.cancel.store(true, Ordering::Relaxed);
        }
        self.status()
    }
}

impl Job {
    /// Notes how far it is, and tells a page whose worker this is.
    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut lock(&self.state));
        if cfg!(target_os = "wasi") {
            eprintln!("{}", self.status());
        }
    }

    fn status(&self) -> Value {
        let state = lock(&self.state);
        let mut said = json!({ "name": self.name, "command": self.command, "stage": state.stage });
        if let Some(progress) = &state.progress {
            said["nodes"] = json!(progress.nodes);
            said["solved"] = json!(progress.solved);
            said["to_go_m"] = json!(Some(progress.best_distance_m).filter(|d| d.is_finite()));
        }
        match &state.ended {
            None => {
                said["state"] = json!("running");
                said["seconds"] = json!(self.begin.elapsed().as_secs_f64());
            }
            Some((how, text, seconds)) => {
                said["state"] = json!(how);
                said["text"] = json!(text);
                said["seconds"] = json!(seconds);
                if *how != "error" {
                    said["page"] = json!(format!("show/out/{}/view.html", self.name));
                }
            }
        }
        said
    }

    fn plan(
        &self,
        scene: &std::path::Path,
        results: &std::path::Path,
        global: &Global,
        said: &mut Vec<u8>,
    ) -> Result<Status> {
        let mut inputs = Inputs::default();
        let scene = Scene::open(&scene.display().to_string(), &mut inputs)?;
        let manner = RunOptions {
            threads: global.threads,
            stage: &|stage| self.change(|state| stage.clone_into(&mut state.stage)),
            progress: &|progress| {
                self.change(|state| {
                    state.progress = Some(*progress);
                    state.stage = match progress.stage {
                        Stage::Search => "searching".to_owned(),
                        Stage::Motion { known, of } => format!("motion {} of {of}", known + 1),
                    };
                });
            },
            cancel: &self.cancel,
            robots: &Robots::default(),
        };
        plan_and_write(
            &scene,
            inputs,
            results,
            global,
            &manner,
            &mut Told::words(said),
        )
    }
}

/// Writes what was asked as `NAME.toml` and `NAME.surfaces.json`: a name that is free, so that nothing is replaced.
fn write(
    folder: &Folder,
    mut scene: Table,
    surfaces: &str,
) -> Result<(String, std::path::PathBuf), Refusal> {
    let asked = scene
        .get("name")
        .and_then(|name| name.as_str())
        .unwrap_or_default();
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if asked.is_empty() || asked.len() > NAME_MAX || !asked.chars().all(plain) {
        return refuse(
            400,
            format!("name {asked:?}: up to {NAME_MAX} letters, digits, - and _ are a name here"),
        );
    }
    let terrain =
        Terrain::from_json(surfaces).map_err(|cause| bad(anyhow::anyhow!("surfaces: {cause}")))?;
    let mut names = std::iter::once(asked.to_owned()).chain((2..).map(|k| format!("{asked}-{k}")));
    let taken = |name: &String| {
        let files = [
            format!("{name}.toml"),
            format!("{name}.surfaces.json"),
            format!("out/{name}"),
        ];
        files
            .iter()
            .any(|file| folder.root().join(file).symlink_metadata().is_ok())
    };
    let name = names.find(|name| !taken(name)).unwrap_or_default();
    let surfaces_file = format!("{name}.surfaces.json");
    scene.insert("name".to_owned(), name.clone().into());
    scene.insert("surfaces_file".to_owned(), surfaces_file.clone().into());
    let text = toml::to_string(&scene).map_err(|cause| bad(cause.into()))?;
    let parsed = SceneFile::parse(&text).map_err(|cause| bad(anyhow::anyhow!("scene: {cause}")))?;
    let surfaces = folder.root().join(&surfaces_file);
    let json = terrain.to_json().map_err(|cause| bad(cause.into()))?;
    output::write(&surfaces, json.as_bytes()).map_err(bad)?;
    if let Err(refusal) = folder.holds(&parsed) {
        let _ = std::fs::remove_file(surfaces);
        return Err(refusal);
    }
    let path = folder.root().join(format!("{name}.toml"));
    output::write(&path, text.as_bytes()).map_err(bad)?;
    Ok((name, path))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock only means that another thread panicked while it noted.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
