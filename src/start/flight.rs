//! A tread whose front the view cuts, and where it begins by the flight behind it.

use nalgebra::Point3;
use surfaces::{Face, Obstacle};

/// Rises of one flight are equal up to this, m.
const RISE_M: f64 = 0.03;
/// How far the body of what was not seen stays under the tread's plane, m.
const UNDER_M: f64 = 1e-3;

/// Where the front of a flight's first tread is, x in m, of which the part that is seen begins at `cut`: before the next
/// front by the deepest run that is seen behind it. `fronts` are the foremost points of the fronts that are seen, in any
/// order, `height_m` is the ground's. All in W, x ahead and up the flight.
///
/// Nothing where fewer than two fronts follow with the tread's own rise over the ground: it may then begin anywhere.
pub fn begins_m(cut: &Point3<f64>, mut fronts: Vec<Point3<f64>>, height_m: f64) -> Option<f64> {
    fronts.sort_by(|a, b| a.x.total_cmp(&b.x));
    let rise_m = cut.z - height_m;
    let mut flight: Vec<Point3<f64>> = Vec::new();
    for front in fronts {
        let below = flight.last().unwrap_or(cut);
        if (front.z - below.z - rise_m).abs() < RISE_M && front.x > below.x {
            flight.push(front);
        }
    }
    let runs = flight.windows(2).map(|pair| pair[1].x - pair[0].x);
    let deepest_m = runs.reduce(f64::max)?;
    Some((flight[0].x - deepest_m).min(cut.x))
}

/// The body of a tread before where it is seen, between two places along x, from the ground up.
pub fn unseen_part(tread: &Face, [from, to]: [f64; 2], height_m: f64) -> Obstacle {
    let vertices = tread.vertices_W();
    let across = |pick: fn(f64, f64) -> f64| vertices.iter().map(|v| v.y).reduce(pick);
    let ends = [across(f64::min), across(f64::max)].map(Option::unwrap_or_default);
    let n = tread.normal_W();
    let corners = [from, to].into_iter().flat_map(|x| ends.map(|y| (x, y)));
    let points = corners.flat_map(|(x, y)| {
        let low = Point3::new(x, y, height_m);
        let up_m = -tread.height_of(&low) / n.z - UNDER_M;
        [low, Point3::new(x, y, height_m + up_m)]
    });
    Obstacle {
        id: format!("{}/cut", tread.id),
        points_W: points.collect(),
        surface: None,
        assumed: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_tread_is_as_deep_as_the_deepest_behind_it() {
        let cut = Point3::new(0.73, 0.0, 0.165);
        let front = |x: f64, k: f64| Point3::new(x, 0.0, 0.165 * k);
        let flight = vec![front(1.19, 3.0), front(0.93, 2.0), front(1.44, 4.0)];
        let begins = begins_m(&cut, flight.clone(), 0.0).unwrap();
        assert!((begins - 0.67).abs() < 1e-9, "{begins}");
        // It begins before what is seen of it in any case.
        let far = Point3::new(0.6, 0.0, 0.165);
        assert_eq!(begins_m(&far, flight.clone(), 0.0), Some(0.6));
        // One front tells no run; a tread of two rises hides another one.
        assert_eq!(begins_m(&cut, flight[1..2].to_vec(), 0.0), None);
        assert_eq!(begins_m(&cut, flight, -0.165), None);
    }
}
