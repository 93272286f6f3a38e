//! The pose of a single scan from what it shows: up from the planes that people walk on, the height over
//! the nearest of them, the heading of the sensor itself.
//!
//! Floors, treads and tables share their normal, and no other direction of a room has so much area that
//! a sensor on a robot would see from above. Where gravity was measured it says which planes these are,
//! and the planes say it more exactly.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use surfaces::{EdgeKind, Face, Ring};

use crate::{Config, Error, Scan, extract};

/// Planes whose normals lie nearer than this are parallel, rad: small treads, seen at a flat angle.
const PARALLEL_RAD: f64 = 0.07;
/// How far up may be from what was measured of it, rad.
const MEASURED_RAD: f64 = 0.15;
/// How a robot carries its sensor: looking up by at most the first and down by at most the second,
/// rolled by at most the third, rad.
const LOOKS_UP_RAD: f64 = 0.35;
const LOOKS_DOWN_RAD: f64 = 1.4;
const ROLLED_RAD: f64 = 0.7;
/// The ground has at least this part of the area of the largest level face.
const GROUND_PART: f64 = 0.1;

/// Where a sensor is over the ground that it sees.
#[derive(Clone, Debug)]
pub struct GroundPose {
    /// Pose of V in W: W's origin on the ground below the sensor, x horizontally ahead, z up.
    pub X_WV: Isometry3<f64>,
    /// Area of the faces that are level by it, and of all faces, m².
    pub level_m2: [f64; 2],
}

impl GroundPose {
    /// Height over the ground, m.
    pub fn height_m(&self) -> f64 {
        self.X_WV.translation.z
    }

    /// How far the optical axis looks down, rad.
    pub fn looks_down_rad(&self) -> f64 {
        let ahead_W = self.X_WV.rotation * Vector3::z();
        (-ahead_W.z).clamp(-1.0, 1.0).asin()
    }
}

/// The pose of a scan over the ground that it shows; `up_V` is what an accelerometer at rest in the
/// sensor measures, in V, at any length.
///
/// # Errors
/// As [`extract`]; [`Error::NoLevelFace`] where no plane could be one to walk on.
pub fn ground_pose(
    scan: &Scan,
    up_V: Option<Vector3<f64>>,
    config: &Config,
) -> Result<GroundPose, Error> {
    let faces = extract(scan, &Isometry3::identity(), config)?.faces;
    let area = |face: &&Face| face.region.area();
    let planes = faces
        .iter()
        .map(|face| (face.normal_W(), face.region.area()));
    let planes: Vec<_> = planes.collect();
    let Some((up_V, level_m2)) = up_by_planes(&planes, up_V) else {
        let other = up_V.is_none().then(|| otherwise(&planes, scan)).flatten();
        let hint = other.map_or(String::new(), |(up, area_m2)| {
            // Without a sign of zero.
            let [x, y, z]: [f64; 3] = up.map(|c| (100.0 * c).round() / 100.0 + 0.0).into();
            format!(
                "; its largest plane that may be level ({area_m2:.2} m²) is by --up {x},{y},{z}"
            )
        });
        let faces = faces.len();
        return Err(Error::NoLevelFace { faces, hint });
    };
    let level = |face: &&Face| face.normal_W().angle(&up_V) < PARALLEL_RAD;
    let group: Vec<&Face> = faces.iter().filter(level).collect();
    let all_m2 = planes.iter().map(|(_, area)| area).sum();

    // The ground is the level face nearest to below the sensor, of those that go on toward there where the view ends:
    // however small what is seen of it, steps, kerbs and levels beyond are not below the sensor.
    let eye_V = Point3::from(scan.eye_V);
    let near = group.iter().copied();
    let near: Vec<&Face> = near
        .filter(|face| goes_on_toward(face, &eye_V, &up_V))
        .collect();
    let group = if near.is_empty() { group } else { near };
    let largest_m2 = group.iter().map(area).fold(0.0, f64::max);
    let aside_m = |face: &&Face| {
        let off = |p: Point3<f64>| {
            let off = p - eye_V;
            (off - off.dot(&up_V) * up_V).norm()
        };
        face.vertices_W()
            .into_iter()
            .map(off)
            .fold(f64::INFINITY, f64::min)
    };
    let ground = group
        .iter()
        .filter(|face| area(face) >= GROUND_PART * largest_m2);
    let ground = ground.min_by(|a, b| aside_m(a).total_cmp(&aside_m(b)));
    let height_m = ground.map_or(0.0, |ground| ground.height_of(&eye_V));

    // W's axes in V.
    let ahead = [Vector3::z(), -Vector3::y()];
    let ahead = ahead.map(|axis| axis - axis.dot(&up_V) * up_V);
    let x_V = ahead[usize::from(ahead[0].norm() < 0.1)].normalize();
    let axes = Matrix3::from_columns(&[x_V, up_V.cross(&x_V), up_V]);
    let R_WV =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)).inverse();
    let eye_W = Vector3::new(0.0, 0.0, height_m);
    Ok(GroundPose {
        X_WV: Isometry3::from_parts((eye_W - R_WV * scan.eye_V).into(), R_WV),
        level_m2: [level_m2, all_m2],
    })
}

/// Under at least this angle about the place below the eye does the view cut a face that goes on toward there, rad: what
/// pixels make of other borders of the view is shorter.
const GOES_ON_RAD: f64 = 0.1;

/// Cosine of the angle to the way to the place below the eye within which the border of the view cuts it off, 75°: a wide
/// view's lower border is that much aside at its ends, its sides lead away.
const TOWARD: f64 = 0.26;

/// Whether the view cuts a face on the side toward the place below the eye.
fn goes_on_toward(face: &Face, eye: &Point3<f64>, up: &Vector3<f64>) -> bool {
    let outer = face.region.rings().iter().take(1).flat_map(Ring::segments);
    let cut = outer.filter(|(edge, _)| edge.kind == EdgeKind::FieldOfView);
    let angles = cut.map(|(_, ends)| {
        let [a, b] = ends.map(|p| face.point_W(p));
        // The interior is on the left of every edge; the length is the edge's.
        let out = (b - a).cross(&face.normal_W());
        let way = eye - nalgebra::center(&a, &b);
        let way = way - way.dot(up) * up;
        let along = out.dot(&way);
        if along > TOWARD * out.norm() * way.norm() {
            along / way.norm_squared()
        } else {
            0.0
        }
    });
    angles.sum::<f64>() > GOES_ON_RAD
}

/// Up in V by planes (normal toward the sensor in V, area in m²), and the area of those that are level
/// by it: of the directions that may be up, the one with the most area. `up_V` is what was measured of it.
pub fn up_by_planes(
    planes: &[(Vector3<f64>, f64)],
    up_V: Option<Vector3<f64>>,
) -> Option<(Vector3<f64>, f64)> {
    let likely = planes.iter().map(|(normal, _)| normal);
    let likely = likely.filter(|normal| match up_V {
        Some(up_V) => normal.angle(&up_V) < MEASURED_RAD,
        None => carried_so(normal),
    });
    let about = |up: &Vector3<f64>| {
        let near = planes
            .iter()
            .filter(|(normal, _)| normal.angle(up) < PARALLEL_RAD);
        let sums = near.map(|(normal, area)| (*area * normal, *area));
        sums.reduce(|a, b| (a.0 + b.0, a.1 + b.1))
    };
    let (sum, area_m2) = likely
        .filter_map(about)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some((sum.normalize(), area_m2))
}

/// Whether a robot would carry its sensor so that this is up, in V.
fn carried_so(up_V: &Vector3<f64>) -> bool {
    let rolled = up_V.x.atan2(-up_V.y).abs();
    looks_ahead(up_V) && rolled < ROLLED_RAD
}

/// Whether the sensor looks neither up nor straight down where this is up, in V.
fn looks_ahead(up_V: &Vector3<f64>) -> bool {
    let down = (-up_V.z).clamp(-1.0, 1.0).asin();
    down > -LOOKS_UP_RAD && down < LOOKS_DOWN_RAD
}

/// The plane with the most area that is level for a camera with any roll, or in any frame of a cloud, and its area.
fn otherwise(planes: &[(Vector3<f64>, f64)], scan: &Scan) -> Option<(Vector3<f64>, f64)> {
    let level = planes
        .iter()
        .filter(|(normal, _)| scan.depth.is_none() || looks_ahead(normal));
    level.max_by(|a, b| a.1.total_cmp(&b.1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DepthImage, Sensor};

    /// A floor and a wall 2 m ahead, seen from 1.2 m with a roll and a pitch (down), rad.
    #[allow(clippy::unwrap_used)]
    fn room(roll: f64, pitch: f64) -> (Scan, UnitQuaternion<f64>) {
        let sensor = Sensor::named("xtion").unwrap();
        let (width, height) = (320, 240);
        let intrinsics = sensor.intrinsics_for(width, height).unwrap();
        // z ahead, x to the right: W is x ahead, y left, z up.
        let level = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let level = UnitQuaternion::from_matrix(&level);
        let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -pitch);
        let R_WV = level * tilt * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll);
        let z_m = (0..width * height).map(|pixel| {
            let [u, v] = [pixel % width, pixel / width].map(|x| x as f64);
            let ray_V = Vector3::new(
                (u - intrinsics.cx) / intrinsics.fx,
                (v - intrinsics.cy) / intrinsics.fy,
                1.0,
            );
            let ray_W = R_WV * ray_V;
            let floor = if ray_W.z < 0.0 {
                -1.2 / ray_W.z
            } else {
                f64::INFINITY
            };
            let wall = if ray_W.x > 0.0 {
                2.0 / ray_W.x
            } else {
                f64::INFINITY
            };
            floor.min(wall) as f32
        });
        let depth = DepthImage {
            width,
            height,
            z_m: z_m.collect(),
            intrinsics,
        };
        (Scan::of_image(depth, sensor.noise), R_WV)
    }

    #[test]
    #[allow(clippy::unwrap_used)]
    fn the_floor_says_how_the_sensor_is_carried() {
        for (roll, pitch) in [(0.0, 0.7), (0.25, 0.5), (-0.4, 0.9)] {
            let (scan, R_WV) = room(roll, pitch);
            let found = ground_pose(&scan, None, &Config::default()).unwrap();
            let ahead_W = R_WV * Vector3::z();
            let heading =
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -ahead_W.y.atan2(ahead_W.x));
            let off = (heading * R_WV).angle_to(&found.X_WV.rotation);
            assert!(off < 2e-3, "{roll} {pitch}: {off}");
            assert!(
                (found.height_m() - 1.2).abs() < 3e-3,
                "{}",
                found.height_m()
            );
            assert!((found.looks_down_rad() - pitch).abs() < 3e-3);
        }
    }

    #[test]
    #[allow(clippy::unwrap_used)]
    fn what_gravity_says_decides_between_wall_and_floor() {
        let (scan, R_WV) = room(0.0, 0.3);
        // More of the wall is seen than of the floor, and measured up picks either.
        for up_W in [Vector3::new(0.05, 0.0, 1.0), Vector3::new(-1.0, 0.0, 0.05)] {
            let up_V = R_WV.inverse() * up_W;
            let found = ground_pose(&scan, Some(up_V), &Config::default()).unwrap();
            let off = (found.X_WV.rotation * up_V).angle(&Vector3::z());
            assert!(off < 0.06, "{off}");
        }
        let aside = Some(Vector3::x());
        let none = ground_pose(&scan, aside, &Config::default());
        assert!(matches!(none, Err(Error::NoLevelFace { .. })));
    }

    #[test]
    #[allow(clippy::unwrap_used)]
    fn what_would_be_up_in_a_sensor_on_its_side_is_said() {
        let (scan, R_WV) = room(std::f64::consts::FRAC_PI_2, 0.9);
        let said = ground_pose(&scan, None, &Config::default()).unwrap_err();
        let said = said.to_string();
        let (_, up) = said.split_once("--up ").unwrap();
        let (_, up) = up.rsplit_once("--up ").unwrap_or(("", up));
        let up: Vec<f64> = up.split(',').map(|x| x.parse().unwrap()).collect();
        let up = Vector3::new(up[0], up[1], up[2]);
        assert!((R_WV * up).angle(&Vector3::z()) < 0.02, "{said}");
        let found = ground_pose(&scan, Some(up), &Config::default()).unwrap();
        assert!((found.height_m() - 1.2).abs() < 3e-3);
    }
}
