//! What can be wrong with a face, a polygon or a mesh.

use std::fmt::Display;

use nalgebra::Point;

use crate::{WORLD_M, beyond_world};

/// Why a polygon, a face, a terrain or a mesh was refused.
///
/// Vertices, rings and triangles are counted from 0, as they stand in the input.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Points, rings or triangles that make no polygon, region, body or mesh, with the one at fault.
    #[error("{0}")]
    Shape(String),
    /// A number, a rotation, a covariance or an id that cannot be one, with the field.
    #[error("{0}")]
    Value(String),
    /// A text that is no file of a terrain, with line and column.
    #[error("{0}")]
    File(String),
    /// A ring of a region, a face or an obstacle is bad.
    #[error("{part}: {cause}")]
    Part {
        /// Which.
        part: String,
        /// What is wrong with it.
        cause: Box<Error>,
    },
    /// A name that is not known.
    #[error("no {what} `{name}`; there are: {}", candidates.join(", "))]
    Unknown {
        /// `face` or `role`.
        what: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        candidates: Vec<String>,
    },
}

impl Error {
    /// A number that is not what is expected.
    pub(crate) fn bad(field: &str, value: f64, expected: &str) -> Self {
        Self::Value(format!("{field} is {value}, which is not {expected}"))
    }

    /// The same of a part.
    pub(crate) fn of(self, part: impl Display) -> Self {
        Self::Part {
            part: part.to_string(),
            cause: Box::new(self),
        }
    }

    /// The same of a face with this id.
    #[must_use]
    pub fn of_face(self, id: &str) -> Self {
        self.of(format_args!("face `{id}`"))
    }

    /// Refuses a number that is negative or not finite.
    pub(crate) fn check_not_negative(field: &str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value >= 0.0 {
            return Ok(());
        }
        Err(Self::bad(field, value, "a finite number ≥ 0"))
    }

    /// Refuses fewer vertices than a triangle has.
    pub(crate) fn check_count(count: usize) -> Result<(), Self> {
        if count >= 3 {
            return Ok(());
        }
        let wanted = "a polygon needs at least 3 vertices";
        Err(Self::Shape(format!("{wanted}, this one has {count}")))
    }

    /// Refuses coordinates that are no numbers or beyond [`WORLD_M`].
    pub(crate) fn check_in_world<const D: usize>(points: &[Point<f64, D>]) -> Result<(), Self> {
        let beyond = |p: &Point<f64, D>| beyond_world(p.coords.as_slice()).is_some();
        let Some(vertex) = points.iter().position(beyond) else {
            return Ok(());
        };
        let point = points[vertex].coords.as_slice();
        let wanted = format!("is not within {WORLD_M} m");
        Err(Self::Shape(format!("vertex {vertex} {wanted}: {point:?}")))
    }

    /// A vertex at the place of another one.
    pub(crate) fn repeated(vertex: usize, of: usize, p: &Point<f64, 2>) -> Self {
        let place = format!("[{}, {}]", p[0], p[1]);
        Self::Shape(format!("vertex {vertex} repeats vertex {of}: {place}"))
    }
}
