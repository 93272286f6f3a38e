//! Points within range of the sensor.

use nalgebra::{Point3, Vector3};

/// The finite points no farther than `range_max_m` from where the sensor stood, in order.
///
/// Source: [brossette2013] III-B: farther points are not reliable.
pub(super) fn crop<'a>(
    points: impl Iterator<Item = &'a [f32; 3]>,
    eye_V: &Vector3<f64>,
    range_max_m: f64,
) -> Vec<Point3<f64>> {
    points
        .filter(|p| p.iter().all(|c| c.is_finite()))
        .map(|p| Point3::from(p.map(f64::from)))
        .filter(|p| (p.coords - eye_V).norm() <= range_max_m)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_finite_points_in_range_of_the_sensor() {
        let points = [
            [1.0, 0.0, 0.0],
            [f32::NAN, 0.0, 0.0],
            [9.0, 0.0, 0.0],
            [5.0, 0.0, 0.0],
        ];
        let kept = crop(points.iter(), &Vector3::new(8.0, 0.0, 0.0), 3.0);
        assert_eq!(
            kept,
            [Point3::new(9.0, 0.0, 0.0), Point3::new(5.0, 0.0, 0.0)]
        );
    }
}
