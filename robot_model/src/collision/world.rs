//! What the robot may collide with.

use nalgebra::{Isometry3, Point3, Vector3};

use super::broad::Bounds;
use super::{BoxIndex, Hull, HullError, ShapeGeometry};

/// A convex body of the environment.
#[derive(Clone, Debug)]
pub struct Obstacle {
    /// Pose of the frame O that its hull is given in: at the mean of its points, axes of W.
    pub(crate) pose: Isometry3<f64>,
    pub(crate) geometry: ShapeGeometry,
    pub(crate) bounds: Bounds,
}

impl Obstacle {
    /// The hull of points in W. Any depth will do: a body extruded deep below the face that the
    /// robot touches keeps pushing it out of that face.
    ///
    /// # Errors
    /// [`HullError`] when the points span no volume or are not finite.
    pub fn new(points_w: &[Point3<f64>]) -> Result<Self, HullError> {
        // Centred coordinates keep GJK's digits for the shape, not for where it is.
        let sum: Vector3<f64> = points_w.iter().map(|p| p.coords).sum();
        let centre = sum / points_w.len().max(1) as f64;
        let local: Vec<Point3<f64>> = points_w.iter().map(|p| p - centre).collect();
        let geometry = ShapeGeometry::ConvexHull(Hull::new(&local)?);
        let pose = Isometry3::translation(centre.x, centre.y, centre.z);
        let bounds = Bounds::around(&geometry.bounds(), &pose);
        Ok(Obstacle {
            pose,
            geometry,
            bounds,
        })
    }

    /// Pose of the frame that [`Self::geometry`] is given in.
    pub fn pose(&self) -> &Isometry3<f64> {
        &self.pose
    }

    /// A distance that every point of the obstacle has from a point of W at least, m: that of its box.
    pub fn distance_m(&self, point: &Point3<f64>) -> f64 {
        self.bounds.distance_m(point)
    }

    /// Whether every point of the obstacle is farther than `distance_m` from a point of W, as far as
    /// its box can tell.
    pub fn is_beyond(&self, point: &Point3<f64>, distance_m: f64) -> bool {
        self.distance_m(point) > distance_m
    }

    /// The obstacle's shape.
    pub fn geometry(&self) -> &ShapeGeometry {
        &self.geometry
    }
}

/// The convex bodies of the environment, in a fixed order.
#[derive(Clone, Default)]
pub struct World {
    obstacles: Vec<Obstacle>,
    index: BoxIndex,
}

impl World {
    /// The hulls of point sets in W.
    ///
    /// # Errors
    /// The index of the first set that spans no volume or holds a point that is not finite,
    /// with the reason.
    pub fn new<P: AsRef<[Point3<f64>]>>(bodies: &[P]) -> Result<Self, (usize, HullError)> {
        let obstacles: Vec<Obstacle> = bodies
            .iter()
            .enumerate()
            .map(|(i, points)| Obstacle::new(points.as_ref()).map_err(|error| (i, error)))
            .collect::<Result<_, _>>()?;
        let index = BoxIndex::new(obstacles.iter().map(|o| o.bounds.corners()));
        Ok(World { obstacles, index })
    }

    /// The bodies.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The bodies whose boxes along W's axes come within `distance_m` of a box, by index, in ascending
    /// order.
    pub fn near(&self, low: &Point3<f64>, high: &Point3<f64>, distance_m: f64) -> Vec<usize> {
        self.index.near(low, high, distance_m)
    }
}
