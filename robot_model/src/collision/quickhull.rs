//! Quickhull that always adds the point farthest outside.

use nalgebra::{Point3, Vector3};

use super::parry::distance_m;

/// Why points have no hull of their own.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// Fewer than four points.
    #[error("{0} points span no volume")]
    TooFew(usize),
    /// A coordinate is NaN, or beyond [`crate::GREATEST_M`].
    #[error("point {} is not within {} m", .0, crate::GREATEST_M)]
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

/// A triangle of the growing hull, with the points outside of it that it has to answer for.
pub(super) struct Facet {
    pub corners: [usize; 3],
    pub normal: Vector3<f64>,
    pub offset: f64,
    outside: Vec<usize>,
    /// The farthest of them, and how far it sticks out, m.
    pub farthest: Option<(usize, f64)>,
}

/// Points closer to a facet than this part of the set's size are on it.
const RELATIVE_TOLERANCE: f64 = 1e-9;
/// Sets thinner than this part of their size are flat.
const FLAT: f64 = 1e-6;

/// The hull under construction.
pub(super) struct Growing {
    pub points: Vec<Point3<f64>>,
    pub facets: Vec<Facet>,
    /// Points outside that rounding lets be no vertices.
    given_up: Vec<usize>,
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
            given_up: Vec::new(),
            tolerance,
        };
        growing.start(corners);
        Ok(growing)
    }

    fn facet(&self, corners: [usize; 3]) -> Facet {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0);
        let normal = normal.unwrap_or_else(Vector3::zeros);
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

    /// The point farthest above any facet: the facet, the point and its height, m.
    pub fn farthest(&self) -> Option<(usize, usize, f64)> {
        let mut best: Option<(usize, usize, f64)> = None;
        for (i, facet) in self.facets.iter().enumerate() {
            if let Some((point, height)) = facet.farthest
                && best.is_none_or(|(_, _, h)| height > h)
            {
                best = Some((i, point, height));
            }
        }
        best
    }

    /// The greatest distance from the hull of a point that is outside of it, m.
    ///
    /// A height over a facet is less than that where the point is beside the facet.
    pub fn shortfall_m(&self) -> f64 {
        let mut most = 0.0;
        let owned = self
            .facets
            .iter()
            .flat_map(|f| f.outside.iter().map(move |p| (*p, Some(f))));
        for (point, facet) in owned.chain(self.given_up.iter().map(|p| (*p, None))) {
            let p = &self.points[point];
            let to = |facet: &Facet| distance_m(p, facet.corners.map(|i| self.points[i]));
            let mut least = facet.map_or(f64::INFINITY, to);
            for other in &self.facets {
                if least <= most {
                    break;
                }
                // No point of a facet is nearer than its plane.
                if self.above(other, point).abs() < least {
                    least = least.min(to(other));
                }
            }
            most = f64::max(most, least);
        }
        most
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
            self.given_up.push(apex);
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
        let values = points.iter().map(measure).enumerate();
        values.fold((0, f64::NEG_INFINITY), |best, one| {
            if one.1 > best.1 { one } else { best }
        })
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
