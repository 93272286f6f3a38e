//! The JSON text of a terrain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Terrain, version_1};
use crate::Error;

/// The value of the field `format` that this version writes; it reads
/// `scandent-surfaces/1` as well.
pub const TERRAIN_FORMAT: &str = "scandent-surfaces/2";

/// What a robot may touch and must avoid, in W; as of version 2.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Surfaces")]
struct FileRecord<F, O> {
    /// [`TERRAIN_FORMAT`].
    format: String,
    /// The faces.
    faces: Vec<F>,
    /// Convex bodies that are only avoided.
    #[serde(default = "Vec::<O>::new")]
    obstacles: Vec<O>,
}

/// What every version of the file has.
#[derive(Deserialize)]
struct Versioned {
    format: String,
}

impl Terrain {
    /// The terrain in a file's text, checked; of a file of version 1 the pieces of a face as one.
    ///
    /// # Errors
    /// [`Error::File`], and those of [`Self::validate`]; whatever is wrong inside a face or obstacle names it.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let Versioned { format } = parse(text)?;
        if format == version_1::FORMAT {
            return parse::<version_1::File>(text)?.try_into();
        }
        if format != TERRAIN_FORMAT {
            let wrong = format!("the format is `{format}`, not `{TERRAIN_FORMAT}`");
            return Err(Error::File(wrong));
        }
        // First as plain values, so that what is wrong inside one of them can name it.
        let file: FileRecord<serde_json::Value, serde_json::Value> = parse(text)?;
        Self::new(
            read_each("face", file.faces)?,
            read_each("obstacle", file.obstacles)?,
        )
    }

    /// The JSON Schema of the file.
    pub fn schema() -> schemars::Schema {
        schemars::schema_for!(FileRecord<crate::Face, crate::Obstacle>)
    }

    /// The text of a file with this terrain; equal terrains give equal texts.
    ///
    /// # Errors
    /// Those of [`Self::validate`]: what could not be read back is not written.
    pub fn to_json(&self) -> Result<String, Error> {
        self.validate()?;
        let file = FileRecord {
            format: TERRAIN_FORMAT.into(),
            faces: self.faces.iter().collect(),
            obstacles: self.obstacles.iter().collect(),
        };
        let text = serde_json::to_string_pretty(&file).map_err(|e| json(&e))?;
        Ok(text + "\n")
    }
}

fn parse<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, Error> {
    serde_json::from_str(text).map_err(|e| json(&e))
}

fn json(error: &serde_json::Error) -> Error {
    Error::File(error.to_string())
}

/// Reads a list entry by entry; an error that does not name its entry yet is given the name.
pub(super) fn read_each<T: serde::de::DeserializeOwned>(
    what: &str,
    values: Vec<serde_json::Value>,
) -> Result<Vec<T>, Error> {
    let read = |(index, value): (usize, serde_json::Value)| {
        let id = value.get("id").and_then(|id| id.as_str().map(String::from));
        serde_json::from_value(value).map_err(|e| {
            let message = e.to_string();
            let place = match id {
                Some(id) if message.starts_with(&format!("{what} `{id}`")) => String::new(),
                Some(id) => format!("{what} `{id}` (number {index}): "),
                None => format!("{what} number {index}: "),
            };
            Error::File(place + &message)
        })
    };
    values.into_iter().enumerate().map(read).collect()
}
