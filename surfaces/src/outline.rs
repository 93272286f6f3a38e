//! Plane regions of any shape, in any number of parts.
//!
//! An outline is a set of disjoint parts with holes. Outlines are joined and cut by each other
//! (Boolean operations of the `geo` crate, on a lattice of 2⁻³¹ of their extent).

use geo::{Area, BooleanOps, Coord, LineString, MultiPolygon, Polygon, Simplify};
use nalgebra::{Isometry3, Point2, Point3};

use crate::cover::distance_to_segment;
use crate::{ConvexPolygon, Region};

/// Corners nearer than this to the line through their neighbours are on it, m.
const FLAT_M: f64 = 1e-5;

/// Disjoint plane parts with holes, m.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline(MultiPolygon<f64>);

impl Default for Outline {
    fn default() -> Self {
        Self(MultiPolygon::new(Vec::new()))
    }
}

/// The rings of one part: the outer one first, then holes.
pub type Rings = Vec<Vec<[f64; 2]>>;

impl Outline {
    /// The region inside the first ring and outside the others; parts where it crosses itself.
    pub fn from_rings(rings: &[Vec<[f64; 2]>]) -> Self {
        let line = |ring: &Vec<[f64; 2]>| -> LineString<f64> {
            ring.iter().map(|&[x, y]| Coord { x, y }).collect()
        };
        let Some((outer, holes)) = rings.split_first() else {
            return Self::default();
        };
        let part = Polygon::new(line(outer), holes.iter().map(line).collect());
        // Through the overlay once: rings come out oriented and free of repeated corners.
        Self(MultiPolygon::new(vec![part]).union(&MultiPolygon::new(Vec::new())))
    }

    /// The region of a convex polygon.
    pub fn from_polygon(polygon: &ConvexPolygon) -> Self {
        let ring = polygon.vertices().iter().map(|p| [p.x, p.y]).collect();
        Self::from_rings(&[ring])
    }

    /// The union of axis-parallel rectangles (low corner, high corner), m.
    pub fn from_rectangles(rectangles: &[([f64; 2], [f64; 2])]) -> Self {
        let boxes: Vec<Polygon<f64>> = rectangles
            .iter()
            .map(|(low, high)| {
                let corners = [
                    [low[0], low[1]],
                    [high[0], low[1]],
                    [high[0], high[1]],
                    [low[0], high[1]],
                ];
                let ring = corners.iter().map(|&[x, y]| Coord { x, y }).collect();
                Polygon::new(ring, Vec::new())
            })
            .collect();
        Self(geo::unary_union(&boxes))
    }

    /// Whether nothing is in it.
    pub fn is_empty(&self) -> bool {
        self.0.0.is_empty()
    }

    /// The area, m².
    pub fn area(&self) -> f64 {
        self.0.unsigned_area()
    }

    /// Number of corners of all rings.
    pub fn corners(&self) -> usize {
        let rings = (self.0.iter())
            .flat_map(|part| std::iter::once(part.exterior()).chain(part.interiors()));
        // The last point of a ring repeats the first.
        rings.map(|ring| ring.0.len().saturating_sub(1)).sum()
    }

    /// Length of all rings, m.
    pub fn length(&self) -> f64 {
        let rings = (self.0.iter())
            .flat_map(|part| std::iter::once(part.exterior()).chain(part.interiors()));
        let edges = rings.flat_map(|ring| ring.lines());
        edges.map(|edge| edge.dx().hypot(edge.dy())).sum()
    }

    /// What lies in either.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self(self.0.union(&other.0))
    }

    /// What lies in both.
    #[must_use]
    pub fn common(&self, other: &Self) -> Self {
        Self(self.0.intersection(&other.0))
    }

    /// What lies in this one only.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        Self(self.0.difference(&other.0))
    }

    /// What lies in none of the rings, which run counter-clockwise and may overlap.
    #[must_use]
    pub fn minus_all(&self, rings: impl IntoIterator<Item = Vec<Point2<f64>>>) -> Self {
        use geo::bool_ops::{FillRule, OpType};
        let part = |ring: Vec<Point2<f64>>| Polygon::new(line(&ring), Vec::new());
        let others = MultiPolygon::new(rings.into_iter().map(part).collect());
        Self(
            self.0
                .boolean_op_with_fill_rule(&others, OpType::Difference, FillRule::NonZero),
        )
    }

    /// The centroid of its area.
    pub fn middle(&self) -> Option<Point2<f64>> {
        use geo::Centroid;
        let centroid = self.0.centroid()?;
        Some(Point2::new(centroid.x(), centroid.y()))
    }

    /// Whether a point lies in it (its border counts).
    pub fn contains(&self, p: &Point2<f64>) -> bool {
        use geo::Intersects;
        self.0.intersects(&Coord { x: p.x, y: p.y })
    }

    /// The least and greatest coordinates, m.
    pub fn bounds(&self) -> Option<(Point2<f64>, Point2<f64>)> {
        use geo::BoundingRect;
        let bounds = self.0.bounding_rect()?;
        let (low, high) = (bounds.min(), bounds.max());
        Some((Point2::new(low.x, low.y), Point2::new(high.x, high.y)))
    }

    /// The same region of another plane's frame: corners are moved by `X_BA` and dropped onto the
    /// plane z = 0.
    #[must_use]
    pub fn moved(&self, X_BA: &Isometry3<f64>) -> Self {
        use geo::MapCoords;
        Self(self.0.map_coords(|c| {
            let p = X_BA * Point3::new(c.x, c.y, 0.0);
            Coord { x: p.x, y: p.y }
        }))
    }

    /// With corners left out that are nearer than `tolerance_m` to what remains \[douglas1973\];
    /// a part that would then cross itself stays as it is.
    #[must_use]
    pub fn simplified(&self, tolerance_m: f64) -> Self {
        self.each_by(|part| part.simplify(tolerance_m))
    }

    /// With corners left out that stand out by no more than `tolerance_m`: it only shrinks, by no
    /// more than that; a part that would then cross itself stays as it is.
    #[must_use]
    pub fn simplified_inside(&self, tolerance_m: f64) -> Self {
        let simple = |ring: &LineString<f64>| {
            let points: Vec<Point2<f64>> = open(ring).into_iter().map(Point2::from).collect();
            line(&without_tips(&points, tolerance_m))
        };
        self.each_by(|part| {
            let holes = part.interiors().iter().map(simple).collect();
            Polygon::new(simple(part.exterior()), holes)
        })
    }

    /// With every part replaced; one that would then be no region stays as it is.
    fn each_by(&self, simple: impl Fn(&Polygon<f64>) -> Polygon<f64>) -> Self {
        let replaced = |part: &Polygon<f64>| {
            let simple = simple(part);
            if region(&simple).is_some() {
                simple
            } else {
                part.clone()
            }
        };
        Self(MultiPolygon::new(self.0.iter().map(replaced).collect()))
    }

    /// Without parts and holes smaller than this, m².
    #[must_use]
    pub fn without_specks(&self, area_min_m2: f64) -> Self {
        let parts = self.0.iter().filter(|p| p.unsigned_area() >= area_min_m2);
        let kept = parts.map(|part| {
            let large = |hole: &&LineString<f64>| {
                Polygon::new((*hole).clone(), Vec::new()).unsigned_area() >= area_min_m2
            };
            let holes = part.interiors().iter().filter(large).cloned().collect();
            Polygon::new(part.exterior().clone(), holes)
        });
        Self(MultiPolygon::new(kept.collect()))
    }

    /// Each connected part by itself, the largest first.
    pub fn parts(&self) -> Vec<Self> {
        let mut parts: Vec<&Polygon<f64>> = self.0.iter().collect();
        parts.sort_by(|a, b| b.unsigned_area().total_cmp(&a.unsigned_area()));
        parts
            .into_iter()
            .map(|part| Self(MultiPolygon::new(vec![part.clone()])))
            .collect()
    }

    /// The rings of the largest part: the outer one, then its holes.
    pub fn rings(&self) -> Rings {
        let largest = self
            .0
            .iter()
            .max_by(|a, b| a.unsigned_area().total_cmp(&b.unsigned_area()));
        largest.map_or_else(Vec::new, |part| {
            let rings = std::iter::once(part.exterior()).chain(part.interiors());
            rings.map(open).collect()
        })
    }

    /// Each connected part as a region of real edges, the largest first; without those whose rings
    /// cannot be used.
    pub fn regions(&self) -> Vec<Region> {
        let mut regions: Vec<Region> = self.0.iter().filter_map(region).collect();
        regions.sort_by(|a, b| b.area().total_cmp(&a.area()));
        regions
    }
}

impl From<&Region> for Outline {
    fn from(region: &Region) -> Self {
        let mut lines = region.rings().iter().map(|ring| line(&ring.vertices));
        let parts = lines
            .next()
            .map(|outer| Polygon::new(outer, lines.collect()));
        Self(MultiPolygon::new(parts.into_iter().collect()))
    }
}

fn line(ring: &[Point2<f64>]) -> LineString<f64> {
    ring.iter().map(|p| Coord { x: p.x, y: p.y }).collect()
}

/// A ring without its last point, which repeats the first, and without corners that are none.
fn open(ring: &LineString<f64>) -> Vec<[f64; 2]> {
    let points: Vec<Point2<f64>> = ring.0.iter().map(|c| Point2::new(c.x, c.y)).collect();
    crate::polygon::clean_ring(points, FLAT_M)
        .iter()
        .map(|p| [p.x, p.y])
        .collect()
}

/// A ring (the region on its left) without corners that turn left and of which the new edge leaves
/// no point of the ring farther away than `tolerance_m`; the flattest go first.
fn without_tips(ring: &[Point2<f64>], tolerance_m: f64) -> Vec<Point2<f64>> {
    let mut kept: Vec<usize> = (0..ring.len()).collect();
    // How far the ring is off the edge that leaves a corner out; infinite where it turns right, or that is too far.
    let off_m = |kept: &[usize], i: usize| {
        let count = kept.len();
        let (before, after) = (kept[(i + count - 1) % count], kept[(i + 1) % count]);
        let (a, b, c) = (&ring[before], &ring[kept[i]], &ring[after]);
        if (b - a).perp(&(c - b)) < 0.0 {
            return f64::INFINITY;
        }
        let (mut k, mut off_m) = (before, 0.0_f64);
        loop {
            k = if k + 1 < ring.len() { k + 1 } else { 0 };
            if k == after {
                return off_m;
            }
            off_m = off_m.max(distance_to_segment(&ring[k], a, c));
            if off_m > tolerance_m {
                return f64::INFINITY;
            }
        }
    };
    let mut offs_m: Vec<f64> = (0..ring.len()).map(|i| off_m(&kept, i)).collect();
    while kept.len() > 3 {
        let least = |best: usize, i: usize| if offs_m[i] < offs_m[best] { i } else { best };
        let i = (1..offs_m.len()).fold(0, least);
        if offs_m[i] > tolerance_m {
            break;
        }
        kept.remove(i);
        offs_m.remove(i);
        // The corners beside it have other edges now.
        let count = kept.len();
        for k in [(i + count - 1) % count, i % count] {
            offs_m[k] = off_m(&kept, k);
        }
    }
    kept.into_iter().map(|k| ring[k]).collect()
}

fn region(part: &Polygon<f64>) -> Option<Region> {
    let rings = std::iter::once(part.exterior()).chain(part.interiors());
    let rings = rings
        .map(|ring| open(ring).into_iter().map(Point2::from).collect())
        .filter(|ring: &Vec<_>| ring.len() >= 3);
    Region::new(rings).ok()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::polygon::tests::polygons;

    fn square(low: f64, high: f64) -> Outline {
        Outline::from_rectangles(&[([low, low], [high, high])])
    }

    #[test]
    fn a_hole_is_kept_and_a_speck_is_not() {
        let ring = square(0.0, 1.0).minus(&square(0.4, 0.6));
        approx::assert_relative_eq!(ring.area(), 0.96, max_relative = 1e-8);
        assert_eq!(ring.rings().len(), 2);
        assert!(ring.contains(&Point2::new(0.2, 0.2)) && !ring.contains(&Point2::new(0.5, 0.5)));
        assert_eq!(ring.without_specks(0.05).rings().len(), 1);
        assert!(square(0.0, 0.1).without_specks(0.05).is_empty());
    }

    proptest! {
        #[test]
        fn union_and_difference_share_out_the_area(a in polygons(), b in polygons()) {
            let (a, b) = (Outline::from_polygon(&a), Outline::from_polygon(&b));
            let (both, common) = (a.union(&b).area(), a.common(&b).area());
            let scale = 1.0 + a.area() + b.area();
            prop_assert!((both + common - a.area() - b.area()).abs() < 1e-6 * scale);
            prop_assert!((a.minus(&b).area() + common - a.area()).abs() < 1e-6 * scale);
        }

        #[test]
        fn simplified_from_inside_it_only_shrinks(a in polygons(), b in polygons()) {
            let both = Outline::from_polygon(&a).union(&Outline::from_polygon(&b));
            let simple = both.simplified_inside(0.02);
            prop_assert!(simple.minus(&both).area() < 1e-6 * (1.0 + both.area()));
            let (length, lost) = (both.length(), both.area() - simple.area());
            prop_assert!(lost <= 0.02 * length + 1e-6, "{lost} m² of {length} m");
            prop_assert!(simple.corners() <= both.corners());
        }
    }
}
