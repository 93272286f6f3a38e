//! What a spinning range finder measured, in its own frame.

use crate::Error;
use crate::error::within;

/// Points of a LiDAR in its frame V: x forward, y left, z up, the origin at the optical centre.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LidarCloud {
    /// x, y, z, m; all finite.
    pub points_V: Vec<[f32; 3]>,
    /// Ring of every point, from the lowest beam; empty where the source does not tell.
    pub ring: Vec<u16>,
    /// Azimuth of every point, counter-clockwise about z from x, rad.
    pub azimuth_rad: Vec<f32>,
    /// Time of every point since the first one, s; empty where the source does not tell.
    pub time_s: Vec<f32>,
    /// Points that were dropped because a coordinate is NaN, infinite, or all are zero.
    pub invalid: usize,
}

impl LidarCloud {
    /// Points.
    pub fn len(&self) -> usize {
        self.points_V.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.points_V.is_empty()
    }

    /// A cloud of points of which nothing else is known; azimuths are computed.
    pub fn from_points(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        let mut cloud = Self::default();
        for p_V in points {
            cloud.push(p_V, None, None, None);
        }
        cloud
    }

    /// Adds a point, or counts it as invalid. Either all points have a ring (a time), or none.
    pub(crate) fn push(
        &mut self,
        p_V: [f32; 3],
        ring: Option<u16>,
        azimuth_rad: Option<f32>,
        time_s: Option<f32>,
    ) {
        let finite = p_V.iter().all(|c| c.is_finite());
        if !finite || p_V == [0.0; 3] {
            self.invalid += 1;
            return;
        }
        self.points_V.push(p_V);
        self.azimuth_rad
            .push(azimuth_rad.unwrap_or_else(|| p_V[1].atan2(p_V[0])));
        self.ring.extend(ring);
        self.time_s.extend(time_s);
    }

    /// The same points as they are seen from another place than the origin, for clouds that were moved
    /// after the scan: V is then there, its axes those of the file.
    pub fn seen_from(&self, eye_m: [f64; 3]) -> Self {
        let mut cloud = Self {
            invalid: self.invalid,
            ..Self::default()
        };
        for (i, p) in self.points_V.iter().enumerate() {
            let p_V = [0, 1, 2].map(|k| (f64::from(p[k]) - eye_m[k]) as f32);
            let (ring, time) = (self.ring.get(i).copied(), self.time_s.get(i).copied());
            cloud.push(p_V, ring, None, time);
        }
        cloud
    }

    /// The part inside a horizontal field of view that is centred on V's x.
    ///
    /// # Errors
    /// [`Error::Config`] for a field of view outside (0, 2π].
    /// Source: \[meng\] IV, which uses 180°.
    pub fn cropped(&self, view_rad: f64) -> Result<Self, Error> {
        let turn = std::f64::consts::TAU;
        within(
            "view_rad",
            view_rad,
            1e-3,
            turn + 1e-9,
            "must be in (0, 2π]",
        )?;
        if view_rad >= turn {
            return Ok(self.clone());
        }
        let half = (view_rad / 2.0) as f32;
        Ok(self.select(|i| {
            let [x, y, _] = self.points_V[i];
            y.atan2(x).abs() <= half
        }))
    }

    /// The points of which `keep` approves, in order.
    pub(crate) fn select(&self, keep: impl Fn(usize) -> bool) -> Self {
        let mut cloud = Self {
            invalid: self.invalid,
            ..Self::default()
        };
        for i in (0..self.len()).filter(|&i| keep(i)) {
            cloud.points_V.push(self.points_V[i]);
            cloud.azimuth_rad.push(self.azimuth_rad[i]);
            cloud.ring.extend(self.ring.get(i));
            cloud.time_s.extend(self.time_s.get(i));
        }
        cloud
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cloud_is_seen_from_where_the_sensor_stood() {
        let mut cloud = LidarCloud::default();
        cloud.push([1.0, 2.0, 0.5], Some(3), Some(7.0), Some(0.1));
        cloud.push([1.0, 1.0, 1.0], Some(4), None, Some(0.2));
        let seen = cloud.seen_from([1.0, 1.0, 1.0]);
        assert_eq!(seen.points_V, [[0.0, 1.0, -0.5]]);
        assert_eq!((seen.ring.as_slice(), seen.invalid), (&[3][..], 1));
        assert!((seen.azimuth_rad[0] - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn a_crop_keeps_what_lies_ahead_and_the_fields_beside_it() {
        let mut cloud = LidarCloud::default();
        for (i, p) in [
            [1.0, 0.5, 0.0],
            [-1.0, 0.1, 0.0],
            [0.1, -1.0, 0.3],
            [f32::NAN; 3],
        ]
        .into_iter()
        .enumerate()
        {
            cloud.push(p, Some(i as u16), None, Some(i as f32));
        }
        assert_eq!((cloud.len(), cloud.invalid), (3, 1));
        let half = cloud.cropped(std::f64::consts::PI).unwrap();
        assert_eq!(half.ring, [0, 2]);
        assert_eq!(half.time_s, [0.0, 2.0]);
        assert_eq!(cloud.cropped(std::f64::consts::TAU).unwrap(), cloud);
        assert!(cloud.cropped(0.0).is_err());
        assert!(cloud.cropped(f64::NAN).is_err());
    }
}
