//! Convex hulls of point sets, with as few vertices as asked for.
//!
//! Quickhull that always adds the point farthest outside; stopping early leaves a hull of the
//! most telling vertices, and it is known how far the others stick out of it.

use nalgebra::{Point3, Vector3};

use super::ascent::Ascent;

/// Why points have no hull of their own.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// Fewer than four points.
    #[error("{0} points span no volume")]
    TooFew(usize),
    /// A coordinate is NaN or infinite, or too great to be metres.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// The points lie in a plane, on a line or at a point.
    #[error("the points are coplanar (thickness {thickness_m:.1e} m): they span no volume")]
    Flat {
        /// How far they extend across the plane.
        thickness_m: f64,
    },
    /// Rounding broke the hull's surface.
    #[error("the points are too degenerate for a convex hull")]
    Degenerate,
}

/// A closed convex polyhedron of triangles.
#[derive(Clone, Debug)]
pub struct Hull {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    shortfall_m: f64,
    ascent: Ascent,
}

/// A triangle of the growing hull, with the points outside of it that it has to answer for.
pub(super) struct Facet {
    pub corners: [usize; 3],
    pub normal: Vector3<f64>,
    pub offset: f64,
    outside: Vec<usize>,
    farthest: Option<(usize, f64)>,
}

/// Points closer to a facet than this part of the set's size are on it.
const RELATIVE_TOLERANCE: f64 = 1e-9;
/// Sets thinner than this part of their size are flat.
const FLAT: f64 = 1e-6;
/// Coordinates beyond this are no metres of anything that a robot touches.
const GREATEST_M: f64 = 1e9;

impl Hull {
    /// The convex hull of `points`.
    ///
    /// # Errors
    /// [`HullError`] when they are fewer than four, flat or not finite.
    pub fn new(points: &[Point3<f64>]) -> Result<Self, HullError> {
        Self::with_at_most(points, usize::MAX)
    }

    /// The hull of at most `max_vertices` (at least 4) of `points`, chosen so that the rest
    /// stick out little: see [`Self::shortfall_m`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_at_most(points: &[Point3<f64>], max_vertices: usize) -> Result<Self, HullError> {
        let finite = |p: &Point3<f64>| p.iter().all(|c| c.is_finite() && c.abs() < GREATEST_M);
        if let Some(at) = points.iter().position(|p| !finite(p)) {
            return Err(HullError::NotFinite(at));
        }
        let mut growing = Growing::new(points.to_vec())?;
        let mut count = 4;
        while count < max_vertices
            && let Some((facet, apex)) = growing.farthest()
        {
            if growing.add(facet, apex)? {
                count += 1;
            }
        }
        growing.finish()
    }

    /// The corners.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Triangles over [`Self::vertices`], counter-clockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// How far the points left out by [`Self::with_at_most`] stick out at the most; 0 for a
    /// complete hull.
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
}

/// The hull under construction.
pub(super) struct Growing {
    pub points: Vec<Point3<f64>>,
    pub facets: Vec<Facet>,
    tolerance: f64,
}

impl Growing {
    /// The tetrahedron that the growth begins with; every other point still outside.
    pub fn new(points: Vec<Point3<f64>>) -> Result<Self, HullError> {
        let corners = first_tetrahedron(&points)?;
        let tolerance = extent(&points) * RELATIVE_TOLERANCE;
        let mut growing = Growing {
            points,
            facets: Vec::new(),
            tolerance,
        };
        growing.start(corners);
        Ok(growing)
    }

    fn facet(&self, corners: [usize; 3]) -> Facet {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_else(Vector3::zeros);
        // The mean of the corners spreads the rounding.
        let offset = normal.dot(&(a.coords + b.coords + c.coords)) / 3.0;
        Facet {
            corners,
            normal,
            offset,
            outside: Vec::new(),
            farthest: None,
        }
    }

    fn above(&self, facet: &Facet, point: usize) -> f64 {
        facet.normal.dot(&self.points[point].coords) - facet.offset
    }

    /// Hands each point to the facet that it is farthest above.
    fn distribute(&mut self, mut fresh: Vec<Facet>, candidates: impl IntoIterator<Item = usize>) {
        for point in candidates {
            let mut best: Option<(usize, f64)> = None;
            for (i, facet) in fresh.iter().enumerate() {
                let height = self.above(facet, point);
                if height > self.tolerance && best.is_none_or(|(_, h)| height > h) {
                    best = Some((i, height));
                }
            }
            if let Some((i, height)) = best {
                fresh[i].outside.push(point);
                if fresh[i].farthest.is_none_or(|(_, h)| height > h) {
                    fresh[i].farthest = Some((point, height));
                }
            }
        }
        self.facets.append(&mut fresh);
    }

    fn start(&mut self, [a, b, c, d]: [usize; 4]) {
        let fresh = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|f| self.facet(f));
        self.distribute(fresh.into(), 0..self.points.len());
    }

    /// The point farthest above any facet.
    pub fn farthest(&self) -> Option<(usize, usize)> {
        let mut best: Option<(usize, usize, f64)> = None;
        for (i, facet) in self.facets.iter().enumerate() {
            if let Some((point, height)) = facet.farthest
                && best.is_none_or(|(_, _, h)| height > h)
            {
                best = Some((i, point, height));
            }
        }
        best.map(|(facet, point, _)| (facet, point))
    }

    /// Makes `apex` a vertex: the facets that it sees give way to a cone over their rim. False
    /// where rounding leaves no single rim; the point is then given up.
    pub fn add(&mut self, facet: usize, apex: usize) -> Result<bool, HullError> {
        let seen: Vec<bool> = (0..self.facets.len())
            .map(|i| i == facet || self.above(&self.facets[i], apex) > self.tolerance)
            .collect();
        let Some(rim) = self.rim(&seen) else {
            let given_up = &mut self.facets[facet];
            given_up.outside.retain(|&p| p != apex);
            given_up.farthest = None;
            let rest = std::mem::take(&mut self.facets[facet].outside);
            let alone = self.facet(self.facets[facet].corners);
            self.facets.remove(facet);
            self.distribute(vec![alone], rest);
            return Ok(false);
        };
        let mut orphans = Vec::new();
        let mut seen = seen.into_iter();
        self.facets.retain_mut(|f| {
            let is_seen = seen.next().unwrap_or(false);
            if is_seen {
                orphans.append(&mut f.outside);
            }
            !is_seen
        });
        let fresh: Vec<Facet> = rim.iter().map(|&(a, b)| self.facet([a, b, apex])).collect();
        if fresh.iter().any(|f| f.normal == Vector3::zeros()) {
            return Err(HullError::Degenerate);
        }
        orphans.retain(|&p| p != apex);
        self.distribute(fresh, orphans);
        Ok(true)
    }

    /// The edges between seen and unseen facets, if they make one closed line.
    fn rim(&self, seen: &[bool]) -> Option<Vec<(usize, usize)>> {
        let mut edges: Vec<(usize, usize)> = Vec::new();
        for (facet, _) in self.facets.iter().zip(seen).filter(|(_, s)| **s) {
            let [a, b, c] = facet.corners;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                // An edge between two seen facets is there in both directions.
                if let Some(twin) = edges.iter().position(|&e| e == (to, from)) {
                    edges.swap_remove(twin);
                } else {
                    edges.push((from, to));
                }
            }
        }
        let &(start, mut at) = edges.first()?;
        let mut steps = 1;
        while at != start {
            let mut onward = edges.iter().filter(|e| e.0 == at);
            let next = onward.next()?;
            if onward.next().is_some() || steps > edges.len() {
                return None;
            }
            at = next.1;
            steps += 1;
        }
        (steps == edges.len()).then_some(edges)
    }

    /// Renumbers the vertices that remain.
    fn finish(self) -> Result<Hull, HullError> {
        let mut used: Vec<usize> = self.facets.iter().flat_map(|f| f.corners).collect();
        used.sort_unstable();
        used.dedup();
        let number = |corner: usize| used.binary_search(&corner).unwrap_or(0) as u32;
        let triangles: Vec<_> = self.facets.iter().map(|f| f.corners.map(number)).collect();
        let left_out = self
            .facets
            .iter()
            .filter_map(|f| f.farthest)
            .map(|(_, h)| h);
        let vertices: Vec<_> = used.iter().map(|&i| self.points[i]).collect();
        let hull = Hull {
            ascent: Ascent::new(&vertices, &triangles),
            vertices,
            triangles,
            shortfall_m: left_out.fold(0.0, f64::max),
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

/// The longest edge of the box around the points.
fn extent(points: &[Point3<f64>]) -> f64 {
    let Some(first) = points.first() else {
        return 0.0;
    };
    let (low, high) = points
        .iter()
        .fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).max()
}

/// Four points that span a volume, chosen far apart; the first three counter-clockwise seen from
/// away from the fourth.
fn first_tetrahedron(points: &[Point3<f64>]) -> Result<[usize; 4], HullError> {
    if points.len() < 4 {
        return Err(HullError::TooFew(points.len()));
    }
    let size = extent(points);
    let farthest = |measure: &dyn Fn(&Point3<f64>) -> f64| {
        let mut best = (0, f64::NEG_INFINITY);
        for (i, p) in points.iter().enumerate() {
            let value = measure(p);
            if value > best.1 {
                best = (i, value);
            }
        }
        best
    };
    let flat = |thickness_m: f64| HullError::Flat { thickness_m };
    let (a, _) = farthest(&|p| -p.x);
    let (b, length) = farthest(&|p| (p - points[a]).norm());
    // Not merely equal: a denormal size has no directions.
    if !(size > 1e-100 && length > 0.0) {
        return Err(flat(0.0));
    }
    let along = (points[b] - points[a]) / length;
    let across = |p: &Point3<f64>| {
        let r = p - points[a];
        r - along * r.dot(&along)
    };
    let (c, width) = farthest(&|p| across(p).norm());
    if width <= FLAT * size {
        return Err(flat(width));
    }
    let normal = along.cross(&(across(&points[c]) / width));
    let (d, height) = farthest(&|p| (p - points[a]).dot(&normal).abs());
    if height <= FLAT * size {
        return Err(flat(height));
    }
    let is_above = (points[d] - points[a]).dot(&normal) > 0.0;
    Ok(if is_above { [a, c, b, d] } else { [a, b, c, d] })
}

#[cfg(test)]
mod tests;
