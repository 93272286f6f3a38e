//! A large convex part of a region around a point: what a patch that shall stand there is held to.

use nalgebra::{Point2, Vector2};

use crate::cover::Boundary;
use crate::outline::Outline;
use crate::{ConvexPolygon, HalfPlane, Region};

/// The part holds what lies on both sides of the point along the wanted direction up to this, m: two
/// lengths of a foot.
const REACH_M: f64 = 0.3;
/// The part along the direction is taken unless the largest one is this many times as large.
const PREFERENCE: f64 = 4.0;
/// A point nearer to the border than this is taken so far inside, m: on the border itself there is no
/// telling on which side of it the part shall lie.
const INSIDE_M: f64 = 1e-4;

impl Outline {
    /// A large convex part that holds the point, or the outline's point nearest to it, and is long
    /// along `direction` where it can be; None where the outline is empty.
    ///
    /// It is grown from the stretch of the line through the point that lies in the region, by the
    /// lines that keep each nearest edge out in turn and leave the most area ([`crate::cover`]).
    /// It does not leave the region by more than a micrometre, and of a point on the border holds one
    /// 0.1 mm inside. Units: m.
    pub fn convex_around(
        &self,
        point: &Point2<f64>,
        direction: &Vector2<f64>,
    ) -> Option<ConvexPolygon> {
        let (region, point) = self.nearest(point)?;
        if let Some(whole) = region.as_convex() {
            return Some(whole);
        }
        let point = inside(&region, point);
        let boundary = Boundary::new(region.rings().iter().map(|ring| &ring.vertices[..]));
        let grown = |seed: &[Point2<f64>]| ConvexPolygon::from_ring(boundary.grow(seed));
        let around = grown(&[point]);
        let stretch = direction.try_normalize(0.0).map(|along| {
            let reach = |along| reach_m(&region, &point, along);
            [point - along * reach(-along), point + along * reach(along)]
        });
        let along = stretch.and_then(|[a, b]| if a == b { None } else { grown(&[a, b]) });
        match (along, around) {
            (Some(along), Some(around)) if around.area() > PREFERENCE * along.area() => {
                Some(around)
            }
            (along, around) => along.or(around),
        }
    }

    /// The connected part that holds the point or is nearest to it, and the point of it nearest.
    fn nearest(&self, point: &Point2<f64>) -> Option<(Region, Point2<f64>)> {
        let mut nearest: Option<(f64, Region, Point2<f64>)> = None;
        for region in self.regions() {
            let (off_m, at) = if Self::from(&region).contains(point) {
                (0.0, *point)
            } else {
                on_border(&region, point)
            };
            if nearest.as_ref().is_none_or(|(least, _, _)| off_m < *least) {
                nearest = Some((off_m, region, at));
            }
        }
        nearest.map(|(_, region, at)| (region, at))
    }
}

/// The distance of a point from the nearest point of a region's border, and that point.
fn on_border(region: &Region, point: &Point2<f64>) -> (f64, Point2<f64>) {
    let nearest = |(_, [a, b]): (_, [&Point2<f64>; 2])| {
        let edge: Vector2<f64> = b - a;
        let t = (edge.dot(&(point - a)) / edge.norm_squared()).clamp(0.0, 1.0);
        let at = a + edge * t;
        ((point - at).norm(), at)
    };
    let points = region.segments().map(nearest);
    let nearer = |a: (f64, _), b: (f64, _)| if b.0 < a.0 { b } else { a };
    points.fold((f64::INFINITY, *point), nearer)
}

/// The point, or one [`INSIDE_M`] from it in the triangle of the region at it that is the widest there.
fn inside(region: &Region, point: Point2<f64>) -> Point2<f64> {
    let gap_m = |p: &Point2<f64>| on_border(region, p).0;
    if gap_m(&point) >= INSIDE_M {
        return point;
    }
    let toward = |triangle: [Point2<f64>; 3]| {
        let edges = triangle.iter().zip(triangle.iter().cycle().skip(1));
        let off = edges.map(|(a, b)| HalfPlane::left_of(a, b).value(&point));
        let at = off.fold(f64::NEG_INFINITY, f64::max) < INSIDE_M;
        let middle = Point2::from(triangle.iter().map(|v| v.coords).sum::<Vector2<f64>>() / 3.0);
        let way = middle - point;
        at.then(|| point + way * (INSIDE_M / way.norm()).min(1.0))
    };
    let within = region.triangles().into_iter().filter_map(toward);
    let placed = within.filter(|p| Outline::from(region).contains(p));
    let measured = placed.map(|p| (gap_m(&p), p));
    let farther = |a: (f64, _), b: (f64, _)| if b.0 > a.0 { b } else { a };
    measured.reduce(farther).map_or(point, |(_, p)| p)
}

/// How far one can go from a point inside the region along a unit vector without leaving it, up to
/// [`REACH_M`], m.
fn reach_m(region: &Region, point: &Point2<f64>, along: Vector2<f64>) -> f64 {
    let crossing = |(_, [a, b]): (_, [&Point2<f64>; 2])| {
        let (from, to) = (along.perp(&(a - point)), along.perp(&(b - point)));
        // Both ends on one side, or the edge along the line.
        if (from > 0.0) == (to > 0.0) {
            return None;
        }
        let off = along.dot(&(a + (b - a) * (from / (from - to)) - point));
        Some(off).filter(|off| *off > 0.0)
    };
    region
        .segments()
        .filter_map(crossing)
        .fold(REACH_M, f64::min)
}
