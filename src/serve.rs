//! The page that looks at surfaces and scenes, plans and shows the plan, and what answers it.
//!
//! Requests name no file outside the folder. Its pages load nothing and ask nobody else.

mod folder;
#[cfg(not(target_os = "wasi"))]
mod http;
mod job;
mod listing;
mod open;
#[cfg(target_os = "wasi")]
mod worker;

use std::borrow::Cow;
use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use crate::cli::Global;
use folder::Folder;
#[cfg(not(target_os = "wasi"))]
pub use http::Server;
use job::Jobs;
#[cfg(target_os = "wasi")]
pub use worker::answer;

/// What answers the requests of a page.
struct Site {
    folder: Folder,
    jobs: Jobs,
    global: Global,
}

/// What is answered.
enum Answer {
    Page(String),
    Data(Value),
}

/// What is refused: the status code and the reason.
#[derive(Debug)]
struct Refusal(u16, String);

impl Site {
    /// # Errors
    /// A folder that is not there.
    fn new(folder: &Path, global: &Global) -> Result<Self> {
        Ok(Self {
            folder: Folder::new(folder)?,
            jobs: Jobs::default(),
            global: global.clone(),
        })
    }

    /// Answers a request for an address: a path, and after `?sensor=` what took the scan there.
    fn answer(
        &self,
        method: &str,
        address: &str,
        body: impl FnOnce() -> Result<Vec<u8>, Refusal>,
    ) -> Result<Answer, Refusal> {
        let (path, query) = address.split_once('?').unwrap_or((address, ""));
        let (path, sensor) = (decoded(path)?, query.strip_prefix("sensor="));
        let sensor = decoded(sensor.unwrap_or_default())?;
        let (action, rest) = path.split_once('/').unwrap_or((&path, ""));
        match (method, action) {
            ("GET", "") => Ok(Answer::Page(listing::page(&self.folder)?)),
            ("GET", "edit") => {
                open::edit(&self.folder, rest, &sensor, &self.global).map(Answer::Page)
            }
            ("GET", "show") => open::show(&self.folder, rest).map(Answer::Page),
            ("GET", "status") => Ok(Answer::Data(self.jobs.status())),
            ("POST", "plan") => {
                let (scene, surfaces) = asked(&body()?)?;
                let started = self
                    .jobs
                    .start(&self.folder, scene, &surfaces, &self.global);
                started.map(Answer::Data)
            }
            ("POST", "cancel") => Ok(Answer::Data(self.jobs.cancel())),
            (_, "" | "edit" | "show" | "status") => refuse(405, "this address is read by GET"),
            (_, "plan" | "cancel") => refuse(405, "this address is asked by POST"),
            _ => refuse(404, format!("{action:?}: there is no such address")),
        }
    }
}

fn decoded(address: &str) -> Result<Cow<'_, str>, Refusal> {
    let text = percent_encoding::percent_decode_str(address).decode_utf8();
    text.map_err(|_| Refusal(400, "the address is no UTF-8".into()))
}

fn refuse<T>(code: u16, why: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(code, why.into()))
}

/// What went wrong with what a request names.
fn bad(error: anyhow::Error) -> Refusal {
    Refusal(400, format!("{error:#}"))
}

/// The scene (TOML) and the surfaces (JSON) of a request for a plan.
fn asked(body: &[u8]) -> Result<(toml::Table, String), Refusal> {
    let asked: Value = serde_json::from_slice(body)
        .map_err(|cause| Refusal(400, format!("the body is no JSON: {cause}")))?;
    let scene = asked["scene"].as_str();
    let scene = scene.ok_or_else(|| Refusal(400, "the body has no \"scene\", a text".into()))?;
    let scene = scene.parse::<toml::Table>();
    let scene = scene.map_err(|cause| Refusal(400, format!("the scene is no TOML: {cause}")))?;
    match asked.get("surfaces") {
        Some(surfaces) if surfaces.is_object() => Ok((scene, surfaces.to_string())),
        _ => refuse(
            400,
            "the body has no \"surfaces\", an object as in surfaces.json",
        ),
    }
}
