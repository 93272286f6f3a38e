//! Ten mounts of a LiDAR, from packets to a plan.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, sweep};
use scenes::simulator::rng::Stream;
use scenes::worlds::slope::{PAPER, Ramp, room};

use crate::slope_command::{calibrated, ends_off_m};
use crate::support::program::{self, list, succeeds};

/// Roll and pitch up to 20°, drift up to 30°; the first exactly level, the second looks up, whose
/// ground normal has A < 0. Each is another device.
fn mounts() -> Vec<Isometry3<f64>> {
    let draw = Stream::new(23, 0);
    (0..10_u64)
        .map(|number| {
            let within = |k: u64, most: f64| most * (2.0 * draw.uniform(3 * number + k) - 1.0);
            let angles = match number {
                0 => [0.0; 3],
                1 => [3.0, -6.0, 7.0],
                _ => [within(0, 20.0), within(1, 20.0), within(2, 30.0)],
            };
            let [roll, pitch, yaw] = angles.map(f64::to_radians);
            let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.75), rotation)
        })
        .collect()
}

/// From a capture to a plan, by the files that the commands leave, for ten mounts: the rotation within
/// 0.1°; the ramp, where it is in view, within 0.15° and 30 mm; and a plan that is verified.
#[test]
fn ten_mounts_go_from_packets_to_a_plan() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let (sensor, noise, row) = (Vlp16::default(), RangeNoise::default(), &PAPER[2]);
    let (mut negative, mut found) = (0, Vec::new());
    for (number, pose) in mounts().iter().enumerate() {
        let take = |ramps: &[Ramp], seed: u64| {
            let world = room("room", ramps).world();
            sweep(&world, &sensor, pose, &noise, number as u64, seed)
        };
        let (flat, ramp) = (path("flat.pcap"), path("ramp.pcap"));
        std::fs::write(&flat, pcap(&sensor, &take(&[], 1))).expect("written");
        std::fs::write(&ramp, pcap(&sensor, &take(&[row.ramp()], 2))).expect("written");
        let (toml, json) = (path("lidar.toml"), path("slope.json"));

        // 1. The mount.
        calibrated(&flat, &toml);
        let written = program::read(&toml);
        let calibration: perception::lidar::LidarCalibration =
            toml::from_str(&written).expect("a calibration");
        let off = calibration.X_WV().rotation.angle_to(&pose.rotation);
        negative += usize::from((pose.rotation.inverse() * Vector3::z()).x < 0.0);
        assert!(off.to_degrees() < 0.1, "{number}: {}°", off.to_degrees());

        // 2. The ramp.
        succeeds("slope @ --calibration @ -o @", &[&ramp, &toml, &json]);
        let file = program::json(&json);
        let slopes = list(&file["slopes"]);
        assert!(slopes.len() <= 1, "{number}: {slopes:?}");
        let Some(slope) = slopes.first() else {
            continue;
        };
        let error = program::number(&slope["delta_deg"]) - row.angle_deg;
        assert!(error.abs() < 0.15, "{number}: {error}°");
        let off = ends_off_m(slope, &row.ramp());
        assert!(off < 0.03, "{number}: {off} m");
        found.push(number);

        // 3. A plan up it, the sensor over the robot's front.
        let out = path("plan");
        let line = "plan --scan @ --calibration @ -o @ --pose 0.36,0,0 --robot builtin:quadruped \
                    --goal 2.9,0 --set surfaces.roles.foot.tilt_max_rad=0.45";
        let said = succeeds(line, &[&ramp, &toml, &out]);
        assert!(said.contains("verified"), "{said}");
    }
    assert!(negative >= 3, "{negative} mounts with A < 0");
    assert!(found.len() >= 5 && found.starts_with(&[0, 1]), "{found:?}");
}
