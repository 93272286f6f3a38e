//! Where a face would be beyond the border of the view, if it went on straight.

use nalgebra::{Point2, Point3};

use crate::unseen::{CORNER_M, TELLS};
use crate::{EdgeKind, Face, UNSEEN_DEPTH_M};

/// Lengths that differ by less are equal, m.
const ROUNDING_M: f64 = 1e-9;

impl Face {
    /// How far beyond the border of the view a place is in which something would be if the face went on in its
    /// plane, m: most of what ends its region where that is nearest is cut by the border.
    ///
    /// None before the plane, or deeper behind it than anything is taken to go on; behind the region itself;
    /// beyond edges that were seen to end the face, or that hide how it goes on; and farther than the face tells:
    /// so many times as far as it is large.
    pub fn goes_on_m(&self, p_W: &Point3<f64>) -> Option<f64> {
        let p = self.X_WF.inverse_transform_point(p_W);
        if p.z >= 0.0 || p.z < -UNSEEN_DEPTH_M || self.region.contains(&p.xy()) {
            return None;
        }
        let border = self.region.nearest(&p.xy());
        let beyond_m = (p.xy() - border).norm();
        let mut cut_m = 0.0;
        for (edge, [a, b]) in self.region.segments() {
            let length_m = length_within_m([a, b], &border, CORNER_M);
            cut_m += match edge.kind {
                EdgeKind::FieldOfView => length_m,
                _ => -length_m,
            };
        }
        (cut_m > ROUNDING_M && beyond_m <= TELLS * self.region.area().sqrt()).then_some(beyond_m)
    }
}

/// How much of a segment lies within a distance of a point, m.
fn length_within_m([a, b]: [&Point2<f64>; 2], of: &Point2<f64>, within_m: f64) -> f64 {
    let length_m = (b - a).norm();
    let along = (b - a) / length_m;
    let middle = along.dot(&(of - a));
    let off_m = along.perp(&(of - a));
    let half = (within_m * within_m - off_m * off_m).max(0.0).sqrt();
    let [from, to] = [middle - half, middle + half].map(|s| s.clamp(0.0, length_m));
    to - from
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// A wall at y = 0.3 that faces −y, 1 m × 1 m, cut by the view on the side of −x.
    fn wall() -> Face {
        let axes = [Vector3::x(), Vector3::z(), -Vector3::y()];
        let X_WF = nalgebra::Isometry3::from_parts(
            nalgebra::Translation3::new(1.0, 0.3, 0.5),
            nalgebra::UnitQuaternion::from_basis_unchecked(&axes),
        );
        let mut wall = Face::rectangle("wall", X_WF, [1.0, 1.0]).unwrap();
        let ring = wall.region.rings()[0].clone();
        let kinds = ring.segments().map(|(_, [a, b])| a.x < 0.0 && b.x < 0.0);
        let kinds: Vec<bool> = kinds.collect();
        for (edge, cut) in wall.region.edges_mut().flatten().zip(kinds) {
            edge.kind = if cut {
                EdgeKind::FieldOfView
            } else {
                EdgeKind::Real
            };
        }
        wall
    }

    #[test]
    fn a_wall_goes_on_where_the_view_cuts_it_and_nowhere_else() {
        let at = |x, y, z| wall().goes_on_m(&Point3::new(x, y, z));
        let beyond_m = at(-0.3, 0.35, 0.5).unwrap();
        assert!((beyond_m - 0.8).abs() < 1e-9, "{beyond_m}");
        // Before it, far behind it, beyond its other end, above it, behind it, and too far along.
        assert_eq!(at(-0.3, 0.25, 0.5), None);
        assert_eq!(at(-0.3, 0.6, 0.5), None);
        assert_eq!(at(1.8, 0.35, 0.5), None);
        assert_eq!(at(1.0, 0.35, 1.2), None);
        assert_eq!(at(1.0, 0.35, 0.5), None);
        assert_eq!(at(-3.0, 0.35, 0.5), None);
        // Above the corner at which it was seen to end, and below that.
        assert_eq!(at(-0.3, 0.35, 1.2), None);
        assert!(at(-0.3, 0.35, 0.99).is_some());
    }
}
