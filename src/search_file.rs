//! The file of what a search tried, beside the plan that came of it.

use std::path::Path;

use anyhow::{Context, Result, bail};
use plan::Trace;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::provenance::{read, sha256};

/// Its name, in the folder of the plan.
pub const SEARCH_FILE: &str = "search.json";
const FORMAT: &str = "scandent-search/1";

/// What a search tried for a plan.
#[derive(Serialize, Deserialize, JsonSchema)]
#[schemars(title = "Search")]
struct SearchFile {
    /// Always [`FORMAT`].
    format: String,
    /// SHA-256 of the bytes of the plan's file, hexadecimal.
    plan_sha256: String,
    #[serde(flatten)]
    trace: Trace,
}

/// The JSON Schema of the file.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(SearchFile)
}

/// The file's bytes, for the plan of these bytes.
///
/// # Errors
/// What is no JSON.
pub fn json(trace: &Trace, plan: &[u8]) -> Result<Vec<u8>> {
    Ok(serde_json::to_vec(&SearchFile {
        format: FORMAT.to_owned(),
        plan_sha256: sha256(plan),
        trace: trace.clone(),
    })?)
}

/// What was tried for the plan in a file, if that stands beside it: a file of another plan does not count.
///
/// # Errors
/// A file that cannot be read, or is of another version.
pub fn beside(plan: &Path) -> Result<Option<Trace>> {
    let path = plan.with_file_name(SEARCH_FILE);
    if !path.is_file() {
        return Ok(None);
    }
    let name = path.display();
    let file: SearchFile = serde_json::from_slice(&read("search", &path)?)
        .with_context(|| format!("{name}: not what a search tried"))?;
    if file.format != FORMAT {
        bail!("{name}: the format is {:?}, not {FORMAT:?}", file.format);
    }
    if file.plan_sha256 != sha256(&read("plan", plan)?) {
        return Ok(None);
    }
    Ok(Some(file.trace))
}
