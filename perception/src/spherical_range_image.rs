//! A cloud as a picture: its points by direction from where the sensor stood.
//!
//! Azimuth and elevation about the axis of V from which the points are farthest off, in cells as
//! large as the points are dense; of the points of a cell the nearest counts. Only what ends a face
//! at its edges is looked up here ([`crate::edges`]): no plane is fitted to these cells.

use nalgebra::{Point2, Point3, Vector2, Vector3};
use surfaces::EdgeKind;
use wide::f64x4;

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
    /// `points` are taken from the eye and have the label of their plane, [`NONE`] for none; those
    /// beyond `range_max_m` were not used.
    pub fn new(
        points: impl Iterator<Item = (Vector3<f64>, u16)>,
        planes: Vec<(Vector3<f64>, f64)>,
        range_max_m: f64,
        noise: &'a Noise,
    ) -> Self {
        let points: Vec<_> = points.collect();
        let axis = axis(points.iter().map(|(p, _)| p));
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
        let (mut low, mut high) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(-1e9));
        let mut seen = Vec::with_capacity(points.len());
        for four in points.chunks(4) {
            let point = |k: usize| &four[k.min(four.len() - 1)].0;
            let angles = found.angles([point(0), point(1), point(2), point(3)]);
            for ((p, label), angles) in four.iter().zip(angles) {
                (low, high) = (low.inf(&angles), high.sup(&angles));
                let w = (1.0 / p.norm().max(1e-6)) as f32;
                seen.push((angles, Cell { w, label: *label }));
            }
        }
        if !(low.x <= high.x && low.y <= high.y) {
            return found;
        }
        found.low = low;
        found.cols = ((high.x - low.x) / CELL_RAD) as usize + 1;
        found.rows = ((high.y - low.y) / CELL_RAD) as usize + 1;
        found.cells = vec![EMPTY; found.cols * found.rows];
        for (angles, seen) in seen {
            let at = (angles - low) / CELL_RAD;
            let cell = &mut found.cells[at.y as usize * found.cols + at.x as usize];
            if seen.w > cell.w {
                *cell = seen;
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

    /// Azimuth and elevation of four points, rad.
    fn angles(&self, points: [&Vector3<f64>; 4]) -> [Vector2<f64>; 4] {
        let each = |axis: usize| f64x4::from(points.map(|p| p[axis % 3]));
        let (a, b, c) = (each(self.axis + 1), each(self.axis + 2), each(self.axis));
        // From the side on which nothing is cut at half a turn for a camera that looks along an axis.
        let azimuths = b.atan2(a).to_array();
        let elevations = c.atan2((a * a + b * b).sqrt()).to_array();
        std::array::from_fn(|k| Vector2::new(azimuths[k], elevations[k]))
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
        let [angles, ..] = self.angles([&p.coords; 4]);
        let at = (angles - self.low) / self.side;
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

/// Index of the axis from which points lie farthest off.
pub(crate) fn axis<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> usize {
    let unit = |p: &Vector3<f64>| p.abs().try_normalize(1e-9).unwrap_or_default();
    points.fold(Vector3::zeros(), |sum, p| sum + unit(p)).imin()
}

/// Azimuth and elevation of a point about an axis, rad.
pub(crate) fn angles(axis: usize, p: &Vector3<f64>) -> Vector2<f64> {
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

    #[test]
    fn a_floor_ends_at_a_wall_and_at_a_drop_and_is_cut_by_the_view() {
        let noise = Sensor::named("generic").unwrap().noise;
        let down = -Vector3::z();
        for wall_x in [3.0, 5.0] {
            let planes = vec![(down, 1.0), (Vector3::x(), wall_x)];
            let directions =
                SphericalRangeImage::new(seen(wall_x).into_iter(), planes, 20.0, &noise);
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
        let directions = SphericalRangeImage::new(points.into_iter(), planes, 20.0, &noise);
        let ring = [[1.9, -0.5], [1.9, 0.5], [1.0, 0.0]].map(|[x, y]| Point3::new(x, y, -1.0));
        let kinds = directions.kinds(0, &ring, &[Vector3::x(), Vector3::y(), -Vector3::y()]);
        assert_eq!(kinds[0], EdgeKind::Occluded);
    }

    #[test]
    fn angles_are_those_of_single_points() {
        let noise = Sensor::named("generic").unwrap().noise;
        let directions = SphericalRangeImage::new(seen(3.0).into_iter(), Vec::new(), 20.0, &noise);
        let signs = [-1.0_f64, -0.0, 0.0, 1.0];
        for (x, y, z) in signs.iter().flat_map(|x| {
            let rest = signs.iter().flat_map(|y| signs.iter().map(move |z| (y, z)));
            rest.map(move |(y, z)| (2.0 * x, 3.0 * y, 0.7 * z))
        }) {
            let p = Vector3::new(x, y, z);
            let expected = angles(directions.axis, &p);
            for angles in directions.angles([&p; 4]) {
                assert!(
                    (angles - expected).iter().all(|x| x.abs() < 1e-12),
                    "{p} {angles}"
                );
            }
        }
    }
}
