//! The guide path: places that the base shall pass.

use nalgebra::Vector3;

use crate::Error;

/// A polyline that the base should roughly follow, through W.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    points: Vec<Vector3<f64>>,
}

impl Guide {
    /// A path through points in W, m.
    ///
    /// # Errors
    /// [`Error::Guide`] with less than two points or a number that is not finite.
    pub fn new(points: Vec<Vector3<f64>>) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::Guide {
                reason: format!("{} points, need two", points.len()),
            });
        }
        if let Some(i) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(Error::Guide {
                reason: format!("point {i} is not finite"),
            });
        }
        Ok(Self { points })
    }

    /// The points, at least two.
    pub fn points(&self) -> &[Vector3<f64>] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_paths_are_refused() {
        assert!(Guide::new(vec![Vector3::zeros()]).is_err());
        assert!(Guide::new(vec![Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0)]).is_err());
    }
}
