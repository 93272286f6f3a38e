//! The ball that a rounded end touches with.

use nalgebra::{Matrix4, Point3, Vector3, Vector4};

/// Half of the cone of directions that a foot's end is touched from, rad: of the first in which it is round to
/// within [`ROUND_M`]. A leg that leans shows its side in a wide one.
const CONES_RAD: [f64; 3] = [0.7, 0.5, 0.35];
const ROUND_M: f64 = 1e-3;
/// Rings and directions a ring.
const RINGS: usize = 4;
const AROUND: usize = 12;
/// How far a body may stick out of a ball or fall short of it that is taken for its end, of the radius.
const ALIKE: f64 = 0.1;
/// Smallest radius of a ball, m.
const SMALLEST_M: f64 = 1e-3;

/// A ball and how far the body sticks out of it or falls short, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub centre: Point3<f64>,
    /// Its radius, m.
    pub radius_m: f64,
    /// The greatest difference of the support functions over the cone, m.
    pub off_m: f64,
}

/// The ball that a body with this support function is nearest to, seen from directions about `down`:
///
///   min Σ (h(u) − c·u − r)²  over unit u within the cone
///
/// linear in centre and radius, and exact where a ball is what is there.
pub fn fit(support: &dyn Fn(&Vector3<f64>) -> Point3<f64>, down: &Vector3<f64>) -> Option<Ball> {
    let balls = CONES_RAD.map(|cone| within(support, down, cone));
    let mut balls = balls.into_iter().flatten();
    let round = balls.clone().find(|ball| ball.off_m <= ROUND_M);
    round.or_else(|| balls.next())
}

/// That of the directions within a cone.
fn within(
    support: &dyn Fn(&Vector3<f64>) -> Point3<f64>,
    down: &Vector3<f64>,
    cone_rad: f64,
) -> Option<Ball> {
    let directions = cone(down, cone_rad)?;
    let height = |u: &Vector3<f64>| support(u).coords.dot(u);
    let (mut A, mut b) = (Matrix4::zeros(), Vector4::zeros());
    for u in &directions {
        let row = Vector4::new(u.x, u.y, u.z, 1.0);
        A += row * row.transpose();
        b += row * height(u);
    }
    let solved = A.cholesky()?.solve(&b);
    let mut centre = Point3::from(solved.xyz());
    let mut radius_m = solved.w;
    if radius_m < SMALLEST_M {
        // A spike: the smallest ball at its end.
        radius_m = SMALLEST_M;
        centre = support(down) - down * radius_m;
    }
    let off = |u: &Vector3<f64>| (height(u) - centre.coords.dot(u) - radius_m).abs();
    let off_m = directions.iter().map(off).fold(0.0, f64::max);
    Some(Ball {
        centre,
        radius_m,
        off_m,
    })
}

/// Whether a body with this support function ends as a ball does, to within [`ALIKE`] of its radius: seen from all
/// directions within the narrowest cone about some direction.
pub fn ends_as(
    support: &dyn Fn(&Vector3<f64>) -> Point3<f64>,
    centre: &Point3<f64>,
    radius_m: f64,
) -> bool {
    let is_alike = |u: &Vector3<f64>| {
        let height_m = (support(u) - centre).dot(u);
        (height_m - radius_m).abs() <= ALIKE * radius_m
    };
    let signs = || [-1.0, 0.0, 1.0].into_iter();
    let axes = signs().flat_map(|x| signs().flat_map(move |y| signs().map(move |z| [x, y, z])));
    axes.filter_map(|axis| Vector3::from(axis).try_normalize(1e-9))
        .filter(&is_alike)
        .filter_map(|axis| cone(&axis, CONES_RAD[CONES_RAD.len() - 1]))
        .any(|directions| directions.iter().all(&is_alike))
}

/// Unit vectors within a cone about one, itself first; nothing about a vector without direction.
fn cone(axis: &Vector3<f64>, cone_rad: f64) -> Option<Vec<Vector3<f64>>> {
    let x = axis
        .cross(&Vector3::ith(axis.iamin(), 1.0))
        .try_normalize(1e-9)?;
    let y = axis.cross(&x);
    let mut directions = vec![*axis];
    for ring in 1..=RINGS {
        let (sin, cos) = (cone_rad * ring as f64 / RINGS as f64).sin_cos();
        directions.extend((0..AROUND).map(|k| {
            let (s, c) = (std::f64::consts::TAU * k as f64 / AROUND as f64).sin_cos();
            axis * cos + (x * c + y * s) * sin
        }));
    }
    Some(directions)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shank that leans by 43° shows its side to a wide cone, and stands on its round tip.
    #[test]
    fn a_leg_that_leans_stands_on_its_tip() {
        let (tip, radius_m) = (Point3::new(0.1, 0.0, -0.1), 3e-3);
        let side = [Point3::new(0.0, 0.0, -0.022), Point3::new(0.022, 0.0, 0.0)];
        let support = |u: &Vector3<f64>| {
            let ball = tip + u * radius_m;
            let height = |p: &Point3<f64>| p.coords.dot(u);
            let ends = side.into_iter().chain([ball]);
            ends.max_by(|a, b| height(a).total_cmp(&height(b))).unwrap()
        };
        let ball = fit(&support, &-Vector3::z()).unwrap();
        assert!((ball.centre - tip).norm() < 1e-6, "{ball:?}");
        assert!(
            (ball.radius_m - radius_m).abs() < 1e-6 && ball.off_m < 1e-6,
            "{ball:?}"
        );
        assert!(within(&support, &-Vector3::z(), 0.7).unwrap().off_m > 1e-3);
    }

    /// A foot that is round below alone, under a shank: where the ball's middle is over the foot, the shank holds it,
    /// and the foot is what ends as the ball does.
    #[test]
    fn what_is_round_below_ends_as_its_ball_does_and_a_shank_does_not() {
        let (centre, radius_m) = (Point3::new(0.0, 0.01, 0.0), 0.03);
        let foremost = |points: &[Point3<f64>], u: &Vector3<f64>| {
            let far =
                |a: &&Point3<f64>, b: &&Point3<f64>| a.coords.dot(u).total_cmp(&b.coords.dot(u));
            *points.iter().max_by(far).unwrap()
        };
        let rim = cone(&-Vector3::z(), 0.8).unwrap();
        let foot: Vec<_> = rim.iter().map(|u| centre + u * radius_m).collect();
        assert!(foot.iter().all(|p| p.z < -0.01), "its middle is over it");
        assert!(ends_as(&|u| foremost(&foot, u), &centre, radius_m));
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
        let shank: Vec<_> = corners
            .iter()
            .flat_map(|[x, y]| [-0.02, 0.2].map(|z| centre + Vector3::new(0.015 * x, 0.015 * y, z)))
            .collect();
        assert!(!ends_as(&|u| foremost(&shank, u), &centre, radius_m));
    }
}
