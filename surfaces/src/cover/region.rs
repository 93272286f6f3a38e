//! A plane region: an outer ring and holes.

use geo::{Coord, LineString, Polygon, TriangulateEarcut};
use nalgebra::Point2;

use crate::Error;
use crate::polygon::{ConvexPolygon, VERTEX_SEPARATION_M, check_width, ring_area};

/// A region of the plane with an outer ring and holes, in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The outer ring counter-clockwise, then the holes clockwise.
    rings: Vec<Vec<Point2<f64>>>,
    triangles: Vec<[Point2<f64>; 3]>,
}

impl Region {
    /// The region inside the first ring and outside the others, each given in either direction.
    ///
    /// # Errors
    /// [`Error::Outline`] naming the ring with [`Error::TooFewVertices`],
    /// [`Error::NonFiniteVertex`], [`Error::RepeatedVertex`] (neighbours) or [`Error::Collinear`];
    /// [`Error::CrossingOutline`] when the rings cross themselves or each other.
    pub fn new(rings: Vec<Vec<Point2<f64>>>) -> Result<Self, Error> {
        if rings.is_empty() {
            return Err(Error::TooFewVertices { count: 0 });
        }
        for (ring, points) in rings.iter().enumerate() {
            check_ring(points).map_err(|cause| Error::Outline {
                ring,
                cause: Box::new(cause),
            })?;
        }
        let mut rings = rings;
        for (i, ring) in rings.iter_mut().enumerate() {
            let clockwise = ring_area(ring) < 0.0;
            // Interior on the left of every edge: the outer ring left-, the holes right-handed.
            if clockwise != (i > 0) {
                ring.reverse();
            }
        }
        let triangles = triangulate(&rings);
        let region = Self { rings, triangles };
        let triangles_m2: f64 = region.triangles.iter().map(|t| ring_area(&t[..])).sum();
        let enclosed_m2 = region.area();
        // A triangulation of rings that do not cross covers their area, up to rounding.
        if (triangles_m2 - enclosed_m2).abs() > 1e-6 * region.outer_area() {
            return Err(Error::CrossingOutline {
                enclosed_m2,
                triangles_m2,
            });
        }
        Ok(region)
    }

    /// The rings: the outer one counter-clockwise, then the holes clockwise.
    pub fn rings(&self) -> &[Vec<Point2<f64>>] {
        &self.rings
    }

    /// The area, m².
    pub fn area(&self) -> f64 {
        self.rings.iter().map(|ring| ring_area(ring)).sum()
    }

    /// Triangles that partition the region, counter-clockwise.
    pub(super) fn triangles(&self) -> &[[Point2<f64>; 3]] {
        &self.triangles
    }

    /// The region itself, where it has no hole and is convex.
    pub(super) fn as_convex(&self) -> Option<ConvexPolygon> {
        match &self.rings[..] {
            [outer] => ConvexPolygon::new(outer.clone()).ok(),
            _ => None,
        }
    }

    fn outer_area(&self) -> f64 {
        ring_area(&self.rings[0])
    }
}

fn check_ring(points: &[Point2<f64>]) -> Result<(), Error> {
    let count = points.len();
    if count < 3 {
        return Err(Error::TooFewVertices { count });
    }
    for (vertex, p) in points.iter().enumerate() {
        if !p.coords.iter().all(|c| c.is_finite()) {
            let point = p.coords.iter().copied().collect();
            return Err(Error::NonFiniteVertex { vertex, point });
        }
    }
    for vertex in 0..count {
        // The last vertex is compared with the first: a ring must not be closed explicitly.
        let (of, p) = ((vertex + 1) % count, points[vertex]);
        if (p - points[of]).norm() < VERTEX_SEPARATION_M {
            return Err(Error::RepeatedVertex {
                vertex: vertex.max(of),
                of: vertex.min(of),
                x: p.x,
                y: p.y,
            });
        }
    }
    check_width(points)?;
    Ok(())
}

fn triangulate(rings: &[Vec<Point2<f64>>]) -> Vec<[Point2<f64>; 3]> {
    let line = |ring: &Vec<Point2<f64>>| -> LineString<f64> {
        ring.iter().map(|p| Coord { x: p.x, y: p.y }).collect()
    };
    let holes = rings[1..].iter().map(line).collect();
    let triangles = Polygon::new(line(&rings[0]), holes).earcut_triangles();
    let mut result = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        let mut corners = triangle.to_array().map(|c| Point2::new(c.x, c.y));
        if ring_area(&corners) < 0.0 {
            corners.reverse();
        }
        result.push(corners);
    }
    result
}
