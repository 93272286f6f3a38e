//! A connected plane region: one outer ring, holes, and what ends the region at every edge.

use geo::{Coord, LineString, Polygon, TriangulateEarcut};
use nalgebra::{Point2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::polygon::{ConvexPolygon, VERTEX_SEPARATION_M, centroid, check_width, ring_area};
use crate::{EdgeKind, Error};

/// What is known of an edge of a ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Edge {
    /// What ends the face there.
    pub kind: EdgeKind,
    /// Angle by which the ring lies inside the true edge already, seen from [`Self::view`], rad;
    /// negative where it lies outside. It does not count at edges that the view's border cuts.
    #[serde(skip_serializing_if = "is_zero")]
    pub inside_rad: f64,
    /// A further error of the edge's place, m: it may be nearer by that whatever else is known.
    #[serde(skip_serializing_if = "is_zero")]
    pub further_m: f64,
    /// Index in [`crate::Face::views`] of how it was seen; None: it has no other error than
    /// [`Self::further_m`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
}

impl Edge {
    /// An edge of this kind, exactly known.
    pub fn new(kind: EdgeKind) -> Self {
        Self {
            kind,
            ..Self::default()
        }
    }
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// A closed ring, each vertex once, and its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The vertices, m.
    pub vertices: Vec<Point2<f64>>,
    /// What is known of the edge from each vertex to the next.
    pub edges: Vec<Edge>,
}

impl Ring {
    /// The ring the other way round.
    fn reverse(&mut self) {
        self.vertices.reverse();
        // Edge k leads from vertex k to the next, so the last one stays the closing edge.
        self.edges.reverse();
        self.edges.rotate_left(1);
    }

    /// The signed area, positive where it runs counter-clockwise, m².
    pub fn area(&self) -> f64 {
        ring_area(&self.vertices)
    }

    /// The edges with their two ends, the closing one last.
    pub fn segments(&self) -> impl Iterator<Item = (&Edge, [&Point2<f64>; 2])> {
        let next = self.vertices.iter().cycle().skip(1);
        let ends = self.vertices.iter().zip(next);
        self.edges.iter().zip(ends.map(|(a, b)| [a, b]))
    }
}

impl From<Vec<Point2<f64>>> for Ring {
    /// A ring of real edges.
    fn from(vertices: Vec<Point2<f64>>) -> Self {
        let edges = vec![Edge::default(); vertices.len()];
        Self { vertices, edges }
    }
}

/// A connected region of the plane with an outer ring and holes, in m; valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The outer ring counter-clockwise, then the holes clockwise.
    rings: Vec<Ring>,
}

impl Region {
    /// The region inside the first ring and outside the others, each given in either direction.
    ///
    /// # Errors
    /// [`Error::Part`] naming the ring: fewer than 3 vertices, another number of edges, a bad number of an edge,
    /// vertices beyond the world, at the place of the one before or all on one line; [`Error::Shape`] when the rings
    /// cross themselves or each other.
    pub fn new<R: Into<Ring>>(rings: impl IntoIterator<Item = R>) -> Result<Self, Error> {
        let mut rings: Vec<Ring> = rings.into_iter().map(Into::into).collect();
        if rings.is_empty() {
            Error::check_count(0)?;
        }
        for (ring, points) in rings.iter_mut().enumerate() {
            check_ring(points).map_err(|cause| cause.of(format_args!("outline ring {ring}")))?;
            // The interior is on the left of every edge.
            if (points.area() < 0.0) != (ring > 0) {
                points.reverse();
            }
        }
        let region = Self { rings };
        let triangles_m2: f64 = region.triangles().iter().map(|t| ring_area(&t[..])).sum();
        let enclosed_m2 = region.area();
        // A triangulation of rings that do not cross covers their area, up to rounding.
        if (triangles_m2 - enclosed_m2).abs() > 1e-6 * region.rings[0].area() {
            return Err(Error::Shape(format!(
                "the outline crosses itself: its rings enclose {enclosed_m2} m², its triangles {triangles_m2} m²"
            )));
        }
        Ok(region)
    }

    /// The rings: the outer one counter-clockwise, then the holes clockwise.
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// The rings themselves.
    pub fn into_rings(self) -> Vec<Ring> {
        self.rings
    }

    /// What is known of each edge, ring by ring.
    pub fn edges_mut(&mut self) -> impl Iterator<Item = &mut [Edge]> {
        self.rings.iter_mut().map(|ring| &mut ring.edges[..])
    }

    /// All edges with their ends, ring by ring.
    pub fn segments(&self) -> impl Iterator<Item = (&Edge, [&Point2<f64>; 2])> {
        self.rings.iter().flat_map(Ring::segments)
    }

    /// The same region, every vertex moved by `shift`.
    #[must_use]
    pub fn moved(&self, shift: &Vector2<f64>) -> Self {
        let mut moved = self.clone();
        let vertices = moved.rings.iter_mut().flat_map(|ring| &mut ring.vertices);
        vertices.for_each(|vertex| *vertex += shift);
        moved
    }

    /// The area, m².
    pub fn area(&self) -> f64 {
        self.rings.iter().map(Ring::area).sum()
    }

    /// The centroid of the area, m.
    pub fn centroid(&self) -> Point2<f64> {
        centroid(self.segments().map(|(_, edge)| edge))
    }

    /// Triangles that partition the region, counter-clockwise.
    pub fn triangles(&self) -> Vec<[Point2<f64>; 3]> {
        let line = |ring: &Ring| -> LineString<f64> {
            let vertices = ring.vertices.iter();
            vertices.map(|p| Coord { x: p.x, y: p.y }).collect()
        };
        let holes = self.rings[1..].iter().map(line).collect();
        let triangles = Polygon::new(line(&self.rings[0]), holes).earcut_triangles();
        let oriented = triangles.into_iter().map(|triangle| {
            let mut corners = triangle.to_array().map(|c| Point2::new(c.x, c.y));
            if ring_area(&corners) < 0.0 {
                corners.reverse();
            }
            corners
        });
        oriented.collect()
    }

    /// The region itself, where it has no hole and is convex.
    pub fn as_convex(&self) -> Option<ConvexPolygon> {
        match &self.rings[..] {
            [outer] => ConvexPolygon::new(outer.vertices.clone()).ok(),
            _ => None,
        }
    }
}

impl From<&ConvexPolygon> for Region {
    /// The region of a polygon, all edges real.
    fn from(polygon: &ConvexPolygon) -> Self {
        Self {
            rings: vec![polygon.vertices().to_vec().into()],
        }
    }
}

fn check_ring(ring: &Ring) -> Result<(), Error> {
    let (points, count) = (&ring.vertices, ring.vertices.len());
    Error::check_count(count)?;
    if ring.edges.len() != count {
        let edges = ring.edges.len();
        let wrong = format!("edges: {edges} edges for {count} vertices");
        return Err(Error::Shape(wrong));
    }
    for edge in &ring.edges {
        if !edge.inside_rad.is_finite() {
            return Err(Error::bad("inside_rad", edge.inside_rad, "finite"));
        }
        Error::check_not_negative("further_m", edge.further_m)?;
    }
    Error::check_in_world(points)?;
    for vertex in 0..count {
        // The last vertex is compared with the first: a ring must not be closed explicitly.
        let (of, p) = ((vertex + 1) % count, points[vertex]);
        if (p - points[of]).norm() < VERTEX_SEPARATION_M {
            return Err(Error::repeated(vertex.max(of), vertex.min(of), &p));
        }
    }
    check_width(points)
}
