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
    /// [`Error::Part`] with what is wrong with a face or an obstacle, which may be that it names a face outside the
    /// terrain; [`Error::Value`] for an empty or repeated id.
    pub fn validate(&self) -> Result<(), Error> {
        self.faces.iter().try_for_each(Face::validate)?;
        self.obstacles.iter().try_for_each(Obstacle::validate)?;
        check_ids("face", self.faces.iter().map(|face| face.id.as_str()))?;
        check_ids("obstacle", self.obstacles.iter().map(|o| o.id.as_str()))?;
        for obstacle in &self.obstacles {
            if let Some(face) = &obstacle.surface {
                let known = self.index_of(&face.as_str().into());
                known.map_err(|cause| obstacle.named(cause))?;
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
fn check_ids<'a>(what: &str, ids: impl Iterator<Item = &'a str>) -> Result<(), Error> {
    let mut seen = std::collections::BTreeMap::new();
    for (index, id) in ids.enumerate() {
        let wrong = match seen.insert(id, index) {
            _ if id.is_empty() => "has an empty id".to_owned(),
            Some(of) => format!("repeats the id `{id}` of number {of}"),
            None => continue,
        };
        return Err(Error::Value(format!("{what} number {index} {wrong}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
