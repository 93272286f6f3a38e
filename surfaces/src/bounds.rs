//! Axis-parallel boxes around points, and which of many meet one.

use nalgebra::Point3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// The box around some points.
pub(crate) type Bounds = AABB<[f64; 3]>;

/// The box around some points.
pub(crate) fn around(points: &[Point3<f64>]) -> Bounds {
    let points: Vec<[f64; 3]> = points.iter().map(|p| p.coords.into()).collect();
    AABB::from_points(&points)
}

/// Boxes, each known by its number.
pub(crate) struct BoundsTree(RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>);

impl BoundsTree {
    pub fn new(boxes: impl IntoIterator<Item = Bounds>) -> Self {
        let numbered = boxes.into_iter().enumerate();
        let numbered = numbered.map(|(i, bounds)| GeomWithData::new(bounds.into(), i));
        Self(RTree::bulk_load(numbered.collect()))
    }

    /// The numbers of the boxes that have no more than `gap_m` between them and one, along each axis.
    pub fn meeting(&self, asked: &Bounds, gap_m: f64) -> impl Iterator<Item = usize> {
        let low = asked.lower().map(|x| x - gap_m);
        let high = asked.upper().map(|x| x + gap_m);
        let found = self
            .0
            .locate_in_envelope_intersecting(&AABB::from_corners(low, high));
        found.map(|bounds| bounds.data)
    }
}
