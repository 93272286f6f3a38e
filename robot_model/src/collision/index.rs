//! Boxes along W's axes, found by what they meet: parry's hierarchy of bounding volumes.

use nalgebra::{Point3, Vector3};
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

use super::parry::aabb;

/// Boxes along W's axes, each known by its number.
#[derive(Clone, Default)]
pub struct BoxIndex(Bvh);

impl BoxIndex {
    /// Boxes (lowest and highest corner, W, m), numbered as they come.
    pub fn new(boxes: impl IntoIterator<Item = (Point3<f64>, Point3<f64>)>) -> Self {
        let boxes = boxes.into_iter().map(|(low, high)| aabb(&low, &high));
        let boxes: Vec<_> = boxes.collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_near_a_box_are_found_in_their_order() {
        let cube = |x: f64| (Point3::new(x, 0.0, 0.0), Point3::new(x + 1.0, 1.0, 1.0));
        let index = BoxIndex::new([5.0, 0.0, 2.5, -9.0].map(cube));
        let (low, high) = cube(1.2);
        assert_eq!(index.near(&low, &high, 0.25), [1]);
        assert_eq!(index.near(&low, &high, 0.35), [1, 2]);
        assert_eq!(index.near(&low, &high, 10.0), [0, 1, 2, 3]);
        assert!(BoxIndex::default().near(&low, &high, 1e3).is_empty());
    }
}
