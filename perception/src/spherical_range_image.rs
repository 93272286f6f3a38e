//! A cloud as a picture: its points by direction from where the sensor stood.
//!
//! Azimuth and elevation about the axis of V from which the points are farthest off, in cells as
//! large as the points are dense; of the points of a cell the nearest counts. Only what ends a face
//! at its edges is looked up here ([`crate::edges`]): no plane is fitted to these cells.

use nalgebra::{Point2, Point3, Vector2, Vector3};
use surfaces::EdgeKind;
use wide::{f32x8, i32x8};

use crate::density::is_dense;
use crate::edges::{self, NONE, Picture, PixelRay, Shown};
use crate::sensor::Noise;

/// Smallest side of a cell, rad; larger ones by twos, up to this many times as large.
const CELL_RAD: f64 = 0.004;
const DOUBLINGS_MAX: usize = 5;

/// One cell: its nearest point.
#[derive(Clone, Copy)]
struct Cell {
    /// Inverse range, 1/m; 0 where there is no point.
    w: f32,
    label: u16,
}

const EMPTY: Cell = Cell {
    w: 0.0,
    label: NONE,
};

/// The directions of a cloud, its points labelled by planes.
pub(crate) struct SphericalRangeImage<'a> {
    cells: Vec<Cell>,
    cols: usize,
    rows: usize,
    /// Azimuth and elevation of the first cell's corner, and the cells' side, rad.
    low: Vector2<f64>,
    side: f64,
    /// Index of the axis about which azimuths are counted.
    axis: usize,
    /// Unit normal n and distance d of each plane, n·p = d with p from the eye, m.
    planes: Vec<(Vector3<f64>, f64)>,
    range_max_m: f64,
    noise: &'a Noise,
}

impl<'a> SphericalRangeImage<'a> {
    /// `points` (not all of them need to be finite) have the label of their plane, [`NONE`] for none; those
    /// farther than `range_max_m` from the eye were not used.
    pub fn new(
        (points, labels): (&[[f32; 3]], &[u16]),
        eye_V: &Vector3<f64>,
        planes: Vec<(Vector3<f64>, f64)>,
        range_max_m: f64,
        noise: &'a Noise,
    ) -> Self {
        let axis = farthest_axis(points, eye_V);
        let mut found = Self {
            cells: Vec::new(),
            cols: 0,
            rows: 0,
            low: Vector2::zeros(),
            side: CELL_RAD,
            axis,
            planes,
            range_max_m,
            noise,
        };
        let mut bounds = [(f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY)); 2];
        let mut seen = Vec::with_capacity(points.len().div_ceil(8));
        for (p, n) in from_eye(points, eye_V) {
            let finite = n.is_finite();
            let angles = angles_of_eight([1, 2, 0].map(|k| p[(axis + k) % 3]));
            for ((low, high), angle) in bounds.iter_mut().zip(angles) {
                *low = finite.select(angle, *low).min(*low);
                *high = finite.select(angle, *high).max(*high);
            }
            let w = finite.select(f32x8::ONE / n.max(f32x8::splat(1e-6)), f32x8::ZERO);
            seen.push((angles, w));
        }
        let [(left, right), (below, above)] = bounds.map(|(low, high)| {
            let least = |of: f32x8| of.to_array().into_iter().fold(f32::INFINITY, f32::min);
            (least(low), -least(-high))
        });
        if !(left <= right && below <= above) {
            return found;
        }
        found.low = Vector2::new(left, below).map(f64::from);
        let cell = |angle: f32x8, low: f32| {
            ((angle - f32x8::splat(low)) * f32x8::splat(1.0 / CELL_RAD as f32)).fast_trunc_int()
        };
        let count = |low, high| cell(f32x8::splat(high), low).to_array()[0] as usize + 1;
        (found.cols, found.rows) = (count(left, right), count(below, above));
        found.cells = vec![EMPTY; found.cols * found.rows];
        for (([azimuth, elevation], w), labels) in seen.into_iter().zip(labels.chunks(8)) {
            let (x, y) = (cell(azimuth, left), cell(elevation, below));
            let at = (y * i32x8::splat(found.cols as i32) + x).to_array();
            for ((&label, at), w) in labels.iter().zip(at).zip(w.to_array()) {
                if w > 0.0 {
                    let cell = &mut found.cells[at as usize];
                    if w > cell.w {
                        *cell = Cell { w, label };
                    }
                }
            }
        }
        for _ in 0..DOUBLINGS_MAX {
            if is_dense(&found.cells, found.cols, |cell| cell.w > 0.0) {
                break;
            }
            found.coarsen();
        }
        found
    }

    /// The ray of a place, a unit vector.
    fn ray(&self, p: &Point2<f64>) -> Vector3<f64> {
        let azimuth = self.low.x + (p.x + 0.5) * self.side;
        let elevation = self.low.y + (p.y + 0.5) * self.side;
        let mut ray = Vector3::zeros();
        ray[(self.axis + 1) % 3] = azimuth.cos() * elevation.cos();
        ray[(self.axis + 2) % 3] = azimuth.sin() * elevation.cos();
        ray[self.axis] = elevation.sin();
        ray
    }

    /// A cell; `None` outside of the picture.
    fn cell(&self, [x, y]: [i32; 2]) -> Option<&Cell> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        let i = (x < self.cols).then(|| y * self.cols + x)?;
        self.cells.get(i)
    }

    /// The place of a point, in cells.
    fn place(&self, p: &Point3<f64>) -> Point2<f64> {
        let at = (angles_of(self.axis, &p.coords) - self.low) / self.side;
        Point2::new(at.x - 0.5, at.y - 0.5)
    }

    /// Cells twice as large.
    fn coarsen(&mut self) {
        let (cols, rows) = (self.cols.div_ceil(2), self.rows.div_ceil(2));
        let mut cells = vec![EMPTY; cols * rows];
        for (y, line) in self.cells.chunks_exact(self.cols).enumerate() {
            let to = &mut cells[y / 2 * cols..][..cols];
            for (two, to) in line.chunks(2).zip(to) {
                for cell in two {
                    if cell.w > to.w {
                        *to = *cell;
                    }
                }
            }
        }
        (self.cells, self.cols, self.rows) = (cells, cols, rows);
        self.side *= 2.0;
    }

    /// The kinds of the edges of a ring on the plane `label`: corners from the eye, and a direction
    /// out of the face at each edge, from its corner to the next.
    pub fn kinds(&self, label: u16, ring: &[Point3<f64>], out: &[Vector3<f64>]) -> Vec<EdgeKind> {
        let next = ring.iter().cycle().skip(1);
        let of_edge = |((a, b), out): ((&Point3<f64>, &Point3<f64>), &Vector3<f64>)| {
            // A straight line in space is none of cells: places are looked up one by one. A hundredth of the range
            // aside is a straight line of cells still.
            let place = |t: f64| self.place(&(a + (b - a) * t));
            let middle = a + (b - a) * 0.5;
            let aside = self.place(&(middle + out * (0.01 * middle.coords.norm())));
            let count = ((place(1.0) - place(0.0)).norm() / PLACES_APART).ceil() as usize;
            let count = count.clamp(1, PLACES_MAX);
            let out = PixelRay::new(&(aside - place(0.5)));
            // Outlines of clouds are not so exact that none of them goes under what rises at a fold.
            let kinds = edges::walks(self, label, count, place, &out).map(|walk| match walk.kind {
                EdgeKind::Fold => EdgeKind::Real,
                kind => kind,
            });
            EdgeKind::most(kinds)
        };
        ring.iter().zip(next).zip(out).map(of_edge).collect()
    }
}

/// The points from the eye and their distances, m, in eights: the last is filled up by what is no number. Of an eye far
/// off, as on a map, the part that is lost in 32 bits is taken off, too.
fn from_eye(
    points: &[[f32; 3]],
    eye_V: &Vector3<f64>,
) -> impl Iterator<Item = ([f32x8; 3], f32x8)> {
    let eye: [f32; 3] = eye_V.map(|c| c as f32).into();
    let rest: [f32; 3] = std::array::from_fn(|k| (eye_V[k] - f64::from(eye[k])) as f32);
    let (eights, left) = points.as_chunks::<8>();
    let last: [[f32; 3]; 8] =
        std::array::from_fn(|i| left.get(i).copied().unwrap_or([f32::NAN; 3]));
    let last = Some(last).filter(|_| !left.is_empty());
    eights.iter().copied().chain(last).map(move |eight| {
        let p: [f32x8; 3] = std::array::from_fn(|k| {
            f32x8::from(eight.map(|p| p[k])) - f32x8::splat(eye[k]) - f32x8::splat(rest[k])
        });
        (p, (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt())
    })
}

/// Index of the axis from which the points of a cloud lie farthest off.
fn farthest_axis(points: &[[f32; 3]], eye_V: &Vector3<f64>) -> usize {
    let mut sums = Vector3::<f64>::zeros();
    // Sums of few in 32 bits.
    for many in points.chunks(1024) {
        let mut sum = [f32x8::ZERO; 3];
        for (p, n) in from_eye(many, eye_V) {
            let is = n.is_finite() & n.simd_gt(f32x8::splat(1e-9));
            let one = is.select(f32x8::ONE / n, f32x8::ZERO);
            for (sum, p) in sum.iter_mut().zip(p) {
                *sum += is.select(p.abs() * one, f32x8::ZERO);
            }
        }
        sums += Vector3::from(sum.map(|sum| f64::from(sum.reduce_add())));
    }
    sums.imin()
}

/// Azimuths and elevations of eight points, rad: as [`angles_of`], to 32 bits.
///
/// From the side on which nothing is cut at half a turn for a camera that looks along an axis.
fn angles_of_eight([a, b, c]: [f32x8; 3]) -> [f32x8; 2] {
    [b.atan2(a), c.atan2((a * a + b * b).sqrt())]
}

/// Index of the axis from which points lie farthest off.
pub(crate) fn axis<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> usize {
    let unit = |p: &Vector3<f64>| p.abs().try_normalize(1e-9).unwrap_or_default();
    points.fold(Vector3::zeros(), |sum, p| sum + unit(p)).imin()
}

/// Azimuth and elevation of a point about an axis, rad.
pub(crate) fn angles_of(axis: usize, p: &Vector3<f64>) -> Vector2<f64> {
    let (a, b, c) = (p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]);
    Vector2::new(b.atan2(a), c.atan2(a.hypot(b)))
}

/// Places along an edge are this far apart, in cells, and no more of them are looked at.
const PLACES_APART: f64 = 2.0;
const PLACES_MAX: usize = 48;

impl Picture for SphericalRangeImage<'_> {
    fn at(&self, label: u16, pixel: [i32; 2]) -> Shown {
        match self.cell(pixel) {
            None => Shown::Outside,
            Some(cell) if cell.w <= 0.0 => Shown::Nothing,
            Some(cell) if cell.label == label => Shown::Face,
            Some(cell) => Shown::Other {
                w: cell.w.into(),
                label: cell.label,
                used: f64::from(cell.w) * self.range_max_m >= 1.0,
            },
        }
    }

    fn on(&self, label: u16, pixel: [i32; 2]) -> Option<f64> {
        let cell = self.cell(pixel).filter(|cell| cell.label == label)?;
        Some(f64::from(cell.w)).filter(|w| *w > 0.0)
    }

    fn plane(&self, label: u16, p: &Point2<f64>) -> Option<f64> {
        let (normal, distance) = self.planes.get(usize::from(label))?;
        Some(normal.dot(&self.ray(p)) / distance).filter(|w| *w > 0.0)
    }

    fn pixel_rad(&self) -> f64 {
        self.side
    }

    fn noise(&self) -> &Noise {
        self.noise
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sensor;

    /// Points a degree apart over a half space, as seen on a plane 1 m below that ends at x = 3 m,
    /// before a wall that meets it there or is 2 m behind.
    fn seen(wall_x: f64) -> Vec<(Vector3<f64>, u16)> {
        let mut points = Vec::new();
        for (azimuth, elevation) in
            (-40..=40).flat_map(|a| (-60..=10).map(move |e| (f64::from(a), f64::from(e))))
        {
            let (a, e) = (azimuth.to_radians(), elevation.to_radians());
            let ray = Vector3::new(a.cos() * e.cos(), a.sin() * e.cos(), e.sin());
            let floor = -1.0 / ray.z;
            let (t, label) = if ray.z < 0.0 && floor * ray.x <= 3.0 {
                (floor, 0)
            } else {
                (wall_x / ray.x, 1)
            };
            points.push((ray * t, label));
        }
        points
    }

    /// Those of an eye that is somewhere, in 32 bits, and their labels.
    fn from(eye_V: &Vector3<f64>, seen: &[(Vector3<f64>, u16)]) -> (Vec<[f32; 3]>, Vec<u16>) {
        let point = |p: &Vector3<f64>| <[f32; 3]>::from((p + eye_V).map(|c| c as f32));
        seen.iter().map(|(p, label)| (point(p), *label)).unzip()
    }

    #[test]
    fn a_floor_ends_at_a_wall_and_at_a_drop_and_is_cut_by_the_view() {
        let noise = Sensor::named("generic").unwrap().noise;
        let down = -Vector3::z();
        let eye_V = Vector3::new(100.03, -20.0, 0.7);
        for wall_x in [3.0, 5.0] {
            let planes = vec![(down, 1.0), (Vector3::x(), wall_x)];
            let (points, labels) = from(&eye_V, &seen(wall_x));
            let directions =
                SphericalRangeImage::new((&points, &labels), &eye_V, planes, 20.0, &noise);
            let ring = [[2.9, -1.0], [2.9, 1.0], [0.7, 0.3], [0.7, -0.3]];
            let ring = ring.map(|[x, y]| Point3::new(x, y, -1.0));
            let sides = [Vector3::x(), Vector3::y(), -Vector3::x(), -Vector3::y()];
            let kinds = directions.kinds(0, &ring, &sides);
            assert_eq!(kinds[0], EdgeKind::Real, "{wall_x}");
            assert_eq!(kinds[2], EdgeKind::FieldOfView, "{wall_x}");
        }
        // A screen that stands before the floor's far part hides how it goes on.
        let mut points = seen(3.0);
        for (p, label) in &mut points {
            if *label == 0 && p.x > 2.0 {
                (*p, *label) = (*p * (1.0 / p.x), 2);
            }
        }
        let planes = vec![(down, 1.0), (Vector3::x(), 3.0), (Vector3::x(), 1.0)];
        let (mut points, mut labels) = from(&eye_V, &points);
        // What is not finite is no point.
        points.push([f32::NAN, 0.0, f32::INFINITY]);
        labels.push(2);
        let directions = SphericalRangeImage::new((&points, &labels), &eye_V, planes, 20.0, &noise);
        let ring = [[1.9, -0.5], [1.9, 0.5], [1.0, 0.0]].map(|[x, y]| Point3::new(x, y, -1.0));
        let kinds = directions.kinds(0, &ring, &[Vector3::x(), Vector3::y(), -Vector3::y()]);
        assert_eq!(kinds[0], EdgeKind::Occluded);
    }

    #[test]
    fn angles_are_those_of_single_points() {
        let signs = [-1.0_f64, -0.0, 0.0, 1.0];
        for (x, y, z) in signs.iter().flat_map(|x| {
            let rest = signs.iter().flat_map(|y| signs.iter().map(move |z| (y, z)));
            rest.map(move |(y, z)| (2.0 * x, 3.0 * y, 0.7 * z))
        }) {
            let expected: [f64; 2] = angles_of(2, &Vector3::new(x, y, z)).into();
            let got = angles_of_eight([x, y, z].map(|c| f32x8::splat(c as f32)));
            for (got, expected) in got.iter().zip(expected) {
                for got in got.to_array() {
                    assert!(
                        (f64::from(got) - expected).abs() < 1e-6,
                        "{x} {y} {z}: {got}"
                    );
                }
            }
        }
    }
}
