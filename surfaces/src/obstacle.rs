//! Convex bodies that are only avoided.

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;

/// A convex body in W: the hull of its points.
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
    /// The body between two corners, its edges along the axes of W.
    pub fn cuboid(id: impl Into<String>, low: [f64; 3], high: [f64; 3]) -> Self {
        let corner = |k: usize| [0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]);
        Self {
            id: id.into(),
            points_W: (0..8).map(|k| corner(k).into()).collect(),
            surface: None,
            assumed: false,
        }
    }

    /// Checks the points.
    ///
    /// # Errors
    /// [`Error::Part`] with the id: fewer than 4 points, or one beyond the world.
    pub fn validate(&self) -> Result<(), Error> {
        let checked = match self.points_W.len() {
            count @ ..4 => Err(Error::Shape(format!(
                "a convex body needs at least 4 points, this one has {count}"
            ))),
            _ => Error::check_in_world(&self.points_W),
        };
        checked.map_err(|cause| self.named(cause))
    }

    /// What is wrong with this obstacle.
    pub(crate) fn named(&self, cause: Error) -> Error {
        cause.of(format_args!("obstacle `{}`", self.id))
    }
}
