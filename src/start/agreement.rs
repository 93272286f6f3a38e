//! Does the ground that the scans show agree with the one under the feet?
//!
//! A robot that stands on the ground that it sees calibrates itself once more: both planes are met
//! through the sensor's mount, as in [`calibration::camera`]. With the plane as seen (normal n_S,
//! through the sensor's pose in W) and the one under the feet (normal n, point c),
//!
//!   e = (n × n_S along two level axes, n_S·(p_WV − o_S) − n·(p_WV − c)),   eᵀ Σ⁻¹ e ~ χ²(3),
//!
//! Σ the sum of what is known of the seen plane, of the mount and of the robot's pose. A mount that
//! is off, or a robot that is not where it is said to be, is told before its first step.

use calibration::camera::CameraConfig;
use nalgebra::{Isometry3, Matrix2x3, Matrix3, Matrix3x6, Matrix6, Point3, RowVector3, Vector3};
use scenes::scene_file::ScanSource;
use surfaces::{Face, Source, Terrain};

/// Surfaces that lean by more than this from the ground under the feet are not it, rad.
const LEAN_MAX_RAD: f64 = 0.12;

/// A level surface of a scan is the ground under the feet, well or badly placed, where its height
/// under the sensor is that of the ground under the feet up to this, m.
const HEIGHT_MAX_M: f64 = 0.04;
/// Disagreement of the two, in standard deviations, from which on it is told.
const TELL_SIGMAS: f64 = 4.0;

/// A sensor over the ground.
struct Sensor {
    /// Its place, m.
    p_WV: Point3<f64>,
    /// Covariance of its mount: (δθ, δp) about and along W's axes, rad, m.
    mount: Matrix6<f64>,
}

/// For every scan whose ground is not the one under the feet within its uncertainty, what is wrong.
///
/// `extracted` are the scans' surfaces, untouched; `feet` is the face under the feet; `mounts` gives
/// for every scan the covariance of its sensor's mount about W's axes, where there is one.
pub fn disagreements(
    extracted: &Terrain,
    scans: &[ScanSource],
    mounts: &[Option<Matrix6<f64>>],
    feet: &Face,
    robot: &CameraConfig,
) -> Vec<String> {
    let mut said = Vec::new();
    for (number, scan) in scans.iter().enumerate() {
        let eye = Point3::from(scan.eye_m.unwrap_or_default());
        let sensor = Sensor {
            p_WV: scan.X_WV() * eye,
            mount: mounts.get(number).copied().flatten().unwrap_or_default(),
        };
        let of_scan =
            |s: &&Face| s.source == Source::Scan && scan_of(s.id.as_str(), scans.len()) == number;
        let surfaces = extracted.faces.iter().filter(of_scan);
        let Some(floor) = floor(surfaces, feet, &sensor) else {
            continue;
        };
        let seen = Seen::new(floor, feet, &sensor, robot);
        if seen.sigmas() <= TELL_SIGMAS {
            continue;
        }
        let name = scan.depth.as_ref().or(scan.cloud.as_ref());
        let [lean, off] = seen.explained();
        said.push(format!(
            "warning: the ground that {} shows (surface {}) leans by {:.1}° from the one under the \
             feet and is {:.0} mm {} for its sensor; what is known of scan, mount and robot explains \
             {:.1}° and {:.0} mm: the sensor sits elsewhere than its mount says, or the robot does \
             not stand where the scene says",
            name.map_or("the scan", String::as_str),
            floor.id,
            seen.e.xy().norm().to_degrees(),
            1e3 * seen.e.z.abs(),
            if seen.e.z > 0.0 { "too low" } else { "too high" },
            lean.to_degrees(),
            1e3 * off,
        ));
    }
    said
}

/// The scan that first showed a surface, by its id: those of all scans but the first name theirs.
fn scan_of(id: &str, scans: usize) -> usize {
    let named = |number: &usize| id.starts_with(&format!("scan{number}-"));
    (1..scans).find(named).unwrap_or(0)
}

/// The largest surface that may be the ground under the feet by its lean, and by its height below
/// the sensor.
fn floor<'a>(
    surfaces: impl Iterator<Item = &'a Face>,
    feet: &Face,
    sensor: &Sensor,
) -> Option<&'a Face> {
    let wanted = feet.height_of(&sensor.p_WV);
    surfaces
        .filter(|s| {
            s.normal_W().dot(&feet.normal_W()) > LEAN_MAX_RAD.cos()
                && (s.height_of(&sensor.p_WV) - wanted).abs() <= HEIGHT_MAX_M
        })
        .max_by(|a, b| {
            let area = a.region.area().total_cmp(&b.region.area());
            area.then_with(|| b.id.cmp(&a.id))
        })
}

/// The disagreement and its covariance.
struct Seen {
    /// Rotation from the one normal to the other about W's x and y, rad; distance below the sensor,
    /// seen less wanted, m.
    e: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Seen {
    fn new(floor: &Face, feet: &Face, sensor: &Sensor, robot: &CameraConfig) -> Self {
        let (n, n_S, p) = (feet.normal_W(), floor.normal_W(), sensor.p_WV);
        let lean = n.cross(&n_S);
        let e = Vector3::new(lean.x, lean.y, floor.height_of(&p) - feet.height_of(&p));

        // The seen plane: rotations about x_S and y_S, offset along z_S.
        let level = Matrix2x3::<f64>::identity();
        let R_WS: Matrix3<f64> = floor.X_WF.rotation.to_rotation_matrix().into_inner();
        let lever = |from: &Isometry3<f64>| p.coords - from.translation.vector;
        let mut by_plane = Matrix3::zeros();
        let turns = R_WS * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0));
        by_plane.fixed_rows_mut::<2>(0).copy_from(&(level * turns));
        let mut below: RowVector3<f64> = n_S.cross(&lever(&floor.X_WF)).transpose() * turns;
        below[2] = -1.0;
        by_plane.fixed_rows_mut::<1>(2).copy_from(&below);
        let plane = floor.plane_covariance.unwrap_or_default();
        let plane = Matrix3::from_fn(|i, j| plane[i][j]);

        // The mount: it turns what is seen about the sensor, and moves the sensor over the feet.
        let mut by_mount = Matrix3x6::zeros();
        by_mount.fixed_view_mut::<2, 3>(0, 0).copy_from(&level);
        by_mount
            .fixed_view_mut::<1, 3>(2, 3)
            .copy_from(&-n.transpose());

        // The robot's pose: tilts about the feet turn what is seen and lift the sensor.
        let mut by_pose = Matrix3::identity();
        let lift = lever(&feet.X_WF).cross(&n);
        by_pose
            .fixed_rows_mut::<1>(2)
            .copy_from(&RowVector3::new(-lift.x, -lift.y, -1.0));
        let (tilt, height) = (robot.robot_tilt_sigma_rad, robot.robot_height_sigma_m);
        let pose = Matrix3::from_diagonal(&Vector3::new(tilt, tilt, height).map(|s| s * s));
        Self {
            e,
            covariance: by_plane * plane * by_plane.transpose()
                + by_mount * sensor.mount * by_mount.transpose()
                + by_pose * pose * by_pose.transpose(),
        }
    }

    /// √(eᵀ Σ⁻¹ e).
    fn sigmas(&self) -> f64 {
        match self.covariance.try_inverse() {
            Some(inverse) => self.e.dot(&(inverse * self.e)).max(0.0).sqrt(),
            None => f64::INFINITY,
        }
    }

    /// Standard deviations of lean (rad) and distance (m).
    fn explained(&self) -> [f64; 2] {
        let [x, y, z] = [0, 1, 2].map(|k| self.covariance[(k, k)]);
        [x.max(y).sqrt(), z.sqrt()]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    fn level(id: &str, at: Isometry3<f64>, half: f64, source: Source) -> Face {
        let face = Face::rectangle(id, at, [2.0 * half; 2]).unwrap();
        Face { source, ..face }
    }

    /// What is said of ground 1.5 m ahead, turned about a sensor 1 m high and then moved, with a
    /// mount known to (rad, m).
    fn said(pitch_deg: f64, up_m: f64, known: (f64, f64)) -> Vec<String> {
        let sensor = Isometry3::translation(0.5, 0.0, 1.0);
        let turn = UnitQuaternion::from_euler_angles(0.0, pitch_deg.to_radians(), 0.0);
        let about = sensor * turn * sensor.inverse();
        let at = Isometry3::translation(0.0, 0.0, up_m) * about;
        let mut floor = level(
            "s0",
            at * Isometry3::translation(1.5, 0.0, 0.0),
            0.8,
            Source::Scan,
        );
        floor.plane_covariance = Some([[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]]);
        // A block beside it is not the ground.
        let block = Isometry3::translation(1.5, 1.0, 0.1);
        let set = Terrain {
            faces: vec![level("s1", block, 1.0, Source::Scan), floor],
            obstacles: Vec::new(),
        };
        let scan: ScanSource = toml::from_str(
            "depth = \"a.png\"\nposition_m = [0.5, 0.0, 1.0]\nquat_xyzw = [0.0, 0.0, 0.0, 1.0]",
        )
        .unwrap();
        let feet = level("ground", Isometry3::identity(), 0.3, Source::Robot);
        let (turn, shift) = known;
        let spread = [turn, turn, turn, shift, shift, shift].map(|s| s * s);
        let mount = Matrix6::from_diagonal(&spread.into());
        let robot = CameraConfig::default();
        disagreements(&set, &[scan], &[Some(mount)], &feet, &robot)
    }

    #[test]
    fn only_what_nothing_explains_is_said() {
        let well = (0.001, 0.001);
        assert!(said(0.0, 0.0, well).is_empty());
        // Within the robot's own pose.
        assert!(said(0.3, 0.001, well).is_empty());
        for (pitch, up) in [(2.0, 0.0), (-2.0, 0.0), (0.0, 0.02), (2.0, 0.02)] {
            let words = said(pitch, up, well);
            let [words] = &words[..] else {
                panic!("{pitch}° {up} m: {words:?}")
            };
            assert!(words.contains("s0") && words.contains("a.png"), "{words}");
            let lean = format!("leans by {:.1}°", f64::abs(pitch));
            let off = format!("is {:.0} mm", 1e3 * up);
            assert!(words.contains(&lean) && words.contains(&off), "{words}");
            // A mount that is hardly known may be off like that.
            assert!(said(pitch, up, (0.03, 0.02)).is_empty());
        }
    }

    #[test]
    fn surfaces_belong_to_the_scan_that_showed_them_first() {
        assert_eq!(scan_of("s3", 2), 0);
        assert_eq!(scan_of("scan1-s3", 2), 1);
        assert_eq!(scan_of("scan12-s3", 13), 12);
        assert_eq!(scan_of("scan1-s3", 1), 0);
    }

    #[test]
    fn without_such_ground_nothing_is_said() {
        assert!(said(12.0, 0.0, (0.001, 0.001)).is_empty());
        assert!(said(0.0, 0.3, (0.001, 0.001)).is_empty());
    }
}
