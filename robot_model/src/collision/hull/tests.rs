use nalgebra::Isometry3;
use proptest::prelude::*;

use super::*;
use crate::collision::{ShapeGeometry, closest};

fn cube() -> Vec<Point3<f64>> {
    (0..8_u8)
        .map(|i| Point3::from([0, 1, 2].map(|bit| f64::from(i >> bit & 1))))
        .collect()
}

/// The greatest height of a point above a face.
fn greatest_height(hull: &Hull, points: &[Point3<f64>]) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    for (normal, triangle) in hull.face_normals().zip(hull.triangles()) {
        let on_face = hull.vertices()[triangle[0] as usize];
        for p in points {
            worst = worst.max(normal.dot(&(p - on_face)));
        }
    }
    worst
}

#[test]
fn a_cube_has_eight_corners_and_twelve_triangles() {
    let mut points = cube();
    points.push(Point3::new(0.5, 0.5, 0.5));
    points.push(Point3::new(0.5, 0.5, 1.0));
    let hull = Hull::new(&points).unwrap();
    assert_eq!((hull.vertices().len(), hull.triangles().len()), (8, 12));
    assert!((hull.volume() - 1.0).abs() < 1e-12);
    assert_eq!(hull.shortfall_m(), 0.0);
}

#[test]
fn flat_and_foul_points_are_refused() {
    let flat: Vec<_> = (0..9_u8)
        .map(|i| Point3::new(f64::from(i % 3), f64::from(i / 3), 0.25))
        .collect();
    assert!(matches!(Hull::new(&flat), Err(HullError::Flat { .. })));
    assert!(matches!(Hull::new(&flat[..3]), Err(HullError::TooFew(3))));
    assert!(matches!(
        Hull::new(&[Point3::origin(); 5]),
        Err(HullError::Flat { .. })
    ));
    let mut points = cube();
    points[3].y = f64::NAN;
    assert_eq!(Hull::new(&points).err(), Some(HullError::NotFinite(3)));
}

#[test]
fn a_reduced_hull_says_by_how_much_it_falls_short() {
    // A thousand points on a ball by the golden angle.
    let points: Vec<Point3<f64>> = (0..1000)
        .map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 1000.0;
            let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Point3::new(r * cos, r * sin, z) * 0.1
        })
        .collect();
    let hull = Hull::simplified(&points, 0.0, 64).unwrap();
    assert!(hull.vertices().len() <= 64);
    // Farther than the greatest height over a face, and reached by a point: the nearest points of a
    // small ball there, as the distances have them.
    let far = points
        .iter()
        .map(|p| distance_m(&hull, p))
        .fold(0.0, f64::max);
    let short = hull.shortfall_m();
    assert!((far - short).abs() < 1e-9, "{far} {short}");
    assert!(short >= greatest_height(&hull, &points) - 1e-9);
    // 64 points well spread on a ball leave caps of less than a tenth of its radius.
    assert!(short < 0.01, "{short}");
    // As few as the shortfall asks for.
    let fine = Hull::simplified(&points, 0.002, usize::MAX).unwrap();
    assert!(fine.vertices().len() > 64 && fine.vertices().len() < 500);
    assert!(fine.shortfall_m() < 0.0025, "{}", fine.shortfall_m());
}

/// Distance of a point from a hull without what it falls short of, m.
fn distance_m(hull: &Hull, p: &Point3<f64>) -> f64 {
    let point = ShapeGeometry::Sphere { radius_m: 1e-12 };
    let (at, origin) = (Isometry3::translation(p.x, p.y, p.z), Isometry3::identity());
    let whole = ShapeGeometry::ConvexHull(hull.clone());
    let found = closest(&point, &at, &whole, &origin, 1.0).unwrap();
    found.distance + hull.shortfall_m()
}

proptest! {
    #[test]
    fn every_point_is_inside(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..60)
    ) {
        let points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
        let hull = Hull::new(&points).unwrap();
        prop_assert!(greatest_height(&hull, &points) < 1e-7);
    }

    /// Grid points are as degenerate as meshes get: many on each face, edge and corner.
    #[test]
    fn grids_are_no_trouble(
        points in prop::collection::vec(prop::array::uniform3(0..4_i8), 4..80),
        scale in 1e-3..10.0_f64,
    ) {
        let points: Vec<Point3<f64>> = points
            .into_iter()
            .map(|p| Point3::from(p.map(|c| f64::from(c) * scale)))
            .collect();
        match Hull::new(&points) {
            Ok(hull) => prop_assert!(greatest_height(&hull, &points) < 1e-6 * scale),
            Err(HullError::Flat { .. }) => {}
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// Whatever the numbers are, there is an answer.
    #[test]
    fn nothing_panics(points in prop::collection::vec(prop::array::uniform3(any::<f64>()), 0..30)) {
        let points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
        let _ = Hull::new(&points);
        let small: Vec<_> = points.iter().map(|p| p.map(|c| c.clamp(-1e-12, 1e-12))).collect();
        let _ = Hull::new(&small);
    }
}
