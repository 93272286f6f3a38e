//! Convex bodies that are only avoided.

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Error, beyond_world};

/// A convex body in W: the hull of its points.
#[allow(non_snake_case)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Name, unique in its set.
    pub id: String,
    /// Points whose hull is the body, in W, m.
    #[schemars(with = "Vec<[f64; 3]>")]
    pub points_W: Vec<Point3<f64>>,
    /// The id of the face whose body this is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<String>,
    /// Whether something may be there and was not seen: it is kept away from, and nothing else.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub assumed: bool,
}

impl Obstacle {
    /// Checks the points.
    ///
    /// # Errors
    /// [`Error::Obstacle`] with the id and [`Error::TooFewPoints`] or [`Error::VertexBeyondWorld`].
    pub fn validate(&self) -> Result<(), Error> {
        let cause = if self.points_W.len() < 4 {
            Error::TooFewPoints {
                count: self.points_W.len(),
            }
        } else if let Some((vertex, p)) = self
            .points_W
            .iter()
            .enumerate()
            .find(|(_, p)| beyond_world(p.coords.as_slice()).is_some())
        {
            Error::VertexBeyondWorld {
                vertex,
                point: p.coords.iter().copied().collect(),
            }
        } else {
            return Ok(());
        };
        Err(Error::Obstacle {
            id: self.id.clone(),
            cause: Box::new(cause),
        })
    }
}
