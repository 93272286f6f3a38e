//! The page of surfaces: what may be touched by whom and why not, to look at, to edit and to plan on.

use anyhow::Result;
use plan::RequiredMargins;
use serde_json::{Value, json};
use surfaces::Terrain;

use super::{CLOUD_POINTS_MAX, FORMAT, cloud, face, framed};
use crate::config::Config;
use crate::roles::why_not;

/// What the page shows.
#[derive(Clone, Copy, Debug)]
pub struct SurfacesInput<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Faces and obstacles.
    pub terrain: &'a Terrain,
    /// The scans' points in W, m.
    pub cloud_W: &'a [[f32; 3]],
    /// The settings: roles, and how far edges are taken back.
    pub config: &'a Config,
    /// The fields of a scene that are known already, for the form; null where there are none.
    pub asked: &'a Value,
    /// URDFs that are at hand, beside those that ship.
    pub robots: &'a [String],
    /// Whether the page may ask the server that gave it for a plan.
    pub served: bool,
}

/// The page as HTML.
///
/// # Errors
/// What cannot be written as JSON.
pub fn surfaces_page(input: &SurfacesInput<'_>) -> Result<String> {
    let (terrain, config) = (input.terrain, input.config);
    let edge_sigmas = config.posture.edge_sigmas;
    let ground_m = (config.surfaces.roles).ground_m(&terrain.faces, edge_sigmas);
    let roles = serde_json::to_value(&config.surfaces.roles)?;
    let roles: Vec<&String> = roles
        .as_object()
        .into_iter()
        .flat_map(|r| r.keys())
        .collect();
    let records = terrain.faces.iter().map(|shown| {
        let mut record = face::record(shown, edge_sigmas);
        let verdict = |role: &&String| {
            let why = why_not(role, shown, &config.surfaces.roles, edge_sigmas, ground_m);
            json!({ "role": role, "why_not": why })
        };
        record["serves"] = roles.iter().map(verdict).collect();
        record
    });
    let (points, total) = (
        cloud::thinned(input.cloud_W, CLOUD_POINTS_MAX),
        input.cloud_W.len(),
    );
    let shipped = scenes::robot_names().map(|name| format!("builtin:{name}"));
    let data = json!({
        "format": FORMAT,
        "kind": "surfaces",
        "program": format!("{} {}", crate::program().name, crate::program().version),
        "scene": input.name,
        "seed": 0,
        "inputs": [],
        "robot": { "name": "", "mass_kg": 0.0, "weight_N": 1.0, "bodies": [] },
        "cloud": cloud::record(&points, total),
        "surfaces": records.collect::<Vec<_>>(),
        "obstacles": terrain.obstacles.iter().map(face::obstacle).collect::<Vec<_>>(),
        "unseen": face::unseen(&terrain.faces, config.surfaces.body.thickness_m),
        "required": RequiredMargins::from(&config.posture),
        "goal": { "tolerance_m": 0.0, "contacts": [] },
        "search": {},
        "stances": [],
        "motion": null,
        "certificate": null,
        "edit": {
            "terrain": serde_json::from_str::<Value>(&terrain.to_json()?)?,
            "roles": roles,
            "asked": input.asked,
            "robots": input.robots.iter().cloned().chain(shipped).collect::<Vec<_>>(),
            "served": input.served,
        },
    });
    framed(input.name, &data, input.served)
}
