//! A region enclosed by convex pieces: what a cover inside the region leaves bare at its border, these hold.

use nalgebra::Point2;

use super::fragments::Fragments;
use super::grow::{Boundary, sides};
use super::{Piece, core, drop_redundant};
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
    while let Some(seed) = bare.largest() {
        // The core of a seed leaves the piece free to turn.
        let grown = [core(&seed), seed.clone()].map(|from| {
            let sides = sides(&boundary.grow(&from));
            let held = |triangle: &[Point2<f64>; 3]| {
                let whole = triangle.to_vec();
                sides
                    .iter()
                    .fold(whole, |ring, side| clip_ring(&ring, side))
            };
            let points: Vec<Point2<f64>> = triangles.iter().flat_map(held).chain(from).collect();
            let polygon = ConvexPolygon::hull(&points).ok()?;
            let gain_m2 = bare.area_in(&polygon);
            Some(Piece { polygon, gain_m2 })
        });
        let larger = |a: Piece, b: Piece| if a.gain_m2 > b.gain_m2 { a } else { b };
        // A seed too narrow for a polygon is narrower than a micrometre.
        let Some(piece) = grown.into_iter().flatten().reduce(larger) else {
            break;
        };
        bare.subtract(&piece.polygon);
        pieces.push(piece);
    }
    drop_redundant(&mut pieces, 0.0);
    pieces.into_iter().map(|piece| piece.polygon).collect()
}
