//! Links that are too near to each other, or to the environment, where contacts put them.

use nalgebra::Vector3;
use plan::Near;

use super::Claim;
use crate::TOLERANCES;
use crate::clearance::{CARRYING_JOINTS, joints_between};
use crate::distance::apart_at_most_m;
use crate::posture::inverse_point;
use crate::solid::{Placed, Solid};

impl Claim<'_> {
    /// By how much a link is nearer to another, or to a body, than it may be, m.
    ///
    /// # Errors
    /// That the two are not put, or may touch.
    pub(super) fn overlap_m(&self, link: &str, other: &Near) -> Result<f64, String> {
        let shapes = crate::shapes::shapes(self.robot);
        let names = self.robot.collision.shapes();
        let put = |link: &str| -> Vec<(usize, Placed)> {
            let of = (0..shapes.len()).filter(|&i| names[i].link == link);
            let put = of.filter_map(|i| Some((i, shapes[i].1.at(&self.put(shapes[i].0)?))));
            put.collect()
        };
        let (own, mut nearest) = (put(link), f64::INFINITY);
        let least_m = match other {
            Near::Link(other) => {
                let others = put(other);
                for &(i, j) in self.robot.collision.pairs() {
                    let at = |placed: &[(usize, Placed)], k| placed.iter().position(|p| p.0 == k);
                    for (i, j) in [(i, j), (j, i)] {
                        if let (Some(i), Some(j)) = (at(&own, i), at(&others, j)) {
                            nearest = nearest.min(apart_at_most_m(&own[i].1, &others[j].1));
                        }
                    }
                }
                self.required.self_clearance_m
            }
            Near::Body { id, points_W } => {
                let points: Vec<_> = points_W.iter().map(|p| Vector3::from(*p)).collect();
                let held = |from, body| joints_between(self.robot, from, body) <= CARRYING_JOINTS;
                let on = |body| self.places.iter().filter(move |p| held(p.patch.body, body));
                let may_touch = |shape: usize| {
                    on(shapes[shape].0).any(|place| {
                        let heights = points.iter().map(|p| inverse_point(&place.X_WC, p).z);
                        let rise_m = heights.fold(f64::NEG_INFINITY, f64::max);
                        // What rises gently beside a ball may be touched too.
                        place.patch.point_radius_m().is_some() || rise_m <= TOLERANCES.same_plane_m
                    })
                };
                if points.is_empty() || own.iter().any(|(shape, _)| may_touch(*shape)) {
                    return Err(format!("{link} may touch {id}"));
                }
                let body = Solid::hull(points, 0.0);
                for (_, shape) in &own {
                    nearest = nearest.min(apart_at_most_m(shape, &body.here()));
                }
                self.required.clearance_m
            }
        };
        match nearest.is_finite() {
            true => Ok(least_m - nearest),
            false => Err(format!("no contacts put {link} and what it is too near to")),
        }
    }
}
