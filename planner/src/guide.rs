//! The guide path and the potential around it.
//!
//! The path is a polyline of the base through W. A foot's *progress* is the path length of the
//! nearest path point once the foot's usual offset from the base is taken off: at the start every
//! foot has progress 0, at the goal every foot has the path's length.

use nalgebra::{Rotation3, Vector3};

use crate::Error;

/// A polyline that the base should roughly follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    points: Vec<Vector3<f64>>,
    /// Path length at each point, m.
    lengths: Vec<f64>,
}

/// Where a point is relative to the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Path length of the nearest path point, m.
    pub along_m: f64,
    /// Distance from it, m.
    pub aside_m: f64,
}

impl Guide {
    /// A path through points in W, m.
    ///
    /// # Errors
    /// [`Error::Guide`] with less than two points, a number that is not finite, or no length.
    pub fn new(points: Vec<Vector3<f64>>) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::Guide {
                reason: format!("{} points, need two", points.len()),
            });
        }
        if let Some(i) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(Error::Guide {
                reason: format!("point {i} is not finite"),
            });
        }
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            let last = lengths.last().copied().unwrap_or(0.0);
            lengths.push(last + (pair[1] - pair[0]).norm());
        }
        Ok(Self { points, lengths })
    }

    /// Length of the path, m.
    pub fn length_m(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The point after `along_m` of the path, and the heading there, rad; beyond the end the last
    /// point.
    pub fn at(&self, along_m: f64) -> (Vector3<f64>, f64) {
        let along = along_m.clamp(0.0, self.length_m());
        let mut i = 0;
        while i + 2 < self.points.len() && self.lengths[i + 1] < along {
            i += 1;
        }
        let edge = self.points[i + 1] - self.points[i];
        let length = (self.lengths[i + 1] - self.lengths[i]).max(1e-12);
        let t = ((along - self.lengths[i]) / length).clamp(0.0, 1.0);
        (self.points[i] + t * edge, self.heading(i))
    }

    /// Heading of edge `i`, rad; of the nearest edge with one where it is vertical.
    fn heading(&self, i: usize) -> f64 {
        let flat = |k: usize| {
            let e = self.points[k + 1] - self.points[k];
            (e.xy().norm() > 1e-9).then(|| e.y.atan2(e.x))
        };
        let edges = self.points.len() - 1;
        (0..edges)
            .min_by_key(|&k| (flat(k).is_none(), k.abs_diff(i)))
            .and_then(flat)
            .unwrap_or(0.0)
    }

    /// Where a base position is relative to the path.
    pub fn progress(&self, p: &Vector3<f64>) -> Progress {
        let mut best = Progress {
            along_m: 0.0,
            aside_m: f64::INFINITY,
        };
        for i in 0..self.points.len() - 1 {
            let edge = self.points[i + 1] - self.points[i];
            let length2 = edge.norm_squared();
            let t = if length2 > 0.0 {
                (edge.dot(&(p - self.points[i])) / length2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let aside_m = (p - self.points[i] - t * edge).norm();
            if aside_m < best.aside_m {
                best = Progress {
                    along_m: self.lengths[i] + t * length2.sqrt(),
                    aside_m,
                };
            }
        }
        best
    }

    /// Progress of a foot whose usual place is at `offset` from the base (in the frame that looks
    /// along the path). Two passes: the heading at the first answer turns the offset.
    pub fn foot_progress(&self, foot: &Vector3<f64>, offset: &Vector3<f64>) -> Progress {
        let mut heading = self.at(self.progress(&(foot - offset)).along_m).1;
        let mut progress = Progress {
            along_m: 0.0,
            aside_m: 0.0,
        };
        for _ in 0..2 {
            let base = foot - Rotation3::from_axis_angle(&Vector3::z_axis(), heading) * offset;
            progress = self.progress(&base);
            heading = self.at(progress.along_m).1;
        }
        progress
    }

    /// Where a foot with that offset would be after `along_m` of the path.
    pub fn foot_at(&self, along_m: f64, offset: &Vector3<f64>) -> Vector3<f64> {
        let (base, heading) = self.at(along_m);
        base + Rotation3::from_axis_angle(&Vector3::z_axis(), heading) * offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Guide {
        Guide::new(vec![
            Vector3::zeros(),
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(1.0, 2.0, 0.0),
        ])
        .unwrap()
    }

    #[test]
    fn progress_runs_from_zero_to_the_length() {
        let guide = corner();
        assert_eq!(guide.length_m(), 3.0);
        assert_eq!(guide.progress(&Vector3::new(-1.0, 0.0, 0.0)).along_m, 0.0);
        assert_eq!(guide.progress(&Vector3::new(1.0, 5.0, 0.0)).along_m, 3.0);
        let beside = guide.progress(&Vector3::new(0.5, -0.25, 0.0));
        assert_eq!((beside.along_m, beside.aside_m), (0.5, 0.25));
    }

    #[test]
    fn a_foot_turns_with_the_path() {
        let guide = corner();
        let offset = Vector3::new(0.0, 0.1, -0.6);
        for along in [0.2, 0.6, 1.5, 2.9] {
            let foot = guide.foot_at(along, &offset);
            let progress = guide.foot_progress(&foot, &offset);
            assert!(
                (progress.along_m - along).abs() < 1e-9,
                "{along}: {progress:?}"
            );
            assert!(progress.aside_m < 1e-9);
        }
    }

    #[test]
    fn bad_paths_are_refused() {
        assert!(Guide::new(vec![Vector3::zeros()]).is_err());
        assert!(Guide::new(vec![Vector3::zeros(), Vector3::new(f64::NAN, 0.0, 0.0)]).is_err());
    }
}
