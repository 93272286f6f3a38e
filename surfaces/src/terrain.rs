//! All that a robot may touch and must avoid, and the file it is kept in.

mod file;
mod version_1;

use serde::{Deserialize, Serialize};

use crate::{Error, Face, FaceId, Obstacle};
pub use file::TERRAIN_FORMAT;
use file::read_each;

/// Faces to touch and obstacles to avoid, each with an id of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TerrainRecord")]
pub struct Terrain {
    /// The faces.
    pub faces: Vec<Face>,
    /// Convex bodies that are only avoided.
    pub obstacles: Vec<Obstacle>,
}

/// A terrain without its format, not yet checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TerrainRecord {
    faces: Vec<Face>,
    #[serde(default)]
    obstacles: Vec<Obstacle>,
}

impl TryFrom<TerrainRecord> for Terrain {
    type Error = Error;

    fn try_from(record: TerrainRecord) -> Result<Self, Error> {
        Self::new(record.faces, record.obstacles)
    }
}

impl Terrain {
    /// Valid faces and obstacles with unique ids.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(faces: Vec<Face>, obstacles: Vec<Obstacle>) -> Result<Self, Error> {
        let terrain = Self { faces, obstacles };
        terrain.validate()?;
        Ok(terrain)
    }

    /// Checks every face and obstacle, and that ids are unique among each kind.
    ///
    /// # Errors
    /// [`Error::Face`], [`Error::Obstacle`], [`Error::EmptyId`], [`Error::DuplicateId`], and
    /// [`Error::Unknown`] for an obstacle that names a face outside the terrain.
    pub fn validate(&self) -> Result<(), Error> {
        self.faces.iter().try_for_each(Face::validate)?;
        self.obstacles.iter().try_for_each(Obstacle::validate)?;
        check_ids("face", self.faces.iter().map(|face| face.id.as_str()))?;
        check_ids("obstacle", self.obstacles.iter().map(|o| o.id.as_str()))?;
        for obstacle in &self.obstacles {
            if let Some(face) = &obstacle.surface {
                self.index_of(&face.as_str().into())
                    .map_err(|cause| Error::Obstacle {
                        id: obstacle.id.clone(),
                        cause: Box::new(cause),
                    })?;
            }
        }
        Ok(())
    }

    /// The position of a face in the terrain.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the ids that exist.
    pub fn index_of(&self, id: &FaceId) -> Result<usize, Error> {
        let position = self.faces.iter().position(|face| face.id == *id);
        position.ok_or_else(|| Error::Unknown {
            what: "face",
            name: id.to_string(),
            candidates: self.faces.iter().map(|face| face.id.to_string()).collect(),
        })
    }

    /// A face by its id.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the ids that exist.
    pub fn get(&self, id: &FaceId) -> Result<&Face, Error> {
        Ok(&self.faces[self.index_of(id)?])
    }
}

/// Refuses empty and repeated ids.
fn check_ids<'a>(what: &'static str, ids: impl Iterator<Item = &'a str>) -> Result<(), Error> {
    let mut seen = std::collections::BTreeMap::new();
    for (index, id) in ids.enumerate() {
        if id.is_empty() {
            return Err(Error::EmptyId { what, index });
        }
        if let Some(of) = seen.insert(id, index) {
            let id = id.into();
            return Err(Error::DuplicateId {
                what,
                id,
                index,
                of,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
