//! Everything a robot may touch and everything it must avoid, and the file it is kept in.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::terrain::{check_ids, read_each};
use crate::{Error, Obstacle, Source, Surface, ThinBody, thin_body};

/// The value of the field `format` that this version writes and reads.
pub const SURFACES_FORMAT: &str = "scandent-surfaces/1";

/// Surfaces to touch and obstacles to avoid, each with an id of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SetRecord")]
pub struct SurfaceSet {
    /// The surfaces.
    pub surfaces: Vec<Surface>,
    /// Convex bodies that are only avoided.
    pub obstacles: Vec<Obstacle>,
}

/// A set without its format, not yet checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetRecord {
    surfaces: Vec<Surface>,
    #[serde(default)]
    obstacles: Vec<Obstacle>,
}

impl TryFrom<SetRecord> for SurfaceSet {
    type Error = Error;

    fn try_from(record: SetRecord) -> Result<Self, Error> {
        Self::new(record.surfaces, record.obstacles)
    }
}

/// The file: the set and its format.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileRecord<S, O> {
    format: String,
    surfaces: Vec<S>,
    #[serde(default = "Vec::new")]
    obstacles: Vec<O>,
}

impl SurfaceSet {
    /// A set of valid surfaces and obstacles with unique ids.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(surfaces: Vec<Surface>, obstacles: Vec<Obstacle>) -> Result<Self, Error> {
        let set = Self {
            surfaces,
            obstacles,
        };
        set.validate()?;
        Ok(set)
    }

    /// Checks every surface and obstacle, and that ids are unique among each kind.
    ///
    /// # Errors
    /// [`Error::Surface`], [`Error::Obstacle`], [`Error::EmptyId`], [`Error::DuplicateId`], and
    /// [`Error::Unknown`] for an obstacle that names a surface outside the set.
    pub fn validate(&self) -> Result<(), Error> {
        self.surfaces.iter().try_for_each(Surface::validate)?;
        self.obstacles.iter().try_for_each(Obstacle::validate)?;
        check_ids("surface", self.surfaces.iter().map(|s| s.id.as_str()))?;
        check_ids("obstacle", self.obstacles.iter().map(|o| o.id.as_str()))?;
        for obstacle in &self.obstacles {
            if let Some(surface) = &obstacle.surface {
                self.index_of(surface).map_err(|cause| Error::Obstacle {
                    id: obstacle.id.clone(),
                    cause: Box::new(cause),
                })?;
            }
        }
        Ok(())
    }

    /// The position of a surface in the set.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the ids that exist.
    pub fn index_of(&self, id: &str) -> Result<usize, Error> {
        let position = self.surfaces.iter().position(|s| s.id == id);
        position.ok_or_else(|| Error::Unknown {
            what: "surface",
            name: id.into(),
            candidates: self.surfaces.iter().map(|s| s.id.clone()).collect(),
        })
    }

    /// A surface by its id.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the ids that exist.
    pub fn get(&self, id: &str) -> Result<&Surface, Error> {
        Ok(&self.surfaces[self.index_of(id)?])
    }

    /// Every convex body to keep away from: the obstacles, then a body behind each surface, as deep
    /// as the other surfaces and the points known to be free allow.
    ///
    /// A surface that an obstacle names already has its body; those of a mesh have none of their
    /// own, because the mesh is among the obstacles.
    #[allow(non_snake_case)]
    pub fn bodies(&self, free_W: &[Point3<f64>], config: &thin_body::Config) -> Vec<Obstacle> {
        let mut bodies = self.obstacles.clone();
        for surface in &self.surfaces {
            let has_body = |o: &Obstacle| o.surface.as_ref() == Some(&surface.id);
            let of_mesh = surface.source == Source::Mesh;
            if !of_mesh && !self.obstacles.iter().any(has_body) {
                let depth = thin_body::depth_m(surface, &self.surfaces, free_W, config);
                bodies.push(ThinBody::new(surface, depth).into());
            }
        }
        bodies
    }

    /// The set in a file's text, checked.
    ///
    /// # Errors
    /// [`Error::Json`] with line and column, [`Error::Format`], and those of [`Self::validate`];
    /// whatever is wrong inside a surface or obstacle names it.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        // First as plain values, so that what is wrong inside one of them can name it.
        let file: FileRecord<serde_json::Value, serde_json::Value> = serde_json::from_str(text)
            .map_err(|e| Error::Json {
                place: String::new(),
                message: e.to_string(),
            })?;
        if file.format != SURFACES_FORMAT {
            return Err(Error::Format {
                found: file.format,
                expected: SURFACES_FORMAT,
            });
        }
        let surfaces = read_each("surface", file.surfaces)?;
        let obstacles = read_each("obstacle", file.obstacles)?;
        Self::new(surfaces, obstacles)
    }

    /// The text of a file with this set; equal sets give equal texts.
    ///
    /// # Errors
    /// Those of [`Self::validate`]: what could not be read back is not written.
    pub fn to_json(&self) -> Result<String, Error> {
        self.validate()?;
        let file = FileRecord {
            format: SURFACES_FORMAT.into(),
            surfaces: self.surfaces.iter().collect(),
            obstacles: self.obstacles.iter().collect(),
        };
        let text = serde_json::to_string_pretty(&file).map_err(|e| Error::Json {
            place: String::new(),
            message: e.to_string(),
        })?;
        Ok(text + "\n")
    }
}

#[cfg(test)]
mod tests;
