//! The cloud ring by ring along the azimuth: neighbours without a search.

use super::cloud::LidarCloud;

/// Vertical angles of neighbouring beams of a VLP-16 are this far apart, rad.
const VLP16_STEP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Lowest beam of a VLP-16, rad.
const VLP16_LOWEST_RAD: f64 = -15.0 * std::f64::consts::PI / 180.0;
/// A ring whose azimuths span more than this is closed, rad.
const CLOSED_RAD: f32 = 6.1;

/// Points sorted by ring, then by azimuth.
pub(super) struct Rings {
    /// Coordinates in V, m.
    pub x: Vec<f32>,
    /// See `x`.
    pub y: Vec<f32>,
    /// See `x`.
    pub z: Vec<f32>,
    /// Distance from the sensor, m.
    pub range: Vec<f32>,
    /// Azimuth, rad.
    pub azimuth: Vec<f32>,
    /// Ring of every point.
    pub ring: Vec<u16>,
    /// Index of every point in the cloud it comes from.
    pub source: Vec<u32>,
    /// Where each ring begins; one more than there are rings.
    pub starts: Vec<usize>,
    /// Whether the rings go round.
    pub closed: bool,
}

impl Rings {
    /// The points of a cloud within range; `None` when it has no rings and none can be told from the
    /// vertical angles.
    pub fn new(cloud: &LidarCloud, range_m: (f64, f64)) -> Option<Self> {
        // A field that is the same for all points is no ring.
        let told = cloud.ring.len() == cloud.len()
            && cloud
                .ring
                .iter()
                .any(|ring| Some(ring) != cloud.ring.first());
        let rings = if told {
            cloud.ring.clone()
        } else {
            rings_of_vlp16(cloud)?
        };
        let (near, far) = (range_m.0 as f32, range_m.1 as f32);
        let mut order: Vec<(u16, f32, u32)> = Vec::with_capacity(cloud.len());
        for (i, [x, y, z]) in cloud.points_V.iter().enumerate() {
            let range = (x * x + y * y + z * z).sqrt();
            if range >= near && range <= far {
                order.push((rings[i], cloud.azimuth_rad[i], i as u32));
            }
        }
        order.sort_by(|a, b| {
            (a.0.cmp(&b.0))
                .then(a.1.total_cmp(&b.1))
                .then(a.2.cmp(&b.2))
        });
        let count = order.last().map_or(0, |last| usize::from(last.0) + 1);
        let mut starts = vec![0; count + 1];
        for (ring, ..) in &order {
            starts[usize::from(*ring) + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let n = order.len();
        let mut this = Self {
            x: Vec::with_capacity(n),
            y: Vec::with_capacity(n),
            z: Vec::with_capacity(n),
            range: Vec::with_capacity(n),
            azimuth: Vec::with_capacity(n),
            ring: Vec::with_capacity(n),
            source: Vec::with_capacity(n),
            starts,
            closed: false,
        };
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (ring, azimuth, i) in order {
            let [x, y, z] = cloud.points_V[i as usize];
            this.x.push(x);
            this.y.push(y);
            this.z.push(z);
            this.range.push((x * x + y * y + z * z).sqrt());
            this.azimuth.push(azimuth);
            this.ring.push(ring);
            this.source.push(i);
            low = low.min(azimuth);
            high = high.max(azimuth);
        }
        this.closed = high - low > CLOSED_RAD;
        Some(this)
    }

    /// Points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Rings, empty ones among them.
    pub fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// For every point the place in `ring` (of those that begin at `starts`) at which its azimuth
    /// would stand.
    pub fn places_in(&self, ring: usize, of: usize) -> Vec<u32> {
        let (from, to) = (self.starts[ring], self.starts[ring + 1]);
        let mut place = from;
        let mut places = Vec::with_capacity(self.starts[of + 1] - self.starts[of]);
        for i in self.starts[of]..self.starts[of + 1] {
            let azimuth = self.azimuth[i];
            while place < to && self.azimuth[place] < azimuth {
                place += 1;
            }
            // The nearer of the two that the azimuth lies between.
            let before = place > from
                && (place == to
                    || azimuth - self.azimuth[place - 1] < self.azimuth[place] - azimuth);
            places.push((if before { place - 1 } else { place }) as u32);
        }
        places
    }

    /// Without the points of which `keep` is false.
    pub fn retain(&mut self, keep: &[bool]) {
        let mut starts = vec![0; self.starts.len()];
        for (i, ring) in self.ring.iter().enumerate() {
            if keep[i] {
                starts[usize::from(*ring) + 1] += 1;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.starts = starts;
        let mut columns = [
            &mut self.x,
            &mut self.y,
            &mut self.z,
            &mut self.range,
            &mut self.azimuth,
        ];
        let mut next = 0;
        for i in (0..keep.len()).filter(|i| keep[*i]) {
            columns
                .iter_mut()
                .for_each(|column| column[next] = column[i]);
            self.ring[next] = self.ring[i];
            self.source[next] = self.source[i];
            next += 1;
        }
        columns.iter_mut().for_each(|column| column.truncate(next));
        self.ring.truncate(next);
        self.source.truncate(next);
    }
}

/// The rings of a VLP-16 by the vertical angle of its points, where nine in ten lie within a fifth of
/// a step of a beam: so they are in a cloud that was not moved after the scan.
fn rings_of_vlp16(cloud: &LidarCloud) -> Option<Vec<u16>> {
    let mut rings = Vec::with_capacity(cloud.len());
    let mut near = 0;
    for [x, y, z] in &cloud.points_V {
        let elevation = f64::from(*z).atan2(f64::from(x.hypot(*y)));
        let place = (elevation - VLP16_LOWEST_RAD) / VLP16_STEP_RAD;
        let ring = place.round().clamp(0.0, 15.0);
        near += usize::from((place - ring).abs() < 0.2);
        rings.push(ring as u16);
    }
    (near * 10 >= cloud.len() * 9 && !cloud.is_empty()).then_some(rings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> LidarCloud {
        let mut points = Vec::new();
        for ring in 0..16 {
            for step in 0..40 {
                let (e, a) = (
                    (-15.0 + 2.0 * f64::from(ring)).to_radians(),
                    (f64::from(step) * 0.7 - 14.0).to_radians(),
                );
                let r = 3.0 + 0.01 * f64::from(step);
                let p = [e.cos() * a.cos(), e.cos() * a.sin(), e.sin()];
                points.push(p.map(|c| (r * c) as f32));
            }
        }
        LidarCloud::from_points(points)
    }

    #[test]
    fn rings_are_told_from_vertical_angles_and_kept_in_order() {
        let rings = Rings::new(&cloud(), (0.3, 20.0)).unwrap();
        assert_eq!((rings.len(), rings.count()), (640, 16));
        assert!(rings.starts.windows(2).all(|w| w[1] - w[0] == 40));
        for ring in 0..16 {
            let azimuths = &rings.azimuth[rings.starts[ring]..rings.starts[ring + 1]];
            assert!(azimuths.windows(2).all(|w| w[0] <= w[1]));
        }
        // The same azimuth in the next ring is the same place in it.
        let places = rings.places_in(5, 4);
        assert!(
            places
                .iter()
                .enumerate()
                .all(|(i, &p)| p as usize == 200 + i)
        );
    }

    #[test]
    fn points_that_lie_on_no_beams_have_no_rings() {
        let tilted = cloud()
            .points_V
            .into_iter()
            .map(|[x, y, z]| [x, 0.8 * y + 0.6 * z, 0.8 * z - 0.6 * y]);
        assert!(Rings::new(&LidarCloud::from_points(tilted), (0.3, 20.0)).is_none());
    }

    #[test]
    fn retaining_keeps_rings_apart() {
        let mut rings = Rings::new(&cloud(), (0.3, 20.0)).unwrap();
        let keep: Vec<bool> = (0..rings.len()).map(|i| i % 3 != 0).collect();
        let expected: Vec<u32> = (0..640)
            .filter(|i| i % 3 != 0)
            .map(|i| rings.source[i])
            .collect();
        rings.retain(&keep);
        assert_eq!(rings.source, expected);
        for (i, ring) in rings.ring.iter().enumerate() {
            let (from, to) = (
                rings.starts[usize::from(*ring)],
                rings.starts[usize::from(*ring) + 1],
            );
            assert!((from..to).contains(&i));
        }
    }
}
