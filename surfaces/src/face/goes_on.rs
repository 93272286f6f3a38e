//! Where a face would be beyond the border of the view, if it went on straight.

use nalgebra::{Point2, Point3, Vector2};

use crate::unseen::{CORNER_M, TELLS};
use crate::{EdgeKind, Face, UNSEEN_DEPTH_M};

/// Lengths that differ by less are equal, m.
const ROUNDING_M: f64 = 1e-9;
/// Side of the least bodies beyond the border, m.
const CELL_M: f64 = 0.1;
/// Where something cannot be, the fronts of these recede by such parts of their depth.
const RECESSES: usize = 40;
/// What is farther beside the box about a way is none of its concern, m.
const NEAR_M: f64 = 3.0;

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
        (cut_m > ROUNDING_M && beyond_m <= self.tells_m()).then_some(beyond_m)
    }

    /// How far beyond the border of the view it tells of itself, m.
    fn tells_m(&self) -> f64 {
        TELLS * self.region.area().sqrt()
    }

    /// Convex bodies that cover where something would be if the face went on ([`Self::goes_on_m`]) and where nothing
    /// was seen: squares of its plane, down to [`UNSEEN_DEPTH_M`] behind it; as far as it matters to a robot on its way.
    /// Where a body cannot be it begins as little behind the plane as it can.
    ///
    /// Shapes: of each body the 4 corners of its front, then those of its back.  Units: m.  Frames: W.
    pub fn bodies_beyond_W(
        &self,
        way_W: &[Point3<f64>],
        is_unseen: impl Fn(&Point3<f64>) -> bool,
        may_be: impl Fn(&[Point3<f64>]) -> bool,
    ) -> Vec<Vec<Point3<f64>>> {
        let of_way = bounds(
            way_W
                .iter()
                .map(|p| self.X_WF.inverse_transform_point(p).xy()),
        );
        let own = bounds(self.region.rings()[0].vertices.iter().copied());
        let (tells, near) = (Vector2::repeat(self.tells_m()), Vector2::repeat(NEAR_M));
        let from = (own.0 - tells).sup(&(of_way.0 - near));
        let cells = ((own.1 + tells).inf(&(of_way.1 + near)) - from) / CELL_M;
        if cells.min() <= 0.0 {
            return Vec::new();
        }
        let side = (cells.max().ceil() as usize).next_power_of_two();
        let node = |i: usize| {
            from + Vector2::new((i % (side + 1)) as f64, (i / (side + 1)) as f64) * CELL_M
        };
        let goes_on = |p: &Point2<f64>| {
            let at = |part: f64| self.X_WF * Point3::new(p.x, p.y, -part * UNSEEN_DEPTH_M);
            self.goes_on_m(&at(0.5)).is_some()
                && [0.1, 0.5, 0.9].iter().any(|part| is_unseen(&at(*part)))
        };
        let nodes: Vec<bool> = (0..(side + 1) * (side + 1))
            .map(|i| goes_on(&node(i)))
            .collect();
        let is_solid = |x: usize, y: usize| {
            [0, 1, side + 1, side + 2]
                .iter()
                .any(|k| nodes[y * (side + 1) + x + k])
        };
        let mut bodies = Vec::new();
        let mut squares = vec![(0, 0, side)];
        while let Some((x, y, size)) = squares.pop() {
            let cells = (0..size * size).map(|i| is_solid(x + i % size, y + i / size));
            let solid = cells.filter(|is_solid| *is_solid).count();
            if solid == 0 {
                continue;
            }
            let ends = [[0, 0], [size, 0], [size, size], [0, size]];
            let front = ends.map(|[dx, dy]| node((y + dy) * (side + 1) + x + dx));
            let at = |z: f64| front.map(|p| self.X_WF * Point3::new(p.x, p.y, z));
            let behind = |k: usize| {
                let recess_m = UNSEEN_DEPTH_M * k as f64 / RECESSES as f64;
                [at(-recess_m), at(-UNSEEN_DEPTH_M)].concat()
            };
            if solid == size * size && may_be(&behind(0)) {
                bodies.push(behind(0));
            } else if size > 1 {
                let half = size / 2;
                squares.extend(
                    [(x, y), (x + half, y), (x, y + half), (x + half, y + half)]
                        .map(|(x, y)| (x, y, half)),
                );
            } else {
                // What is farther behind is no more in the way.
                let (mut not, mut least) = (0, RECESSES);
                while least - not > 1 {
                    let k = usize::midpoint(not, least);
                    match may_be(&behind(k)) {
                        true => least = k,
                        false => not = k,
                    }
                }
                bodies.extend((least < RECESSES).then(|| behind(least)));
            }
        }
        bodies
    }
}

/// The least and greatest coordinates of points, m; of none from +∞ to −∞.
fn bounds(points: impl Iterator<Item = Point2<f64>>) -> (Point2<f64>, Point2<f64>) {
    let [low, high] = [f64::INFINITY, f64::NEG_INFINITY].map(|x| Point2::new(x, x));
    points.fold((low, high), |(low, high), p| (low.inf(&p), high.sup(&p)))
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

    #[test]
    fn bodies_are_wherever_the_wall_would_go_on_unseen_and_not_where_they_cannot_be() {
        // Seen where x < −1.5; a robot stands around x = −0.4, z = 0.3.
        let unseen = |p: &Point3<f64>| p.x > -1.5;
        let robot = Point3::new(-0.4, 0.35, 0.3);
        let is_in = |body: &[Point3<f64>], p: &Point3<f64>, by_m: f64| {
            (0..3).all(|k| {
                let along = || body.iter().map(|c| c[k]);
                let low = along().fold(f64::INFINITY, f64::min);
                let high = along().fold(f64::NEG_INFINITY, f64::max);
                (low - by_m..=high + by_m).contains(&p[k])
            })
        };
        let bodies = wall().bodies_beyond_W(&[robot], unseen, |body| !is_in(body, &robot, 0.05));
        assert!((4..100).contains(&bodies.len()), "{}", bodies.len());
        let mut behind_robot = false;
        for k in 0..4000 {
            let at = |over: usize, low: f64, high: f64| {
                low + (high - low) * ((k / over) % 20) as f64 / 20.0
            };
            let p = Point3::new(at(1, -3.0, 2.0), at(400, 0.31, 0.49), at(20, -0.5, 1.5));
            let is_solid = bodies.iter().any(|body| is_in(body, &p, 1e-9));
            let goes_on = wall().goes_on_m(&p).is_some() && unseen(&p);
            let near_robot = (p.xz() - robot.xz()).amax() < 0.2;
            assert!(is_solid || !goes_on || near_robot, "{p}");
            behind_robot |= is_solid && near_robot;
            // At most by a cell too far.
            let near = [-0.1, 0.0, 0.1].iter().any(|dx| {
                [-0.1, 0.0, 0.1].iter().any(|dz| {
                    let p = p + nalgebra::Vector3::new(*dx, 0.0, *dz);
                    wall().goes_on_m(&p).is_some() && unseen(&p)
                })
            });
            assert!(near || !is_solid, "{p}");
        }
        assert!(bodies.iter().all(|body| !is_in(body, &robot, 0.05)));
        // It stands 0.05 m behind the plane there: what is farther behind it may be.
        assert!(behind_robot);
        let none = wall().bodies_beyond_W(&[Point3::new(9.0, 0.0, 0.0)], |_| true, |_| true);
        assert_eq!(none, Vec::<Vec<Point3<f64>>>::new());
    }
}
