//! What stands around on the ground and is neither ground nor slope: walls, and things to keep
//! away from.
//!
//! Walls are planes that are steeper than slopes; all other points over the ground are gathered
//! into upright bodies. A sweep sees neither between its beams nor above and below them, so both
//! reach as far as the next beam would have been, and what the uppermost or lowest beam meets goes on
//! beyond it.

mod obstacle_cluster;
mod walls;

use nalgebra::{Isometry3, Point3, Vector3};
use surfaces::{ConvexPolygon, Face, Obstacle};

use super::config::LidarConfig;
use super::field::Field;
use super::plane::{Plane, RING_BIAS_SIGMA_M, variance};
use super::scan::SlopeScan;

pub use obstacle_cluster::gathered;

/// Points lower than this over the ground or a slope are its own, m.
const CLEAR_M: f64 = 0.05;
/// How far what the uppermost beam meets is taken to go on, m.
const BEYOND_M: f64 = 0.5;

/// What stands around, in W.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surroundings {
    /// Walls, the largest consensus set first; pieces of one wall beside each other.
    pub walls: Vec<Wall>,
    /// Things, from the nearest.
    pub things: Vec<ObstacleCluster>,
}

/// A wall, or the part of one between two openings.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// What was seen of it, convex: x_F level, y_F up. Its name is `wall0`, …
    pub face: Face,
    /// Distance of its plane from the sensor, m.
    pub distance_m: f64,
    /// Its width, m.
    pub width_m: f64,
    /// Heights over the ground between which it was seen, m.
    pub heights_m: [f64; 2],
    /// What may be there between the beams, above and below them.
    pub beyond: Obstacle,
}

/// Something that stands or hangs over the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleCluster {
    /// The body that was seen, with what is behind its visible side. Its name is `thing0`, …
    pub body: Obstacle,
    /// What may be above and below, where the uppermost or lowest beam meets it.
    pub beyond: Vec<Obstacle>,
    /// The middle of its points, m.
    pub centre_W: Point3<f64>,
    /// Its width across the ray, m.
    pub width_m: f64,
    /// Heights over the ground between which it was seen, m.
    pub heights_m: [f64; 2],
    /// Its points.
    pub points: usize,
}

impl Surroundings {
    /// What was seen of the walls.
    pub fn faces(&self) -> impl Iterator<Item = &Face> {
        self.walls.iter().map(|wall| &wall.face)
    }

    /// The bodies to keep away from beside those of the faces.
    pub fn obstacles(&self) -> impl Iterator<Item = &Obstacle> {
        let things = self.things.iter();
        let things = things.flat_map(|t| std::iter::once(&t.body).chain(&t.beyond));
        self.walls.iter().map(|wall| &wall.beyond).chain(things)
    }
}

/// Walls and things of a field, of which ground and slopes are known where there is a scan.
pub(super) fn surroundings(
    field: &Field,
    scan: Option<&SlopeScan>,
    config: &LidarConfig,
) -> Surroundings {
    let view = View::new(field, scan);
    // 1. What neither ground nor slopes explain.
    let mut free = view.over_all();
    // 2. Planes that are too steep for slopes.
    let walls = walls::walls(&view, &mut free, config);
    // 3. The rest, gathered.
    let things = obstacle_cluster::obstacle_clusters(&view, &free);
    Surroundings { walls, things }
}

/// Standard deviations of a point over ground or slope that its own error makes up.
const GATE_SIGMAS: f64 = 3.5;
/// Points this far beside a slope are taken for its own edge, m.
const BESIDE_M: f64 = 0.1;
/// Least angle between two rings where the cloud does not tell it, rad.
const STEP_RAD: f64 = 0.01;

/// The points in W, and how they were seen.
struct View<'a> {
    field: &'a Field,
    /// Pose of V in W; the identity where there is no ground.
    X_WV: Isometry3<f64>,
    ground_V: Option<Plane>,
    /// The slopes: frame on each, where it is in that, wider by its border, and its plane.
    slopes: Vec<(Isometry3<f64>, ConvexPolygon, Plane)>,
    /// The lowest and the uppermost ring.
    rings: Option<[u16; 2]>,
    /// Mean angle between neighbouring rings, rad.
    step_rad: f64,
}

impl<'a> View<'a> {
    fn new(field: &'a Field, scan: Option<&SlopeScan>) -> Self {
        let slopes = scan.map(|scan| {
            let wider = |(k, slope)| {
                let face = scan.slope_face(k, slope)?;
                let polygon = face.region.as_convex()?.grown(BESIDE_M);
                Some((face.X_WF, polygon, slope.plane_V))
            };
            scan.slopes.iter().enumerate().filter_map(wider).collect()
        });
        let mut view = Self {
            field,
            X_WV: scan.map_or_else(Isometry3::identity, |scan| scan.X_WV),
            ground_V: scan.map(|scan| scan.ground.plane_V),
            slopes: slopes.unwrap_or_default(),
            rings: None,
            step_rad: STEP_RAD,
        };
        let ends = (field.ring.iter().min(), field.ring.iter().max());
        if let (Some(&low), Some(&high)) = ends
            && low < high
        {
            let elevation = |ring: u16| {
                let of = (0..field.len()).filter(|&i| field.ring[i] == ring);
                let angles = of.map(|i| f64::from(field.points[i][2] / field.range[i]).asin());
                let (sum, n) = angles.fold((0.0, 0.0), |(s, n), a| (s + a, n + 1.0));
                sum / n
            };
            let span = elevation(high) - elevation(low);
            view.rings = Some([low, high]);
            view.step_rad = (span / f64::from(high - low)).max(STEP_RAD);
        }
        view
    }

    /// The points' places in W.
    fn in_W(&self, members: &[u32]) -> Vec<Point3<f64>> {
        let place = |&i: &u32| self.X_WV * Point3::from(self.field.point(i as usize));
        members.iter().map(place).collect()
    }

    /// The sensor's place in W.
    fn eye(&self) -> Point3<f64> {
        self.X_WV.translation.vector.into()
    }

    /// Height of a place of W over the ground, m; over the sensor where there is no ground.
    fn height(&self, p_W: &Point3<f64>) -> f64 {
        let p_V = self.X_WV.inverse_transform_point(p_W);
        self.ground_V
            .map_or(p_W.z, |plane| plane.distance(&p_V.coords))
    }

    /// Whether a point is over the ground and over all slopes. What is below a slope is under its own
    /// body.
    fn over_all(&self) -> Vec<bool> {
        let over = |p: &Vector3<f64>, plane: &Plane, height: f64| {
            let n_u = plane.normal.dot(p) / p.norm();
            let bias = n_u * RING_BIAS_SIGMA_M;
            let variance = variance(n_u, p.norm()) + bias * bias;
            height > CLEAR_M + GATE_SIGMAS * variance.sqrt()
        };
        let free = |i: usize| {
            let p = self.field.point(i);
            let ground = self.ground_V.iter();
            ground
                .clone()
                .all(|plane| over(&p, plane, plane.distance(&p)))
                && self.slopes.iter().all(|(X_WF, polygon, plane)| {
                    let p_F = X_WF.inverse_transform_point(&(self.X_WV * Point3::from(p)));
                    over(&p, plane, p_F.z) || !polygon.contains(&p_F.xy(), 0.0)
                })
        };
        (0..self.field.len()).map(free).collect()
    }

    /// Whether the lowest and the uppermost beam meet one of these points.
    fn ends(&self, members: &[u32]) -> [bool; 2] {
        let meets = |ring: u16| {
            let mut of = members.iter().map(|&i| self.field.ring[i as usize]);
            of.any(|other| other == ring)
        };
        self.rings.map_or([false; 2], |rings| rings.map(meets))
    }

    /// How far beside the farthest of these points the next beam above or below passes, m.
    fn gap_m(&self, members: &[u32]) -> f64 {
        let ranges = members.iter().map(|&i| self.field.range[i as usize]);
        f64::from(ranges.fold(0.0, f32::max)) * self.step_rad
    }
}

/// An upright box: along the level unit vector `u`, across it to the left, and in z, each from … to,
/// m.
struct Upright {
    u: Vector3<f64>,
    along: [f64; 2],
    across: [f64; 2],
    z: [f64; 2],
}

impl Upright {
    fn corners_W(&self) -> Vec<Point3<f64>> {
        let v = Vector3::z().cross(&self.u);
        let corner = |a: f64, b: f64, h: f64| Point3::from(self.u * a + v * b + Vector3::z() * h);
        let mut points = Vec::with_capacity(8);
        for h in self.z {
            let level = |a: &f64| self.across.map(|b| corner(*a, b, h));
            points.extend(self.along.iter().flat_map(level));
        }
        points
    }

    /// Whether a place is inside or nearer than `border_m` to each side.
    fn holds(&self, p_W: &Point3<f64>, border_m: f64) -> bool {
        let v = Vector3::z().cross(&self.u);
        let at = [self.u.dot(&p_W.coords), v.dot(&p_W.coords), p_W.z];
        let within =
            |([low, high], x): ([f64; 2], f64)| (low - border_m..=high + border_m).contains(&x);
        [self.along, self.across, self.z]
            .into_iter()
            .zip(at)
            .all(within)
    }
}

fn obstacle(
    id: String,
    points_W: Vec<Point3<f64>>,
    surface: Option<String>,
    seen: bool,
) -> Obstacle {
    Obstacle {
        id,
        points_W,
        surface,
        assumed: !seen,
    }
}

/// Least and greatest of the values; (∞, −∞) of none.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}
