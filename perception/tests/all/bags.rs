//! Bags: every way to send a scan gives the scan of the PNG, tf gives its pose, and no bag makes the reader
//! panic or allocate what it cannot hold.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use perception::{BagOptions, Error, Intrinsics, Scan, SensorOptions, parse_scan};
use proptest::prelude::*;

use crate::bag_files::*;
use crate::mutated_files::{edited, edits};
use crate::scan_files::png;

fn of(bag: BagOptions) -> SensorOptions {
    SensorOptions {
        bag,
        ..SensorOptions::default()
    }
}

fn read(bytes: &[u8]) -> Result<Scan, Error> {
    parse_scan(Path::new("a.mcap"), bytes, &SensorOptions::default())
}

fn refusal(bytes: &[u8], options: &SensorOptions) -> String {
    let error = parse_scan(Path::new("a.mcap"), bytes, options);
    let message = error.unwrap_err().to_string();
    assert!(message.starts_with("a.mcap: "), "{message}");
    message
}

fn from_png() -> Scan {
    let raw: Bytes = depths().iter().flat_map(|z| z.to_be_bytes()).collect();
    let [fx, fy, cx, cy] = K;
    let options = SensorOptions {
        intrinsics: Some(Intrinsics { fx, fy, cx, cy }),
        ..SensorOptions::default()
    };
    let png = png(SIZE.0, SIZE.1, png::BitDepth::Sixteen, &raw);
    parse_scan(Path::new("a.png"), &png, &options).unwrap()
}

#[test]
fn every_way_to_send_a_depth_image_gives_that_of_the_png() {
    let wanted = from_png().depth.unwrap();
    let units = depths();
    let big = units.iter().flat_map(|z| z.to_be_bytes()).collect();
    let wide = units.chunks(SIZE.0 as usize).flat_map(|row| {
        let row = row.iter().flat_map(|z| z.to_le_bytes());
        row.chain([9; 6])
    });
    let metres = units.iter().map(|z| match z {
        0 => f32::NAN,
        z => f32::from(*z) * 0.001,
    });
    for sent in [
        plain(START),
        image(START, "16UC1", true, 2 * SIZE.0, big),
        image(START, "mono16", false, 2 * SIZE.0 + 6, wide.collect()),
        image(
            START,
            "32FC1",
            false,
            4 * SIZE.0,
            metres.flat_map(f32::to_le_bytes).collect(),
        ),
        compressed(START, "16UC1; compressedDepth png", [0.0; 2], &units),
    ] {
        let bag = bag(&[info(START), sent]);
        for bytes in [packed(&bag, "zstd", zstd), packed(&bag, "lz4", lz4), bag] {
            assert_eq!(read(&bytes).unwrap().depth.unwrap(), wanted);
        }
    }

    // Inverse depths, quantised as compressed_depth_image_transport does: a step of q at 1.4 m is below 1 mm.
    let (depth_max, quantisation) = (10.0_f32, 100.0_f32);
    let a = quantisation * (quantisation + 1.0);
    let b = 1.0 - a / depth_max;
    let inverse = units.iter().map(|z| match z {
        0 => 0,
        z => (a / (f32::from(*z) * 0.001) + b) as u16,
    });
    let inverse: Vec<u16> = inverse.collect();
    let sent = compressed(START, "32FC1; compressedDepth png", [a, b], &inverse);
    let found = read(&bag(&[info(START), sent])).unwrap().depth.unwrap();
    for (found, wanted) in found.z_m.iter().zip(&wanted.z_m) {
        assert_eq!(*found > 0.0, *wanted > 0.0);
        assert!(
            (found - wanted).abs() <= wanted * wanted / a,
            "{found} {wanted}"
        );
    }
}

#[test]
fn a_cloud_is_that_of_the_image() {
    let wanted = from_png();
    let mut data = Vec::new();
    for [x, y, z] in &wanted.cloud.points {
        data.extend(x.to_le_bytes());
        data.extend(y.to_le_bytes());
        data.extend([7; 4]);
        data.extend(f64::from(*z).to_le_bytes());
    }
    let field = |name: &str, offset: u32, datatype: u8| (name.to_owned(), offset, datatype, 1_u32);
    let fields = vec![field("x", 0, 7), field("y", 4, 7), field("z", 12, 8)];
    let (width, height) = SIZE;
    let layout = (false, 20_u32, 20 * width, data, false);
    let message = cdr(&(header(START, FRAME), height, width, fields, layout));
    let sent = ("/points", "sensor_msgs/msg/PointCloud2", START, message);
    let scan = read(&bag(&[sent])).unwrap();
    let finite = |scan: &Scan| scan.cloud.finite().copied().collect::<Vec<_>>();
    assert_eq!(finite(&scan), finite(&wanted));
    assert_eq!(scan.depth.unwrap().z_m, wanted.depth.unwrap().z_m);
}

#[test]
fn tf_gives_the_pose_between_its_times() {
    let turn = |yaw: f64| UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
    let X_RV = Isometry3::from_parts(
        Translation3::new(0.1, 0.0, 0.4),
        UnitQuaternion::from_euler_angles(-2.0, 0.0, -std::f64::consts::FRAC_PI_2),
    );
    let X_WR = |s: f64| Isometry3::from_parts(Translation3::new(s, 0.0, 0.3), turn(0.2 * s));
    let base = |at: u64, s: f64| tf("/tf", at, "odom", "base", &X_WR(s));
    let X_MW = Isometry3::from_parts(Translation3::new(5.0, 0.0, 0.0), turn(0.0));
    let sent = [
        tf("/tf_static", START, "/base", FRAME, &X_RV),
        base(START, 0.0),
        base(START + S, 1.0),
        info(START),
        plain(START + S / 4),
        plain(START + 3 * S / 2),
        base(START + 2 * S, 2.0),
        base(START + 4 * S, 9.0),
        plain(START + 5 * S),
        tf("/tf_static", START, "map", "site", &X_MW),
    ];
    let bytes = bag(&sent);
    let at = |at_s, frame: Option<&str>| BagOptions {
        at_s: Some(at_s),
        frame: frame.map(str::to_owned),
        topic: None,
    };
    let near = |scan: &Scan, X: &Isometry3<f64>| {
        let off = scan.X_WV.inverse() * X;
        assert!(
            off.translation.vector.norm() < 1e-9 && off.rotation.angle() < 1e-9,
            "{off}"
        );
    };
    // By default the first; after the bag's first message, or by its clock.
    near(&read(&bytes).unwrap(), &(X_WR(0.25) * X_RV));
    let clock = START as f64 * 1e-9 + 1.4;
    for (at_s, frame) in [(1.4, None), (1.5, Some("/odom")), (clock, None)] {
        let scan = parse_scan(Path::new("a.mcap"), &bytes, &of(at(at_s, frame))).unwrap();
        near(&scan, &(X_WR(1.5) * X_RV));
        let said = scan.notes.join("\n");
        assert!(
            said.contains("at 1.500 s") && said.contains("\"odom\""),
            "{said}"
        );
    }
    // A frame of the robot is one only where it is asked for.
    let scan = parse_scan(Path::new("a.mcap"), &bytes, &of(at(1.5, Some("base")))).unwrap();
    near(&scan, &X_RV);
    // Past the last transform there is no pose.
    let scan = parse_scan(Path::new("a.mcap"), &bytes, &of(at(5.0, None))).unwrap();
    near(&scan, &Isometry3::identity());
    assert!(
        scan.notes
            .iter()
            .any(|note| note.contains("the last transform is 1.000 s older"))
    );
    for (frame, cause) in [
        ("odom", "the last transform is 1.000 s older"),
        ("moon", "no pose of \"depth_optical\" in \"moon\""),
    ] {
        assert!(refusal(&bytes, &of(at(5.0, Some(frame)))).contains(cause));
    }
    let said = refusal(&bytes, &of(at(1.5, Some("site"))));
    assert!(
        said.contains("tf knows it in depth_optical, base, odom"),
        "{said}"
    );
    assert!(refusal(&bytes, &of(at(9.0, None))).contains("9 s is not from 0.250 to 5.000 s"));
}

/// A flat wall before a lens that bends: what is read is what a pinhole sees.
#[test]
fn a_lens_is_taken_out() {
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let [fx, fy, cx, cy] = K;
    let (k1, k2) = (-0.2, 0.03);
    // z = 2 + x/2 at the place of the ray (x, y): found for each bent pixel by fixed-point iteration.
    let straight = |u: f64, v: f64| {
        let (bx, by) = ((u - cx) / fx, (v - cy) / fy);
        let (mut x, mut y) = (bx, by);
        for _ in 0..50 {
            let r2 = x * x + y * y;
            let radial = 1.0 + k1 * r2 + k2 * r2 * r2;
            (x, y) = (bx / radial, by / radial);
        }
        x
    };
    let depth = |x: f64| 2.0 / (1.0 - 0.5 * x);
    let bent = (0..width * height)
        .map(|i| depth(straight((i % width) as f64, (i / width) as f64)) as f32)
        .flat_map(f32::to_le_bytes);
    let sent = image(START, "32FC1", false, 4 * SIZE.0, bent.collect());
    let d = [k1, k2, 0.0, 0.0, 0.0];
    let of = |model: &str| bag(&[camera_info(START, SIZE, model, &d), sent.clone()]);
    let found = read(&of("plumb_bob")).unwrap().depth.unwrap();
    for (i, z) in found.z_m.iter().enumerate().filter(|(_, z)| **z > 0.0) {
        let x = ((i % width) as f64 - cx) / fx;
        // Half a pixel of the lens's is at most 1.5 half pixels here.
        let slope = (depth(x + 0.75 / fx) - depth(x - 0.75 / fx)).abs();
        assert!(
            (f64::from(*z) - depth(x)).abs() < slope,
            "{i}: {z} {}",
            depth(x)
        );
    }
    let measured = found.z_m.iter().filter(|z| **z > 0.0).count();
    assert!(measured > width * height * 9 / 10, "{measured}");
    let said = refusal(&of("thin_prism"), &SensorOptions::default());
    assert!(
        said.contains("\"thin_prism\"") && said.contains(TOPIC),
        "{said}"
    );
}

#[test]
fn what_is_no_scan_is_said_by_file_topic_and_cause() {
    let good = bag(&[info(START), plain(START)]);
    let (_, _, _, data) = plain(START);
    let text = ("/chatter", "std_msgs/msg/String", START, cdr(&"hello"));
    let named = |topic: &str| {
        of(BagOptions {
            topic: Some(topic.to_owned()),
            ..BagOptions::default()
        })
    };
    let broken = (TOPIC, "sensor_msgs/msg/Image", START, data[..90].to_vec());
    let lies = |width: u32, step: u32| {
        let message = (
            header(START, FRAME),
            4_000_000_000_u32,
            width,
            "16UC1",
            0_u8,
            step,
            data.clone(),
        );
        (TOPIC, "sensor_msgs/msg/Image", START, cdr(&message))
    };
    let rgb = image(START, "rgb8", false, 3 * SIZE.0, vec![0; 9216]);
    let rvl = compressed(START, "16UC1; compressedDepth rvl", [0.0; 2], &depths());
    let none = SensorOptions::default();
    let bomb = |size: u64| packed(&good, "zstd", move |records| (zstd(records).0, size));
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    let both = bag(&[plain(START), text.clone()]);
    let listed = "no /depth is in it; it holds /camera/depth/image_raw of \
         sensor_msgs/msg/Image (16UC1), 1 from 0.000 to 0.000 s; /chatter of std_msgs/msg/String, 1";
    let generic = SensorOptions {
        sensor: "generic".into(),
        ..none.clone()
    };
    let no_depths = "topic: /chatter has no depths";
    let asked = [
        (&both, named("/chatter"), no_depths),
        (&both, named("/depth"), listed),
        (&bag(&[plain(START)]), generic, "no intrinsics"),
    ];
    let is_said = |bytes: &[u8], options: &SensorOptions, wanted: &str| {
        let message = refusal(bytes, options);
        assert!(message.contains(wanted), "{wanted:?} is not in {message}");
    };
    asked
        .iter()
        .for_each(|(bytes, options, wanted)| is_said(bytes, options, wanted));
    let small = camera_info(START, (640, 480), "", &[]);
    let wide = lies(4_000_000_000, 8_000_000_000_u64 as u32);
    let topic = "/camera/depth/image_raw: ";
    let untyped = format!("{topic}message: a message is not of its type");
    let short = format!("{topic}data: 64x4000000000 pixels");
    let nothing = "no message is in it: it ends in the middle of a record";
    let sensor = "CameraInfo: is of 640x480 pixels";
    for (bytes, wanted) in [
        (bag(&[text]), "no topic has depth images or point clouds"),
        (
            bag(&[plain(START), rvl.clone()]),
            "more than one topic may be the scan",
        ),
        (bag(&[rvl]), "compressedDepth rvl"),
        (bag(&[rgb]), "(rgb8)"),
        (bag(&[broken]), &*untyped),
        (bag(&[wide]), "data: 4000000000x4000000000"),
        (bag(&[lies(64, 128)]), &*short),
        (bag(&[small, plain(START)]), sensor),
        (bag(&[]), "no message is in it"),
        (good[..200].to_vec(), nothing),
        (bomb(1 << 40), "chunk 1: "),
        (bomb(200 << 20), "chunk 1: "),
        (packed(&good, "brotli", zstd), "is packed by \"brotli\""),
        (packed(&good, "lz4", zstd), "cannot be unpacked (lz4)"),
        (flipped(4000), "has another checksum"),
    ] {
        is_said(&bytes, &none, wanted);
    }
    let message = parse_scan(Path::new("a.pcd"), b"VERSION .7", &named("/x")).unwrap_err();
    assert!(message.to_string().contains("of a ROS 2 bag"));

    // A recorder that was killed: what was whole is read, and said to be cut.
    let cut = read(&good[..good.len() - 40]).unwrap();
    assert!(cut.depth.is_some());
    let first = bag(&[
        info(START),
        plain(START),
        plain(START + S),
        plain(START + 2 * S),
    ]);
    let cut = read(&first[..first.len() * 2 / 3]).unwrap();
    assert!(
        cut.notes
            .iter()
            .any(|note| note.contains("ends in the middle of a record"))
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn mutated_bags_survive(edits in edits()) {
        for pack in [false, true] {
            match read(&edited(small(pack), &edits)) {
                Ok(scan) => assert!(scan.cloud.finite().next().is_some()),
                Err(error) => assert!(error.to_string().starts_with("a.mcap: "), "{error}"),
            }
        }
    }
}
