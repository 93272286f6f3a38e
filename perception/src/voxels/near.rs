//! The points of a cloud within range.

use nalgebra::Vector3;

use crate::scan::Scan;

/// The points within range, which are counted in the order of the cloud.
pub(super) struct Near<'a> {
    cloud: &'a [[f32; 3]],
    eye_V: Vector3<f64>,
    /// Index in the cloud of each.
    pub places: Vec<u32>,
}

impl<'a> Near<'a> {
    /// Those no farther than this from the eye.
    pub fn new(scan: &'a Scan, range_max_m: f64) -> Self {
        let (cloud, eye_V) = (&scan.cloud.points[..], scan.eye_V);
        let square = range_max_m * range_max_m;
        let mut places = vec![0; cloud.len()];
        let mut count = 0;
        for (place, p) in (0..).zip(cloud) {
            // Not so for what is not finite. All are written: to branch takes longer.
            places[count] = place;
            count += usize::from((from_eye(p, &eye_V)).norm_squared() <= square);
        }
        places.truncate(count);
        Self {
            cloud,
            eye_V,
            places,
        }
    }

    /// A point from the eye, m.
    #[inline]
    pub fn at(&self, i: u32) -> Vector3<f64> {
        from_eye(&self.cloud[self.places[i as usize] as usize], &self.eye_V)
    }

    /// All of them in order.
    pub fn iter(&self) -> impl Iterator<Item = Vector3<f64>> + Clone {
        let of = |place: &u32| from_eye(&self.cloud[*place as usize], &self.eye_V);
        self.places.iter().map(of)
    }
}

fn from_eye(p: &[f32; 3], eye_V: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(p.map(f64::from)) - eye_V
}
