//! The first page: what the folder holds.

use std::path::Path;

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::{Value, json};

use super::folder::Folder;
use super::open::{Kind, kind};
use super::{Refusal, bad};
use crate::template::render;

/// What stays in an address as it is.
const PLAIN: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'/')
    .remove(b'.')
    .remove(b'-')
    .remove(b'_');

/// Scenes and surfaces to edit, and plans to show.
pub(super) fn page(folder: &Folder) -> Result<String, Refusal> {
    let files = folder.files();
    let of = |fits: fn(&str) -> bool| -> Vec<Value> {
        let found = files.iter().filter(|name| fits(name));
        found.map(|name| link(name, name)).collect()
    };
    let builtin = scenes::names().map(|name| link(name, &format!("builtin:{name}")));
    let said = json!({
        "folder": folder.shown().display().to_string(),
        "builtin": builtin.collect::<Vec<_>>(),
        "scenes": of(|name| kind(name) == Some(Kind::Scene)),
        "scans": of(|name| kind(name) == Some(Kind::Scan)),
        "sensors": perception::SENSORS.map(|sensor| sensor.name),
        "meshes": of(|name| kind(name) == Some(Kind::Mesh)),
        "surfaces": of(|name| name.ends_with("surfaces.json")),
        "plans": of(|name| Path::new(name).file_name().is_some_and(|n| n == "view.html")),
    });
    render("listing.html", include_str!("listing.html"), said).map_err(bad)
}

fn link(name: &str, address: &str) -> Value {
    let address = utf8_percent_encode(address, PLAIN).to_string();
    json!({ "name": name, "address": address })
}
