//! Points of a region: inside or not, the nearest to another.

use nalgebra::Point2;

use crate::Region;

impl Region {
    /// Whether the point lies in the region, by the crossings of a ray along x with its edges.
    pub fn contains(&self, p: &Point2<f64>) -> bool {
        let crossed = |a: &Point2<f64>, b: &Point2<f64>| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        let crossings = self.segments().filter(|(_, [a, b])| crossed(a, b));
        crossings.count() % 2 == 1
    }

    /// The region's point nearest to a point of the plane: the point itself where it is inside.
    pub fn nearest(&self, p: &Point2<f64>) -> Point2<f64> {
        if self.contains(p) {
            return *p;
        }
        let on_edge = |[a, b]: [&Point2<f64>; 2]| {
            let edge = b - a;
            let along = edge.dot(&(p - a)) / edge.norm_squared();
            a + edge * along.clamp(0.0, 1.0)
        };
        let places = self.segments().map(|(_, ends)| on_edge(ends));
        let nearer = |a: &Point2<f64>, b: &Point2<f64>| {
            let distance = |q: &Point2<f64>| (q - p).norm_squared();
            distance(a).total_cmp(&distance(b))
        };
        places.min_by(nearer).unwrap_or(*p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_in_holes_and_beside_the_region_go_to_the_nearest_edge() {
        let square = |half: f64| {
            let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
            corners.map(|(x, y)| Point2::new(x, y)).to_vec()
        };
        let frame = Region::new([square(2.0), square(1.0)]).unwrap();
        for ([x, y], [to_x, to_y]) in [
            ([1.5, 0.3], [1.5, 0.3]),
            ([0.9, 0.2], [1.0, 0.2]),
            ([3.0, 0.5], [2.0, 0.5]),
            ([-5.0, -3.0], [-2.0, -2.0]),
        ] {
            let nearest = frame.nearest(&Point2::new(x, y));
            assert!(
                (nearest - Point2::new(to_x, to_y)).norm() < 1e-12,
                "{nearest}"
            );
        }
    }
}
