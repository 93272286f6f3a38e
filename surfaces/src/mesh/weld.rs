//! One vertex a place, and no triangle without an area.

use std::collections::{HashMap, HashSet};

use nalgebra::{Point3, Vector3};

use super::{TriangleMesh, WELD_M};
use crate::Error;

/// A mesh whose vertices are distinct and whose triangles have areas.
pub(super) struct Welded {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<Triangle>,
    /// Triangles that were skipped: without an area, or there already.
    pub degenerate: usize,
    /// Vertices that were merged into another one.
    pub merged: usize,
}

/// A triangle with an area.
pub(super) struct Triangle {
    pub corners: [usize; 3],
    /// Unit normal by the winding.
    pub normal: Vector3<f64>,
    pub area_m2: f64,
    /// Height over the longest edge, m.
    pub height_m: f64,
}

impl Welded {
    pub fn new(mesh: &TriangleMesh) -> Result<Self, Error> {
        check(mesh)?;
        let (vertices, place) = merge(&mesh.vertices);
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        let mut seen = HashSet::new();
        for corners in &mesh.triangles {
            let mut corners = corners.map(|i| place[i]);
            // From its first vertex on: a triangle that stands there twice is one.
            let first = (0..3).min_by_key(|k| corners[*k]).unwrap_or(0);
            corners.rotate_left(first);
            if seen.insert(corners)
                && let Some(triangle) = measure(&vertices, corners)
            {
                triangles.push(triangle);
            }
        }
        if triangles.is_empty() {
            let (triangles, vertices) = (mesh.triangles.len(), mesh.vertices.len());
            return Err(Error::Shape(format!(
                "the mesh has no triangle with an area ({triangles} triangles, {vertices} vertices)"
            )));
        }
        Ok(Self {
            degenerate: mesh.triangles.len() - triangles.len(),
            merged: mesh.vertices.len() - vertices.len(),
            vertices,
            triangles,
        })
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].corners.map(|i| self.vertices[i])
    }
}

fn check(mesh: &TriangleMesh) -> Result<(), Error> {
    Error::check_in_world(&mesh.vertices)?;
    let count = mesh.vertices.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(vertex) = corners.iter().copied().find(|i| *i >= count) {
            return Err(Error::Shape(format!(
                "triangle {triangle} refers to vertex {vertex}, but the mesh has {count} vertices"
            )));
        }
    }
    Ok(())
}

/// The distinct points, and for each point the place of its representative: the first one nearer
/// than [`WELD_M`] in the order of the file.
fn merge(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<usize>) {
    let mut distinct: Vec<Point3<f64>> = Vec::new();
    // Cells as wide as the distance: whoever is near is in a neighbouring cell. Only looked up,
    // never iterated, so the order of the map does not matter.
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut place = Vec::with_capacity(points.len());
    for p in points {
        let cell = |c: f64| (c / WELD_M).floor() as i64;
        let home = [cell(p.x), cell(p.y), cell(p.z)];
        let near = neighbours(home)
            .filter_map(|key| cells.get(&key))
            .flatten()
            .copied()
            .filter(|i| (distinct[*i] - p).norm() < WELD_M)
            .min();
        place.push(near.unwrap_or_else(|| {
            let index = distinct.len();
            distinct.push(*p);
            cells.entry(home).or_default().push(index);
            index
        }));
    }
    (distinct, place)
}

fn neighbours(home: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |k| {
        let step = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
        [0, 1, 2].map(|i| home[i].saturating_add(step[i]))
    })
}

/// The triangle of three vertices, if it has an area.
pub(super) fn measure(vertices: &[Point3<f64>], corners: [usize; 3]) -> Option<Triangle> {
    let [a, b, c] = corners.map(|i| vertices[i]);
    let cross = (b - a).cross(&(c - a));
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let height_m = cross.norm() / longest;
    // NaN where two corners are one vertex: not wider than anything.
    (height_m > WELD_M).then(|| Triangle {
        corners,
        normal: cross.normalize(),
        area_m2: 0.5 * cross.norm(),
        height_m,
    })
}
