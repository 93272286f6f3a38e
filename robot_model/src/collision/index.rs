//! Boxes along W's axes, found by what they meet: parry's hierarchy of bounding volumes.

use glamx::DVec3;
use nalgebra::{Point3, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// Boxes along W's axes, each known by its number.
#[derive(Clone, Default)]
pub struct BoxIndex(Bvh);

impl BoxIndex {
    /// Boxes (lowest and highest corner, W, m), numbered as they come.
    pub fn new(boxes: impl IntoIterator<Item = (Point3<f64>, Point3<f64>)>) -> Self {
        let boxes = boxes.into_iter().map(|(low, high)| aabb(&low, &high));
        let boxes: Vec<Aabb> = boxes.collect();
        Self(Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes))
    }

    /// The boxes that come within `distance_m` of a box along each axis, in ascending order.
    pub fn near(&self, low: &Point3<f64>, high: &Point3<f64>, distance_m: f64) -> Vec<usize> {
        let beside = Vector3::repeat(distance_m);
        let asked = aabb(&(low - beside), &(high + beside));
        let found = self.0.intersect_aabb(&asked).map(|i| i as usize);
        let mut found: Vec<usize> = found.collect();
        found.sort_unstable();
        found
    }
}

fn aabb(low: &Point3<f64>, high: &Point3<f64>) -> Aabb {
    let corner = |p: &Point3<f64>| DVec3::new(p.x, p.y, p.z);
    Aabb::new(corner(low), corner(high))
}
