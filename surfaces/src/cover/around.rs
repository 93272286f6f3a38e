//! A region enclosed by convex pieces: what a cover inside the region leaves bare at its border, these hold.

use nalgebra::Point2;

use super::fragments::Fragments;
use super::grow::{Boundary, sides};
use super::{Piece, drop_redundant};
use crate::outline::Outline;
use crate::polygon::clip_ring;
use crate::{ConvexPolygon, Region};

/// Convex polygons that together hold the whole region, no point of them
/// is farther than 1.09 `slack_m` from it.
///
/// The largest part of a triangle that is still bare is grown until the edges of the region widened by
/// the slack stop it, and the hull of what that holds of the region is taken, again and again. So
/// pockets as shallow as the slack are filled, and a straight edge stays where it is. What is
/// narrower than a micrometre counts as rounding. Units: m.
pub fn around(region: &Region, slack_m: f64) -> Vec<ConvexPolygon> {
    if let Some(whole) = region.as_convex() {
        return vec![whole];
    }
    // A connected region stays one.
    let widened = Outline::from(region).widened(slack_m).regions();
    let widened = widened.first().filter(|_| slack_m > 0.0);
    let limits = widened.unwrap_or(region).rings().iter();
    let boundary = Boundary::new(limits.map(|ring| &ring.vertices[..]));
    let triangles = region.triangles();
    let mut bare = Fragments::new(triangles.iter().map(|t| t.to_vec()));
    let mut pieces = Vec::new();
    // Each part is a seed once, so that rounding cannot bring one back.
    while let Some(seed) = bare.take_largest(0.0) {
        let sides = sides(&boundary.grow(&seed));
        let held = |triangle: &[Point2<f64>; 3]| {
            let whole = triangle.to_vec();
            sides
                .iter()
                .fold(whole, |ring, side| clip_ring(&ring, side))
        };
        let points: Vec<Point2<f64>> = triangles.iter().flat_map(held).chain(seed).collect();
        // A seed too narrow for a polygon is narrower than a micrometre.
        if let Ok(polygon) = ConvexPolygon::hull(&points) {
            let gain_m2 = bare.area_in(&polygon);
            bare.subtract(&polygon);
            pieces.push(Piece { polygon, gain_m2 });
        }
    }
    drop_redundant(&mut pieces, 0.0);
    pieces.into_iter().map(|piece| piece.polygon).collect()
}
