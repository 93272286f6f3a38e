//! Convex hulls of point sets, with as few vertices as asked for.
//!
//! They grow by the point farthest outside (`quickhull.rs`); stopping early leaves a hull of the most
//! telling vertices, and it is known how far the others stick out of it.

use nalgebra::{Point3, Vector3};

use super::ascent::Ascent;
use super::quickhull::{Growing, HullError};
use crate::GREATEST_M;

/// A closed convex polyhedron of triangles.
#[derive(Clone, Debug)]
pub struct Hull {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    shortfall_m: f64,
    ascent: Ascent,
}

impl Hull {
    /// The convex hull of `points`.
    ///
    /// # Errors
    /// [`HullError`] when they are fewer than four, flat or not finite.
    pub fn new(points: &[Point3<f64>]) -> Result<Self, HullError> {
        Self::simplified(points, 0.0, usize::MAX)
    }

    /// The hull of as few of `points` as leave the others within about `shortfall_m` of it, and of at
    /// most `max_vertices` (at least 4) of them: see [`Self::shortfall_m`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn simplified(
        points: &[Point3<f64>],
        shortfall_m: f64,
        max_vertices: usize,
    ) -> Result<Self, HullError> {
        let finite = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= GREATEST_M);
        if let Some(at) = points.iter().position(|p| !finite(p)) {
            return Err(HullError::NotFinite(at));
        }
        let mut growing = Growing::new(points.to_vec())?;
        let mut count = 4;
        while count < max_vertices
            && let Some((facet, apex, height_m)) = growing.farthest()
            && height_m > shortfall_m
        {
            if growing.add(facet, apex)? {
                count += 1;
            }
        }
        Self::grown(growing)
    }

    /// The corners.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Triangles over [`Self::vertices`], counter-clockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The greatest distance from the hull of a point that [`Self::simplified`] left out; 0 for a
    /// complete hull. All points are in the hull grown by it.
    pub fn shortfall_m(&self) -> f64 {
        self.shortfall_m
    }

    /// The vertex farthest along `d`.
    pub fn support(&self, d: &Vector3<f64>) -> Point3<f64> {
        self.vertices[self.ascent.support(&self.vertices, d)]
    }

    /// Outward unit normals of the triangles.
    pub fn face_normals(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        self.triangles.iter().map(|&[a, b, c]| {
            let at = |i: u32| self.vertices[i as usize];
            let normal = (at(b) - at(a)).cross(&(at(c) - at(a)));
            normal.try_normalize(0.0).unwrap_or_else(Vector3::z)
        })
    }

    /// Volume; m³.
    pub fn volume(&self) -> f64 {
        let at = |i: u32| self.vertices[i as usize].coords;
        let apex = self.vertices.first().map(|v| v.coords).unwrap_or_default();
        let tetrahedron = |t: &[u32; 3]| {
            (at(t[0]) - apex).dot(&(at(t[1]) - apex).cross(&(at(t[2]) - apex))) / 6.0
        };
        self.triangles.iter().map(tetrahedron).sum()
    }

    /// The hull that has grown, its vertices renumbered.
    fn grown(growing: Growing) -> Result<Self, HullError> {
        let mut used: Vec<usize> = growing.facets.iter().flat_map(|f| f.corners).collect();
        used.sort_unstable();
        used.dedup();
        let number = |corner: usize| used.binary_search(&corner).unwrap_or(0) as u32;
        let triangles: Vec<_> = growing
            .facets
            .iter()
            .map(|f| f.corners.map(number))
            .collect();
        let vertices: Vec<_> = used.iter().map(|&i| growing.points[i]).collect();
        let hull = Hull {
            ascent: Ascent::new(&vertices, &triangles),
            vertices,
            triangles,
            shortfall_m: growing.shortfall_m(),
        };
        // Euler's formula: a closed surface of triangles has 2V − 4 of them.
        let closed = hull.triangles.len() + 4 == 2 * hull.vertices.len();
        if closed && hull.volume() > 0.0 {
            Ok(hull)
        } else {
            Err(HullError::Degenerate)
        }
    }
}

#[cfg(test)]
mod tests;
