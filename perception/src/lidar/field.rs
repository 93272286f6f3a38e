//! The filtered points with what their neighbours tell: normals, how well these agree, and links.

use nalgebra::{Point3, Vector3};

use super::rings::Rings;
use crate::Error;
use crate::brossette2013::{neighbours, normals};

/// No point.
pub(super) const NONE: u32 = u32::MAX;
/// Points on either side along a ring that a tangent is taken over.
const REACH: usize = 5;
/// Points on either side that are averaged first.
const SMOOTH: usize = 3;
/// Points that are linked across rings differ by less than this in azimuth, rad.
const ACROSS_RAD: f32 = 0.02;
/// Neighbours that a normal is fitted to where there are no rings.
const TREE_NEIGHBOURS: usize = 30;
/// Neighbours that a point is linked with where there are no rings.
const TREE_LINKS: usize = 8;
/// Points that are linked where there are no rings are nearer than this to each other, m.
const TREE_LINK_M: f64 = 0.25;

/// Points and their surroundings.
pub(super) struct Field {
    /// Coordinates in V, m.
    pub points: Vec<[f32; 3]>,
    /// Distance from the sensor, m.
    pub range: Vec<f32>,
    /// Ring of every point; empty where there are none.
    pub ring: Vec<u16>,
    /// Index of every point in the cloud it comes from.
    pub source: Vec<u32>,
    /// Unit normals toward the sensor; NaN where there is none.
    pub normal: Vec<[f32; 3]>,
    /// How well the neighbours' normals agree, at most 1; less than 0 where little is known.
    pub coherence: Vec<f32>,
    /// For every point `per_point` neighbours it is linked with, [`NONE`] where there are fewer.
    pub links: Vec<u32>,
    /// Links a point.
    pub per_point: usize,
}

impl Field {
    /// Points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Puts points in the order in which their normals agree with those around, the best first.
    pub fn sort_by_coherence(&self, points: &mut [u32]) {
        points.sort_by(|&a, &b| {
            let (qa, qb) = (self.coherence[a as usize], self.coherence[b as usize]);
            qb.total_cmp(&qa).then(a.cmp(&b))
        });
    }

    /// A point in V, m.
    pub fn point(&self, i: usize) -> Vector3<f64> {
        Vector3::from(self.points[i].map(f64::from))
    }

    /// The normal of a point, if it has one.
    pub fn normal(&self, i: usize) -> Option<Vector3<f64>> {
        let n = self.normal[i];
        n[0].is_finite().then(|| Vector3::from(n.map(f64::from)))
    }

    /// Its ring, if it has one.
    pub fn ring_of(&self, i: usize) -> Option<usize> {
        self.ring.get(i).map(|r| usize::from(*r))
    }

    /// The members that lie on one ring, ring by ring; none where there are no rings.
    pub fn runs<'a>(&self, members: &'a [u32]) -> Vec<&'a [u32]> {
        match self.ring.is_empty() {
            true => Vec::new(),
            false => (members.chunk_by(|&a, &b| self.ring[a as usize] == self.ring[b as usize]))
                .collect(),
        }
    }

    /// The field of points on rings.
    pub fn on_rings(rings: Rings) -> Self {
        let n = rings.len();
        let smooth = smoothed(&rings);
        let mut normal = vec![[f32::NAN; 3]; n];
        let mut coherence = vec![-1.0_f32; n];
        let mut links = vec![NONE; 2 * n];
        // The nearest point in the next filled ring, both ways.
        let mut above = vec![NONE; n];
        let mut below = vec![NONE; n];
        let filled: Vec<usize> = (0..rings.count())
            .filter(|&r| rings.starts[r] < rings.starts[r + 1])
            .collect();
        for pair in filled.windows(2) {
            let (lower, upper) = (pair[0], pair[1]);
            for (to, of, beside) in [(upper, lower, &mut above), (lower, upper, &mut below)] {
                let from = rings.starts[of];
                for (k, place) in rings.places_in(to, of).into_iter().enumerate() {
                    let gap = rings.azimuth[place as usize] - rings.azimuth[from + k];
                    if gap.abs() < ACROSS_RAD {
                        beside[from + k] = place;
                    }
                }
            }
        }
        for &ring in &filled {
            let (from, to) = (rings.starts[ring], rings.starts[ring + 1]);
            for i in from..to {
                if i + 1 < to {
                    links[2 * i] = (i + 1) as u32;
                } else if rings.closed {
                    links[2 * i] = from as u32;
                }
                links[2 * i + 1] = above[i];
                let (a, b) = (i.saturating_sub(REACH).max(from), (i + REACH).min(to - 1));
                let along = smooth[b] - smooth[a];
                let across = |j: u32, sign: f32| {
                    (j != NONE)
                        .then(|| along.cross(&((smooth[j as usize] - smooth[i]) * sign)))
                        .and_then(|n| n.try_normalize(1e-9))
                };
                let (up, down) = (across(above[i], 1.0), across(below[i], -1.0));
                let (n, agreement) = match (up, down) {
                    (Some(u), Some(d)) => ((u + d), u.dot(&d)),
                    (Some(one), None) | (None, Some(one)) => (one, -0.5),
                    (None, None) => continue,
                };
                let Some(n) = n.try_normalize(1e-6) else {
                    continue;
                };
                let toward = if n.dot(&smooth[i]) > 0.0 { -n } else { n };
                normal[i] = toward.into();
                coherence[i] = agreement;
            }
        }
        let points = (0..n)
            .map(|i| [rings.x[i], rings.y[i], rings.z[i]])
            .collect();
        Self {
            points,
            range: rings.range,
            ring: rings.ring,
            source: rings.source,
            normal,
            coherence,
            links,
            per_point: 2,
        }
    }

    /// The field of points of which no rings are known.
    ///
    /// # Errors
    /// [`Error::Neighbours`].
    pub fn of_points(points: Vec<[f32; 3]>, source: Vec<u32>) -> Result<Self, Error> {
        let wide: Vec<Point3<f64>> = points
            .iter()
            .map(|p| Point3::from(p.map(f64::from)))
            .collect();
        let near = neighbours(&wide, TREE_NEIGHBOURS)?;
        let found = normals(&wide, &near, TREE_NEIGHBOURS, &Vector3::zeros());
        let mut links = vec![NONE; TREE_LINKS * points.len()];
        for i in 0..points.len() {
            let others = near.of(i).iter().filter(|&&j| j as usize != i);
            for (slot, &j) in links[TREE_LINKS * i..]
                .iter_mut()
                .take(TREE_LINKS)
                .zip(others)
            {
                if (wide[j as usize] - wide[i]).norm() < TREE_LINK_M {
                    *slot = j;
                }
            }
        }
        let finite = |n: &Vector3<f64>| n.iter().all(|c| c.is_finite());
        Ok(Self {
            range: wide.iter().map(|p| p.coords.norm() as f32).collect(),
            ring: Vec::new(),
            source,
            normal: found
                .normals
                .iter()
                .map(|n| {
                    if finite(n) {
                        (*n).map(|c| c as f32).into()
                    } else {
                        [f32::NAN; 3]
                    }
                })
                .collect(),
            // A plane's curvature is near 0, a ball's ⅓.
            coherence: found
                .curvatures
                .iter()
                .map(|c| 1.0 - 3.0 * *c as f32)
                .collect(),
            links,
            per_point: TREE_LINKS,
            points,
        })
    }
}

/// The mean of every point and the [`SMOOTH`] on either side of it on its ring, where they lie at
/// about its range.
fn smoothed(rings: &Rings) -> Vec<Vector3<f32>> {
    let mut smooth = Vec::with_capacity(rings.len());
    for ring in 0..rings.count() {
        let (from, to) = (rings.starts[ring], rings.starts[ring + 1]);
        for i in from..to {
            let (a, b) = (i.saturating_sub(SMOOTH).max(from), (i + SMOOTH + 1).min(to));
            let (mut sum, mut count) = (Vector3::zeros(), 0.0_f32);
            let range = rings.range[i];
            for j in a..b {
                if (rings.range[j] - range).abs() < 0.03 * range + 0.03 {
                    sum += Vector3::new(rings.x[j], rings.y[j], rings.z[j]);
                    count += 1.0;
                }
            }
            smooth.push(sum / count.max(1.0));
        }
    }
    smooth
}
