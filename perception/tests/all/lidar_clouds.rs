//! Clouds that are not a ramp ahead: turned, several and descending ramps, none, no ground, hardly a
//! point; and the real ones.

use std::path::Path;

use crate::ramps::{calibration, cloud, end_errors_m, mount, take, usual_mount};
use crate::support::shared;
use nalgebra::Isometry3;
use perception::lidar::{LidarCloud, LidarConfig, SlopeScan, detect, extract_planes};
use perception::{Error, parse_lidar, read_lidar};
use scenes::simulator::lidar::{RangeNoise, Sweep, Vlp16, pcap, pcd, sweep};
use scenes::worlds::slope::{Ramp, room};

fn ramp(angle_deg: f64, start_m: [f64; 2], ascent_deg: f64) -> Ramp {
    Ramp {
        angle_deg,
        start_m,
        ascent_deg,
        width_m: 1.2,
        length_m: 1.6,
    }
}

/// What is detected in a sweep, as the usual settings have it, its mount known.
fn found(sweep: &Sweep, X_WV: &Isometry3<f64>, rings: Option<&Sweep>) -> SlopeScan {
    let known = calibration(X_WV, rings);
    detect(&cloud(sweep), Some(&known), &LidarConfig::default()).unwrap()
}

#[test]
fn ramps_turned_to_the_sensor_are_found_with_their_direction() {
    for (ascent, start) in [
        (30.0, [2.0, -0.3]),
        (-30.0, [2.0, 0.4]),
        (55.0, [2.2, 0.3]),
        (90.0, [2.4, 0.9]),
    ] {
        let ramp = ramp(15.0, start, ascent);
        let X_WV = usual_mount();
        let sweep = take(&room("turned", &[ramp]), &X_WV, 3);
        let scan = found(&sweep, &X_WV, Some(&sweep));
        let [slope] = &scan.slopes[..] else {
            panic!("{ascent}°: {} slopes", scan.slopes.len());
        };
        let d = &slope.description;
        let found = d.psi_W.y.atan2(d.psi_W.x).to_degrees();
        println!(
            "{ascent}°: {found:.2}°, {:.2}°, ends {:?}",
            d.delta_rad.to_degrees(),
            end_errors_m(slope, &ramp)
        );
        assert!((found - ascent).abs() < 1.0, "{ascent}°: {found}°");
        assert!((d.delta_rad.to_degrees() - 15.0).abs() < 0.2);
        // Heading along the robot's x: less steep the more the ramp is turned.
        let expected = (15.0_f64.to_radians().tan() * ascent.to_radians().cos()).atan();
        assert!((d.stepping_angle_rad(0.0) - expected).to_degrees().abs() < 0.3);
        // A ramp seen from its side shows its edges worse.
        assert!(end_errors_m(slope, &ramp).iter().all(|e| *e < 0.06));
    }
}

#[test]
fn two_ramps_are_two_slopes() {
    let two = [ramp(12.0, [2.0, -1.2], 0.0), ramp(20.0, [2.2, 1.0], 10.0)];
    let X_WV = usual_mount();
    let sweep = take(&room("two", &two), &X_WV, 4);
    let scan = found(&sweep, &X_WV, None);
    let mut angles: Vec<f64> = scan
        .slopes
        .iter()
        .map(|s| s.description.delta_rad.to_degrees())
        .collect();
    angles.sort_by(f64::total_cmp);
    assert_eq!(angles.len(), 2, "{angles:?}");
    assert!(
        (angles[0] - 12.0).abs() < 0.3 && (angles[1] - 20.0).abs() < 0.3,
        "{angles:?}"
    );
    // Their faces, and the ground that is not under them, are a valid terrain.
    let faces = scan.faces();
    let named = |face: &&surfaces::Face, name: &str| face.id.as_str().starts_with(name);
    assert_eq!(faces.iter().filter(|f| named(f, "slope")).count(), 2);
    let grounds: Vec<_> = faces.iter().filter(|f| named(f, "ground")).collect();
    assert!(!grounds.is_empty());
    for (ground, slope) in grounds
        .iter()
        .flat_map(|g| scan.slopes.iter().map(move |s| (g, s)))
    {
        let d = &slope.description;
        let up = (d.p1_W.coords + d.p2_W.coords) / 2.0 + d.psi_W * 0.3;
        let p = ground.X_WF.inverse_transform_point(&up.into()).xy();
        assert!(
            !ground.region.contains(&p),
            "{} lies under a slope",
            ground.id
        );
    }
    surfaces::Terrain::new(faces, Vec::new()).unwrap();
}

#[test]
fn a_flat_room_has_no_slope() {
    for (seed, X_WV) in [
        usual_mount(),
        mount(0.0, 0.0, 0.0, 0.75),
        mount(-6.0, 15.0, 40.0, 0.6),
    ]
    .iter()
    .enumerate()
    {
        let sweep = take(&room("flat", &[]), X_WV, seed as u64);
        for known in [None, Some(calibration(X_WV, None))] {
            let scan = detect(&cloud(&sweep), known.as_ref(), &LidarConfig::default()).unwrap();
            assert!(scan.slopes.is_empty(), "{:?}", scan.slopes[0].description);
            assert!(scan.ground.seen);
        }
    }
}

#[test]
fn the_papers_sampling_and_filter_find_the_same_ramp() {
    let ramp = ramp(15.0, [2.0, 0.0], 0.0);
    let X_WV = usual_mount();
    let sweep = take(&room("one", &[ramp]), &X_WV, 6);
    let config = LidarConfig {
        as_published: true,
        ..LidarConfig::default()
    };
    let scan = detect(
        &cloud(&sweep),
        Some(&calibration(&X_WV, Some(&sweep))),
        &config,
    )
    .unwrap();
    assert_eq!(scan.slopes.len(), 1);
    assert!((scan.slopes[0].description.delta_rad.to_degrees() - 15.0).abs() < 0.2);
    // The plain distance takes away what is far, and only that.
    let kept: Vec<f32> = scan
        .source
        .iter()
        .map(|&i| {
            let [x, y, z] = cloud(&sweep).points_V[i as usize];
            (x * x + y * y + z * z).sqrt()
        })
        .take(1)
        .collect();
    assert!(!kept.is_empty() && scan.counts.kept < scan.counts.in_view);
}

#[test]
fn hardly_a_cloud_is_an_error_that_says_so() {
    let config = LidarConfig::default();
    let three = LidarCloud::from_points([[1.0, 0.0, -0.5], [1.5, 0.2, -0.5], [1.2, -0.4, -0.5]]);
    assert!(matches!(
        detect(&three, None, &config),
        Err(Error::NoGround { points: _ })
    ));
    let two = LidarCloud::from_points([[1.0, 0.0, -0.5], [f32::NAN; 3], [1.2, -0.4, -0.5]]);
    let message = detect(&two, None, &config).unwrap_err().to_string();
    assert!(
        message.contains("2 points") && message.contains("1 more"),
        "{message}"
    );
    assert!(detect(&LidarCloud::default(), None, &config).is_err());
    // A wall alone: no ground, unless a calibration says where it is.
    let wall = LidarCloud::from_points((0..6000).map(|i| {
        [
            3.0,
            0.04 * (i % 100) as f32 - 2.0,
            0.04 * (i / 100) as f32 - 0.6,
        ]
    }));
    assert!(matches!(
        detect(&wall, None, &config),
        Err(Error::NoGround { .. })
    ));
    let known = detect(
        &wall,
        Some(&calibration(&mount(0.0, 0.0, 0.0, 0.7), None)),
        &config,
    )
    .unwrap();
    assert!(!known.ground.seen && known.slopes.is_empty() && known.faces().is_empty());
    // All points in one place, or on one line.
    for step in [0.0, 0.01] {
        let line = LidarCloud::from_points((0..500).map(|i| [1.0 + step * i as f32, 0.0, -0.5]));
        assert!(detect(&line, None, &config).is_err());
    }
}

#[test]
fn a_ramp_without_ground_stands_on_the_calibrated_one() {
    let ramp = ramp(15.0, [1.6, 0.0], 0.0);
    let X_WV = usual_mount();
    let sweep = take(&room("one", &[ramp]), &X_WV, 7);
    let mut cloud = cloud(&sweep);
    // What is left is only what lies over the ground.
    let over = |p: &[f32; 3]| (X_WV * nalgebra::Point3::from(p.map(f64::from))).z > 0.06;
    let keep: Vec<bool> = cloud.points_V.iter().map(over).collect();
    let [mut points, mut rings, mut azimuths] = [0; 3].map(|_| keep.iter());
    cloud.points_V.retain(|_| *points.next().unwrap());
    cloud.ring.retain(|_| *rings.next().unwrap());
    cloud.azimuth_rad.retain(|_| *azimuths.next().unwrap());
    cloud.time_s.clear();
    let scan = detect(
        &cloud,
        Some(&calibration(&X_WV, Some(&sweep))),
        &LidarConfig::default(),
    )
    .unwrap();
    assert!(!scan.ground.seen);
    let [slope] = &scan.slopes[..] else {
        panic!("{} slopes", scan.slopes.len())
    };
    assert!((slope.description.delta_rad.to_degrees() - 15.0).abs() < 0.3);
    assert!(end_errors_m(slope, &ramp).iter().all(|e| *e < 0.03));
}

#[test]
fn packets_and_pcd_tell_the_same() {
    let ramp = ramp(15.0, [2.0, 0.0], 0.0);
    let sensor = Vlp16::default();
    let sweep = sweep(
        &room("one", &[ramp]).world(),
        &sensor,
        &usual_mount(),
        &RangeNoise::default(),
        1,
        1,
    );
    let from_pcd = parse_lidar(Path::new("a.pcd"), &pcd(&sweep), None).unwrap();
    let bytes = pcap(&sensor, &sweep);
    let from_pcap = parse_lidar(Path::new("a.pcap"), &bytes, None).unwrap();
    assert_eq!((from_pcap.sweeps, from_pcap.notes.len()), (1, 0));
    let key = |c: &LidarCloud, i: usize| (c.ring[i], (-c.azimuth_rad[i] * 1e4) as i64);
    let sorted = |c: &LidarCloud| {
        let mut order: Vec<usize> = (0..c.len()).collect();
        order.sort_by_key(|&i| key(c, i));
        order.into_iter().map(|i| c.points_V[i]).collect::<Vec<_>>()
    };
    let (a, b) = (sorted(&from_pcd.cloud), sorted(&from_pcap.cloud));
    assert_eq!(a.len(), b.len());
    for (p, q) in a.iter().zip(&b) {
        let d = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f32>().sqrt();
        let r = p.iter().map(|c| c * c).sum::<f32>().sqrt();
        // Half a step of range, half a hundredth of a degree, a tenth of a millimetre of height.
        assert!(d < 0.0012 + 1.2e-4 * r, "{p:?} {q:?}");
    }

    // Cut anywhere, or with any byte changed, it is read or refused, and nothing panics.
    for cut in [0, 10, 30, 100, 1300, bytes.len() - 7] {
        let _ = parse_lidar(Path::new("cut.pcap"), &bytes[..cut], None);
    }
    let short = parse_lidar(Path::new("cut.pcap"), &bytes[..bytes.len() - 7], None).unwrap();
    assert!(
        short.notes.iter().any(|n| n.contains("ends in the middle")),
        "{:?}",
        short.notes
    );
    let mut bad = bytes.clone();
    // The flag of the first packet's first block, and the product of the second.
    bad[24 + 16 + 42] = 0;
    bad[24 + 2 * (16 + 42 + 1206) - 1] = 0x21;
    let read = parse_lidar(Path::new("bad.pcap"), &bad, None).unwrap();
    assert!(
        read.notes.iter().any(|n| n.contains("0xffee")),
        "{:?}",
        read.notes
    );
    assert!(
        read.notes.iter().any(|n| n.contains("0x21")),
        "{:?}",
        read.notes
    );
    let message = parse_lidar(Path::new("a.pcap"), &bytes, Some(3))
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("a.pcap") && message.contains("sweep"),
        "{message}"
    );
    let mut none = bytes[..24].to_vec();
    none.extend(&bytes[24..24 + 16 + 42 + 900]);
    let message = parse_lidar(Path::new("none.pcap"), &none, None)
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("none.pcap"), "{message}");
}

/// The second returns of a packet in dual mode are points where they differ from the first.
#[test]
fn two_returns_of_a_beam_are_two_points() {
    let sensor = Vlp16::default();
    let sweep = sweep(
        &room("flat", &[]).world(),
        &sensor,
        &usual_mount(),
        &RangeNoise::none(),
        1,
        1,
    );
    let single = pcap(&sensor, &sweep);
    let (record, header) = (16 + 42 + 1206, 24);
    let mut dual = single[..header].to_vec();
    for packet in single[header..].chunks_exact(record) {
        // Every block twice, over two packets; the second time half a metre nearer.
        for half in 0..2 {
            let mut copy = packet.to_vec();
            for pair in 0..6 {
                let from = 58 + (6 * half + pair) * 100;
                for second in 0..2 {
                    let to = 58 + (2 * pair + second) * 100;
                    copy[to..to + 100].copy_from_slice(&packet[from..from + 100]);
                    for beam in (0..32).filter(|_| second == 1) {
                        let at = to + 4 + 3 * beam;
                        let range = u16::from_le_bytes([copy[at], copy[at + 1]]);
                        let nearer = if beam % 2 == 0 {
                            range.saturating_sub(250)
                        } else {
                            range
                        };
                        copy[at..at + 2].copy_from_slice(&nearer.to_le_bytes());
                    }
                }
            }
            copy[record - 2] = 0x39;
            dual.extend(copy);
        }
    }
    let one = parse_lidar(Path::new("one.pcap"), &single, None)
        .unwrap()
        .cloud;
    let two = parse_lidar(Path::new("two.pcap"), &dual, None)
        .unwrap()
        .cloud;
    let even = one.len() as f64 * 1.5;
    assert!(
        (two.len() as f64 - even).abs() < 0.1 * even,
        "{} of {}",
        two.len(),
        one.len()
    );
    // The first returns are where they were.
    let found = one
        .points_V
        .iter()
        .filter(|p| two.points_V.contains(p))
        .take(200)
        .count();
    assert_eq!(found, 200);
}

#[test]
fn a_real_sweep_of_a_room_shows_walls_and_no_slope() {
    let Some(path) = shared("lidar/nebula_vlp16_1673400472138016708.pcd") else {
        return;
    };
    let read = read_lidar(&path, None).unwrap();
    assert_eq!(read.cloud.len() + read.cloud.invalid, 14_831);
    assert_eq!(read.cloud.ring.iter().max(), Some(&15));
    let config = LidarConfig {
        view_rad: std::f64::consts::TAU,
        ..LidarConfig::default()
    };
    let survey = extract_planes(&read.cloud, &config).unwrap();
    let upright = survey
        .planes
        .iter()
        .filter(|p| p.plane.normal.z.abs() < 0.1)
        .count();
    println!(
        "{} planes, {upright} upright, ground {}",
        survey.planes.len(),
        survey.has_ground
    );
    for p in &survey.planes {
        println!(
            "  n {:?} d {:.2}, {} points, rms {:.1} mm",
            p.plane.normal,
            p.plane.offset_m,
            p.members.len(),
            1e3 * p.rms_m
        );
    }
    assert!(
        upright >= 2,
        "{upright} walls of {} planes",
        survey.planes.len()
    );
    match detect(&read.cloud, None, &config) {
        Ok(scan) => assert!(scan.slopes.is_empty(), "{:?}", scan.slopes[0].description),
        Err(error) => assert!(matches!(error, Error::NoGround { .. }), "{error}"),
    }
    // As the robot would carry it, its ground known.
    for height in [0.5, 0.75, 1.0] {
        let known = calibration(&mount(0.0, 0.0, 0.0, height), None);
        let scan = detect(&read.cloud, Some(&known), &config).unwrap();
        assert!(scan.slopes.is_empty(), "{:?}", scan.slopes[0].description);
    }
}
